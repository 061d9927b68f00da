//! A packet in every p-th cycle: gains and costs are those of the thesis' recursion with the age chain of such a schedule, they
//! do not depend on units, and p = 1 is the loop that sends always.

use gain_gen::{
    design::{DelayDistribution, Design},
    solve::{LoopProblem, Method, ScheduleReference, Schedules, schedule, solve},
};
use nalgebra::DMatrix;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use slqg::DefaultInput;

const STATES: usize = 3;
/// Loops that are compared for each default input.
const LOOPS: usize = 40;

fn numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(-1.0..1.0, count)
}

fn weight(root: &[f64], size: usize, floor: f64) -> DMatrix<f64> {
    let root = DMatrix::from_row_slice(size, size, &root[..size * size]);
    &root * root.transpose() + DMatrix::identity(size, size) * floor
}

fn problems(default_input: DefaultInput) -> impl Strategy<Value = (LoopProblem, usize)> {
    let matrices = (numbers(9), numbers(6), numbers(9), numbers(4));
    let link = (proptest::collection::vec(0u32..100, 1..6), 1u32..60);
    (matrices, link, 1..=2_usize, 1..=4_usize, 1..=6_usize).prop_map(
        move |((a, b, q, r), (weights, loss), inputs, length, period)| {
            let total = f64::from(weights.iter().sum::<u32>() + loss);
            let delays = weights.iter().map(|&weight| f64::from(weight) / total).collect();
            let problem = LoopProblem {
                a: DMatrix::from_row_slice(STATES, STATES, &a),
                b: DMatrix::from_row_slice(STATES, inputs, &b[..STATES * inputs]),
                q: weight(&q, STATES, 0.1),
                r: weight(&r, inputs, 0.2),
                link: DelayDistribution::new(delays).expect("a distribution"),
                length,
                default_input,
            };
            (problem, period)
        },
    )
}

/// Largest difference relative to the largest entry.
fn apart(found: &DMatrix<f64>, expected: &DMatrix<f64>) -> f64 {
    (found - expected).amax() / expected.amax().max(1e-9)
}

fn agrees(default_input: DefaultInput) {
    let mut runner = TestRunner::deterministic();
    let (mut compared, mut worst) = (0, 0.0_f64);
    while compared < LOOPS {
        let (problem, period) = problems(default_input).new_tree(&mut runner).expect("a problem").current();
        let Some(found) = schedule(&problem, period) else { continue };
        if found.mean_square_rate > 0.97 {
            // The dense recursion, which only steps, would take for ever.
            continue;
        }
        let expected = ScheduleReference::new(&problem, period, 1e-15).expect("it converges");
        for (ahead, expected) in expected.cost_to_go.iter().enumerate() {
            worst = worst.max(apart(&found.cost_to_go(ahead), expected));
        }
        worst = worst.max(apart(&found.law.lx, &expected.lx));
        assert!(worst < 1e-9, "{worst:e}: p = {period} of {problem:?}");
        compared += 1;
    }
    eprintln!("{default_input:?}: {compared} loops, worst relative difference {worst:.1e}");
}

#[test]
fn with_zero_default_input_on_random_plants() {
    agrees(DefaultInput::Zero);
}

#[test]
fn with_hold_default_input_on_random_plants() {
    agrees(DefaultInput::Hold);
}

fn pendulum(length: usize) -> Design {
    let mut design = Design::parse(include_str!("../../designs/pendulum_event.toml"), "pendulum_event.toml")
        .expect("a design");
    design.controller.sequence_length = length;
    design
}

#[test]
fn a_packet_in_every_cycle_is_the_loop_that_sends_always() {
    let design = pendulum(4);
    let problem = LoopProblem::of(&design);
    let (always, found) = (solve(&problem, Method::InFlight), schedule(&problem, 1).expect("a stable loop"));
    assert!(apart(&found.law.lx, &always.law.lx) < 1e-9);
    assert!(apart(&found.law.m, &always.law.m) < 1e-9);
    assert!((found.mean_square_rate - always.mean_square_rate).abs() < 1e-9);
    let noise = &design.plant.process_noise;
    assert!((found.control_cost(noise) / always.control_cost(noise) - 1.0).abs() < 1e-9);
}

#[test]
fn the_cheapest_schedules_of_the_pendulum_are_those_that_were_found_by_the_dense_recursion() {
    // Totals of 200 cycles, packets of 1000 included, the state known: from an implementation of the dense recursion in NumPy.
    for (length, period, expected) in
        [(1, 4, 50_131.0), (2, 6, 33_466.0), (4, 8, 25_099.0), (8, 12, 17_045.0)]
    {
        let design = pendulum(length);
        let noise = &design.plant.process_noise;
        let known = DMatrix::zeros(4, 4);
        let found = Schedules::of(&LoopProblem::of(&design), 1000.0, noise, &known).expect("a stable loop");
        assert_eq!(found.cheapest.period, period, "N = {length}");
        let total = 200.0 * found.costs.iter().map(|cost| cost.total()).fold(f64::INFINITY, f64::min);
        assert!((total - expected).abs() < 0.6, "N = {length}: {total} instead of {expected}");
    }
}

#[test]
fn other_units_of_states_and_inputs_change_no_period_and_no_cost() {
    let design = pendulum(4);
    let problem = LoopProblem::of(&design);
    let (noise, known) = (&design.plant.process_noise, DMatrix::zeros(4, 4));
    let d = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![1e3, 7.0, 57.3, 1e-2]));
    let inverse = d.clone().try_inverse().expect("units");
    let (unit, back) = (1e3, 1e-3);
    let other = LoopProblem {
        a: &d * &problem.a * &inverse,
        b: &d * &problem.b * back,
        q: &inverse * &problem.q * &inverse,
        r: &problem.r * (back * back),
        ..problem.clone()
    };
    let here = Schedules::of(&problem, 1000.0, noise, &known).expect("a stable loop");
    let there = Schedules::of(&other, 1000.0, &(&d * noise * &d), &known).expect("a stable loop");
    assert_eq!(here.cheapest.period, there.cheapest.period);
    for (here, there) in here.costs.iter().zip(&there.costs) {
        assert!((here.control / there.control - 1.0).abs() < 1e-8, "p = {}", here.period);
    }
    let gains = &there.cheapest.law.lx * &d * back;
    assert!(apart(&gains, &here.cheapest.law.lx) < 1e-8, "{unit}");
}

#[test]
fn rarer_packets_cost_the_loop_more() {
    let design = pendulum(6);
    let problem = LoopProblem::of(&design);
    let cost =
        |period| schedule(&problem, period).map(|found| found.control_cost(&design.plant.process_noise));
    let costs: Vec<f64> = (1..=8).map_while(cost).collect();
    assert_eq!(costs.len(), 8);
    assert!(costs.windows(2).all(|pair| pair[0] < pair[1]), "{costs:?}");
}
