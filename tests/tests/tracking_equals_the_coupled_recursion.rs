//! The feedforward of a task is the thesis' (Theorem 4.1), in every mode of the actuator; preview gains are what it settles to.

use gain_gen::{
    design::{DelayDistribution, Design, Preview},
    solve::{
        LoopProblem, Method, Tracked, preview_gains, set_point_gains, solve, tracking_reference,
        tracking_task,
    },
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use slqg::DefaultInput;

const STATES: usize = 3;
const INPUTS: usize = 2;
const OUTPUTS: usize = 2;

fn numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(-1.0..1.0, count)
}

fn weight(root: &[f64], size: usize, floor: f64) -> DMatrix<f64> {
    let root = DMatrix::from_row_slice(size, size, root);
    &root * root.transpose() + DMatrix::identity(size, size) * floor
}

/// A loop that follows two combinations of its three states.
fn cases() -> impl Strategy<Value = (LoopProblem, Tracked)> {
    let matrices = (numbers(9), numbers(6), numbers(4), numbers(4), numbers(6));
    let link = (proptest::collection::vec(0u32..100, 1..7), 1u32..60);
    (matrices, link, 1usize..=5, any::<bool>()).prop_map(
        |((a, b, q, r, z), (weights, loss), length, hold)| {
            let total = f64::from(weights.iter().sum::<u32>() + loss);
            let delays = weights.iter().map(|&weight| f64::from(weight) / total).collect();
            let z = DMatrix::from_row_slice(OUTPUTS, STATES, &z);
            let q = weight(&q, OUTPUTS, 0.1);
            let problem = LoopProblem {
                a: DMatrix::from_row_slice(STATES, STATES, &a),
                b: DMatrix::from_row_slice(STATES, INPUTS, &b),
                q: z.tr_mul(&(&q * &z)),
                r: weight(&r, INPUTS, 0.2),
                link: DelayDistribution::new(delays).expect("a distribution"),
                length,
                default_input: if hold { DefaultInput::Hold } else { DefaultInput::Zero },
            };
            let terminal_weight = &q * 3.0;
            (problem, Tracked { z, weight: q, terminal_weight, input: DMatrix::zeros(INPUTS, OUTPUTS) })
        },
    )
}

fn reference(cycles: usize) -> Vec<DVector<f64>> {
    let sample =
        |k: usize| DVector::from_vec(vec![(k as f64 * 0.37).sin() * 5.0, f64::from(u8::from(k % 11 < 4))]);
    (0..=cycles).map(sample).collect()
}

#[test]
fn on_random_loops_and_in_every_mode() {
    let mut runner = TestRunner::deterministic();
    let (mut compared, mut worst) = (0, 0.0_f64);
    while compared < 60 {
        let (problem, tracked) = cases().new_tree(&mut runner).expect("a case").current();
        if !solve(&problem, Method::InFlight).is_stabilising() {
            // Costs that explode leave nothing of either recursion's digits.
            continue;
        }
        compared += 1;
        let reference = reference(25);
        let task = tracking_task(&problem, &tracked, &reference).tracked.expect("a reference is followed");
        let (feedforward, sigma, constant) = tracking_reference(&problem, &tracked, &reference);
        let largest = feedforward.iter().flatten().map(DVector::amax).fold(1e-3, f64::max);
        for (found, modes) in task.feedforward.iter().zip(&feedforward) {
            for expected in modes {
                worst = worst.max((found - expected).amax() / largest);
            }
        }
        worst = worst.max((&task.state - &sigma).amax() / sigma.amax());
        worst = worst.max((task.constant - constant).abs() / constant.abs());
    }
    eprintln!("worst relative difference {worst:.1e}");
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn preview_gains_give_a_tasks_feedforward_away_from_its_ends() {
    let mut runner = TestRunner::deterministic();
    let (mut compared, mut worst) = (0, 0.0_f64);
    while compared < 40 {
        let (problem, tracked) = cases().new_tree(&mut runner).expect("a case").current();
        let solution = solve(&problem, Method::InFlight);
        if !solution.is_stabilising() || solution.mean_square_rate > 0.9 {
            continue;
        }
        let found = preview_gains(&problem, &solution, &tracked, Preview::Auto { tolerance: 1e-10 })
            .expect("a steady state");
        let gains = found.expect("short enough");
        let reference = reference(gains.samples + 420);
        let task = tracking_task(&problem, &tracked, &reference).tracked.expect("a reference is followed");
        let largest = task.feedforward.iter().map(DVector::amax).fold(1e-3, f64::max);
        // The law is steady hundreds of cycles before the end.
        for cycle in 0..20 {
            let samples = reference[cycle + 1..].iter().take(gains.samples).flat_map(|z| z.iter().copied());
            let steady = &gains.sequence * DVector::from_iterator(gains.sequence.ncols(), samples);
            worst = worst.max((steady - &task.feedforward[cycle]).amax() / largest);
        }
        compared += 1;
    }
    eprintln!("worst relative difference {worst:.1e}");
    assert!(worst < 1e-6, "{worst}");
}

#[test]
fn the_gains_of_a_set_point_that_needs_no_input_are_those_of_a_preview_that_stands_still() {
    let mut runner = TestRunner::deterministic();
    let mut compared = 0;
    while compared < 20 {
        let (problem, tracked) = cases().new_tree(&mut runner).expect("a case").current();
        let solution = solve(&problem, Method::InFlight);
        if !solution.is_stabilising() || solution.mean_square_rate > 0.9 {
            continue;
        }
        let preview = preview_gains(&problem, &solution, &tracked, Preview::Cycles(1));
        let preview = preview.expect("a steady state").expect("a number of samples is always met");
        let set_point =
            set_point_gains(&problem, &solution, &tracked, &DVector::zeros(OUTPUTS)).expect("a steady state");
        assert!(
            (&preview.sequence - &set_point.sequence).amax() < 1e-9 * set_point.sequence.amax().max(1e-3)
        );
        assert!(
            (&preview.displaced - &set_point.displaced).amax() < 1e-9 * set_point.displaced.amax().max(1e-3)
        );
        compared += 1;
    }
}

#[test]
fn preview_gains_of_the_pendulum_give_its_tasks_feedforward_away_from_the_ends() {
    for text in [
        include_str!("../../designs/pendulum_tracking.toml"),
        include_str!("../../designs/pendulum_tracking_bad.toml"),
    ] {
        let design = Design::parse(text, "design.toml").expect("a design");
        let (problem, tracked) = (LoopProblem::of(&design), Tracked::of(&design).expect("it tracks"));
        let solution = solve(&problem, Method::InFlight);
        let gains = preview_gains(&problem, &solution, &tracked, Preview::Auto { tolerance: 1e-9 });
        let gains = gains.expect("a steady state").expect("short enough");
        let tracking = design.tracking.as_ref().expect("it tracks");
        let at = |cycle| tracking.reference(cycle, design.plant.sample_time).expect("a reference");
        // The square wave and, long after, the end: second moments shrink by 0.966 a step.
        let reference: Vec<_> = (0..=gains.samples + 1500).map(at).collect();
        let task = tracking_task(&problem, &tracked, &reference).tracked.expect("a reference is followed");
        let largest = task.feedforward.iter().map(DVector::amax).fold(0.0, f64::max);
        for cycle in 0..500 {
            let samples = reference[cycle + 1..].iter().take(gains.samples).flat_map(|z| z.iter().copied());
            let steady = &gains.sequence * DVector::from_iterator(gains.sequence.ncols(), samples);
            let difference = (steady - &task.feedforward[cycle]).amax() / largest;
            assert!(difference < 1e-6, "{}, cycle {cycle}: {difference}", design.name);
        }
        eprintln!("{}: {} samples", design.name, gains.samples);
    }
}
