//! Over a channel that comes and goes, and for one that sends only what is worth it, other units of states and inputs change
//! nothing but units, as they do over independent packets.

use gain_gen::{
    design::{Design, MarkovLink},
    solve::{Knowledge, LoopProblem, Rollout, Situation, correlated, solve_channel},
};
use nalgebra::{DMatrix, DVector};
use slqg_tests::drawn::scaled;

/// Powers of ten of the units of both states and of the input.
const CHANGES: [[i32; 3]; 6] = [[0, 0, 0], [3, -3, 0], [-6, 2, 4], [9, 9, -9], [-9, 5, 7], [4, -8, 9]];
/// How far a number may be from itself in other units, relative to the largest of its table.
const SAME: f64 = 1e-9;

fn bursty() -> Design {
    let text = include_str!("../../designs/double_integrator_bursty.toml");
    Design::parse(text, "double_integrator_bursty.toml").expect("a design")
}

fn channel(design: &Design) -> &MarkovLink {
    design.network.controller_to_actuator.channel().expect("a channel")
}

/// The problem of `design` where `x = D z` and `u = E w`, with `D` and `E`.
fn told_in(design: &Design, change: [i32; 3]) -> (LoopProblem, DVector<f64>, DVector<f64>) {
    let unit = |power: i32| 10.0_f64.powi(power);
    let states = DVector::from_vec(vec![unit(change[0]), unit(change[1])]);
    let inputs = DVector::from_vec(vec![unit(change[2])]);
    let problem = LoopProblem::of(design);
    let per_state = states.map(f64::recip);
    let problem = LoopProblem {
        a: scaled(&problem.a, &per_state, &states),
        b: scaled(&problem.b, &per_state, &inputs),
        q: scaled(&problem.q, &states, &states),
        r: scaled(&problem.r, &inputs, &inputs),
        ..problem
    };
    (problem, states, inputs)
}

fn assert_same(what: &str, change: [i32; 3], found: &DMatrix<f64>, expected: &DMatrix<f64>) {
    let apart = (found - expected).amax() / expected.amax();
    assert!(apart <= SAME, "{what} with units of {change:?}: {apart:e} apart");
}

/// A gain in other units as one in those of the design: `E G (D, E, E, ..)^-1`.
fn restored(gain: &DMatrix<f64>, states: &DVector<f64>, inputs: &DVector<f64>) -> DMatrix<f64> {
    let rows = DVector::from_fn(gain.nrows(), |i, _| inputs[i % inputs.len()]);
    let columns = DVector::from_fn(gain.ncols(), |j, _| {
        if j < states.len() { 1.0 / states[j] } else { 1.0 / inputs[(j - states.len()) % inputs.len()] }
    });
    scaled(gain, &rows, &columns)
}

#[test]
fn gains_that_know_the_channel_are_the_same_in_other_units() {
    let design = bursty();
    let own = solve_channel(&told_in(&design, [0; 3]).0, channel(&design));
    for change in CHANGES {
        let (problem, states, inputs) = told_in(&design, change);
        let found = solve_channel(&problem, channel(&design));
        assert_eq!(found.outcome, own.outcome, "{change:?}");
        let per_state = states.map(f64::recip);
        for (found, own) in found.cost_to_go.iter().zip(&own.cost_to_go) {
            assert_same("cost", change, &scaled(found, &per_state, &per_state), own);
        }
        for state in 0..own.law.channel_states() {
            let (found, own) = (found.law.at(&[state]), own.law.at(&[state]));
            let m = DVector::from_element(own.m.nrows(), inputs[0]);
            assert_same("Lx", change, &restored(&found.lx, &states, &inputs), &own.lx);
            let none = DVector::from_element(own.m.ncols(), inputs[0].recip());
            assert_same("M", change, &scaled(&found.m, &m, &none), &own.m);
        }
    }
}

#[test]
fn what_it_costs_to_know_less_of_the_channel_is_the_same_in_other_units() {
    let mut design = bursty();
    design.set_sequence_length(3);
    let noise = &design.plant.process_noise;
    let own = correlated(&told_in(&design, [0; 3]).0, channel(&design), noise).expect("few modes");
    for change in CHANGES {
        let (problem, states, inputs) = told_in(&design, change);
        let per_state = states.map(f64::recip);
        let noise = scaled(noise, &per_state, &per_state);
        let found = correlated(&problem, channel(&design), &noise).expect("few modes");
        for knowledge in Knowledge::ALL {
            let (Some(found), Some(own)) = (found.with(knowledge), own.with(knowledge)) else {
                assert_eq!(found.with(knowledge).is_some(), own.with(knowledge).is_some(), "{change:?}");
                continue;
            };
            assert_eq!(found.mean_square_rate < 1.0, own.mean_square_rate < 1.0, "{change:?}");
            let cost = (found.control_cost / own.control_cost - 1.0).abs();
            assert!(cost <= SAME, "{} with units of {change:?}: {cost:e} apart", knowledge.name());
            for (found, own) in found.gains.iter().zip(&own.gains) {
                assert_same("gains", change, &restored(found, &states, &inputs), own);
            }
        }
    }
}

#[test]
fn what_sending_is_worth_is_the_same_in_other_units() {
    let mut design = bursty();
    design.set_sequence_length(3);
    let benefit = |change| {
        let (problem, states, inputs) = told_in(&design, change);
        let rollout = Rollout::new(&problem).expect("a loop that can be stabilised");
        rollout.benefit(&Situation {
            state: DVector::from_vec(vec![2.0 / states[0], -1.0 / states[1]]),
            sent: DVector::from_vec(vec![0.5, -0.3, 0.2]) / inputs[0],
            was_sent: vec![true, false],
            age: 0,
        })
    };
    let own = benefit([0; 3]);
    for change in CHANGES {
        let found = benefit(change);
        assert!((found / own - 1.0).abs() <= SAME, "{change:?}: {found}, not {own}");
    }
}
