//! The pendulum that follows a square wave costs what Theorem 4.1 d) says: +50 m, from 5 s on -50 m, 500 cycles, state known.

use gain_gen::{
    design::{Design, Link},
    solve::{LoopProblem, Tracked, tracking_task},
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    sample::{mean, standard_error},
};
use nalgebra::{DMatrix, DVector};

const GOOD: &str = include_str!("../../designs/pendulum_tracking.toml");
const BAD: &str = include_str!("../../designs/pendulum_tracking_bad.toml");
const STEPS: usize = 500;
const RUNS: usize = 1000;

/// The design with its state measured at once, and known at the start.
fn with_state_known(text: &str, length: usize) -> Design {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(length);
    let states = design.plant.states();
    design.plant.c = DMatrix::identity(states, states);
    design.plant.measurement_noise = DMatrix::identity(states, states) * 1e-18;
    design.plant.initial_covariance.fill(0.0);
    design.network.sensor_to_controller = Link::perfect();
    design.controller.scalar = gain_gen::design::DeviceScalar::F64;
    design
}

fn meets_theorem(text: &str, length: usize) {
    let design = with_state_known(text, length);
    let tracking = design.tracking.as_ref().expect("the design tracks");
    let reference: Vec<DVector<f64>> = (0..=STEPS)
        .map(|cycle| tracking.reference(cycle, design.plant.sample_time).expect("a reference"))
        .collect();
    assert_eq!((reference[249][0], reference[250][0]), (50.0, -50.0), "the square wave turns at 5 s");
    let tracked = Tracked::of(&design).expect("the design tracks");
    let task = tracking_task(&LoopProblem::of(&design), &tracked, &reference);
    let plant = &design.plant;
    let expected = task.control_cost(&plant.initial_mean, &plant.initial_covariance, &plant.process_noise);

    let plan = Plan { runs: RUNS, steps: STEPS, seed: 11 };
    let contender = Contender::new(Kind::SlqgTask, &design, STEPS).expect("a task");
    let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
    let costs = simulate.outcome().expect("it can be simulated").costs;
    let (found, error) = (mean(&costs), standard_error(&costs));
    eprintln!(
        "{}, N = {length}: {found:.0} +- {error:.0} simulated, {expected:.0} in closed form",
        design.name
    );
    assert!((found - expected).abs() <= 4.0 * error, "{found} +- {error} against {expected}");
    assert!(error < 0.01 * expected, "too few runs to tell");
}

#[test]
fn on_the_good_network_with_short_and_long_sequences() {
    meets_theorem(GOOD, 1);
    meets_theorem(GOOD, 4);
}

#[test]
fn on_the_bad_network() {
    meets_theorem(BAD, 4);
    meets_theorem(BAD, 6);
}
