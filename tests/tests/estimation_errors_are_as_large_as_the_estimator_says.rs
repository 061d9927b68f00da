//! The normalised estimation error squared is what it should be where every age is acknowledged, and how far it is off
//! where none is.

use gain_gen::design::{Acknowledgement, Design};
use host_sim::{
    closed_loop::{RunPlan, run},
    contender::{Contender, Kind},
    fitted::Fitted,
    sample::{mean, standard_error},
};
use slqg::estimator::Merging;

const EVALUATION: &str = include_str!("../../docs/evaluation.md");
const GOOD: &str = include_str!("../../designs/double_integrator.toml");
const BAD: &str = include_str!("../../designs/double_integrator_bad.toml");
const RUNS: u64 = 200;
const STEPS: usize = 200;
const STATES: f64 = 2.0;
/// Cycles until the start is forgotten.
const SETTLED: usize = 20;

/// Mean of `e' P^-1 e` over runs and cycles, with `e` the estimation error and `P` the covariance that the estimator claims;
/// and its standard error, over runs.
fn normalised(text: &str, acknowledgement: &Acknowledgement, merging: Merging) -> (f64, f64) {
    let mut design = Design::parse(text, "design.toml").expect("a design");
    design.set_sequence_length(4);
    // Rounding must not count as an error.
    design.controller.scalar = gain_gen::design::DeviceScalar::F64;
    design.network.acknowledgement = acknowledgement.clone();
    design.controller.estimator = Some(merging);
    let contender = Contender::new(Kind::Slqg, &design, STEPS).expect("a stabilised loop");
    let fitted = Fitted::<f64, 2, 1, 2>::new(&design, &contender);
    let one = |number| {
        let mut normalised = Vec::new();
        run(&fitted, &contender, RunPlan { steps: STEPS, seed: 5, run: number }, |snapshot| {
            let error = snapshot.state - snapshot.estimate.mean;
            if let Some(factor) = snapshot.estimate.covariance().cholesky() {
                normalised.push(error.dot(&factor.solve(&error)));
            }
        });
        mean(&normalised[SETTLED..])
    };
    let runs: Vec<f64> = (0..RUNS).map(one).collect();
    (mean(&runs), standard_error(&runs))
}

/// 95 % of all samples of this many runs would lie within so many standard errors.
const BOUND: f64 = 1.96;

/// Column widths depend on the other rows.
fn assert_shown(name: &str, (found, error): (f64, f64)) {
    let line = format!("{name} {found:.3} {error:.3}");
    eprintln!("{line}");
    let shown = EVALUATION.lines().any(|other| other.split_whitespace().eq(line.split_whitespace()));
    assert!(shown, "not in docs/evaluation.md: {line}");
}

#[test]
fn with_every_age_acknowledged_they_are() {
    for (name, text) in [("good instant", GOOD), ("bad instant", BAD)] {
        let (found, error) = normalised(text, &Acknowledgement::Instant, Merging::Single);
        assert!((found - STATES).abs() <= BOUND * error, "{found} +- {error}");
        assert_shown(name, (found, error));
    }
}

#[test]
fn without_acknowledgements_they_are_within_a_twentieth() {
    for (name, text) in [("good", GOOD), ("bad", BAD)] {
        for (spelled, merging) in
            [("single", Merging::Single), ("imm", Merging::Imm), ("gpb2", Merging::Gpb2)]
        {
            let (found, error) = normalised(text, &Acknowledgement::None, merging);
            assert!((0.95 * STATES..1.05 * STATES).contains(&found), "{name} {spelled}: {found} +- {error}");
            assert_shown(&format!("{name} none, {spelled}"), (found, error));
        }
    }
}
