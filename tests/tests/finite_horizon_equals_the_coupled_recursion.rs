//! Time-varying gains of the in-flight recursion are those of the coupled one, cycle by cycle, and cost what they say.

use gain_gen::{
    design::{DelayDistribution, Design},
    solve::{LoopProblem, finite_horizon, finite_horizon_reference},
};
use nalgebra::DMatrix;
use slqg::DefaultInput;
use slqg_tests::{ReferenceCase, relative_difference};

const CYCLES: usize = 25;

fn equal_in_every_cycle(problem: &LoopProblem, terminal: &DMatrix<f64>, name: &str) {
    let found = finite_horizon(problem, terminal, CYCLES);
    let (expected, cost) = finite_horizon_reference(problem, terminal, CYCLES);
    assert!(relative_difference(&found.cost_to_go[0], &cost) < 1e-11, "{name}");
    for (cycle, (law, gains)) in found.laws.iter().zip(&expected).enumerate() {
        for (mode, (gain, reference)) in law.mode_gains().iter().zip(gains).enumerate() {
            // Relative to the gains of the first cycle: those of the last ones vanish.
            let scale = expected[0][mode].amax().max(f64::MIN_POSITIVE);
            let difference = (gain - reference).amax() / scale;
            assert!(difference < 1e-10, "{name}: cycle {cycle}, mode {mode}: {difference:e}");
        }
    }
}

#[test]
fn finite_horizon_gains_equal_the_coupled_ones_on_every_reference_case() {
    for case in ReferenceCase::all() {
        let problem = case.problem();
        let heavy = &problem.q * 10.0;
        for (terminal, what) in [(&problem.q, "Q"), (&heavy, "10 Q"), (&(&problem.q * 0.0), "none")] {
            equal_in_every_cycle(&problem, terminal, &format!("{}, terminal {what}", case.name));
        }
    }
}

#[test]
fn finite_horizon_gains_equal_the_coupled_ones_where_the_loop_is_unstable_or_nothing_arrives_at_once() {
    let text = include_str!("../../designs/critical.toml");
    let critical = LoopProblem::of(&Design::parse(text, "critical.toml").expect("a design"));
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        for length in 1..=5 {
            let mut problem = LoopProblem { default_input, ..critical.with_length(length) };
            equal_in_every_cycle(
                &problem,
                &critical.q,
                &format!("critical, N = {length}, {default_input:?}"),
            );
            problem.link = DelayDistribution::new(vec![0.0, 0.5, 0.0, 0.3]).expect("a distribution");
            equal_in_every_cycle(
                &problem,
                &critical.q,
                &format!("q(0) = 0, N = {length}, {default_input:?}"),
            );
        }
    }
}
