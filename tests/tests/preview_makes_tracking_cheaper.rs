//! Knowing the reference ahead is worth something: the pendulum on the square wave, N = 1..6, both networks.
//!
//! In closed form for tasks, which exist for every length; simulated where the loop can go on for ever.

use gain_gen::{
    design::Design,
    solve::{LoopProblem, Tracked, tracking_task},
};
use host_sim::{
    contender::{Contender, ContenderError, Kind},
    monte_carlo::{Plan, Simulate},
};
use nalgebra::DVector;

const GOOD: &str = include_str!("../../designs/pendulum_tracking.toml");
const BAD: &str = include_str!("../../designs/pendulum_tracking_bad.toml");
const STEPS: usize = 500;

fn design(text: &str, length: usize) -> Design {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(length);
    design
}

#[test]
fn in_closed_form_for_every_length_on_both_networks() {
    for text in [GOOD, BAD] {
        let mut last = f64::INFINITY;
        for length in 1..=6 {
            let design = design(text, length);
            let tracking = design.tracking.as_ref().expect("the design tracks");
            let reference: Vec<DVector<f64>> = (0..=STEPS)
                .map(|cycle| tracking.reference(cycle, design.plant.sample_time).expect("a reference"))
                .collect();
            let tracked = Tracked::of(&design).expect("the design tracks");
            let task = tracking_task(&LoopProblem::of(&design), &tracked, &reference);
            let plant = &design.plant;
            let with =
                task.control_cost(&plant.initial_mean, &plant.initial_covariance, &plant.process_noise);
            let surprise = task.tracked.expect("a reference is followed").surprise;
            eprintln!("{}, N = {length}: {with:.5e} with preview, {surprise:.5e} more without", design.name);
            assert!(surprise > 0.0, "{} N = {length}", design.name);
            // Where the loop cannot be stabilised its noise costs 1e7 and more, beside which any reference is small.
            assert!(surprise > with || with > 1e7, "{} N = {length}", design.name);
            assert!(with < last, "longer sequences cost less: {}, N = {length}", design.name);
            last = with;
        }
    }
}

#[test]
fn simulated_where_the_loop_can_be_stabilised() {
    let plan = Plan { runs: 100, steps: STEPS, seed: 1 };
    let mut simulated = 0;
    for text in [GOOD, BAD] {
        for length in 1..=6 {
            let design = design(text, length);
            let costs = |kind| {
                let contender = Contender::new(kind, &design, STEPS)?;
                let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
                Ok::<_, ContenderError>(simulate.outcome().expect("it can be simulated").costs)
            };
            let Ok(with) = costs(Kind::Slqg) else {
                assert!(text == BAD && length < 4, "N_crit is 4 on the bad network");
                continue;
            };
            let without = costs(Kind::SlqgNoPreview).expect("the same gains");
            simulated += 1;
            // In every single run: both meet the same noise and the same packet fates.
            assert!(
                with.iter().zip(&without).all(|(with, without)| with < without),
                "{} N = {length}",
                design.name
            );
        }
    }
    assert_eq!(simulated, 9);
}
