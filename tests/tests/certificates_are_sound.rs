//! A certificate is given for every stable loop, and never for one that is not.

use gain_gen::{
    certificate::{Certificate, NotCertified, Rejected, certify, certify_gains},
    design::DelayDistribution,
    solve::{LoopProblem, Method, mean_square_rate, solve},
};
use nalgebra::DMatrix;
use proptest::{
    prelude::*,
    strategy::ValueTree,
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};
use rayon::prelude::*;
use slqg::DefaultInput;
use slqg_tests::ReferenceCase;

/// Designs drawn: enough that 100 of them can be stabilised.
const DRAWN: usize = 130;

fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0f64, rows * columns)
        .prop_map(move |entries| DMatrix::from_row_slice(rows, columns, &entries))
}

fn definite(size: usize) -> impl Strategy<Value = DMatrix<f64>> {
    matrix(size, size)
        .prop_map(move |root| &root * root.transpose() + DMatrix::<f64>::identity(size, size) * 0.01)
}

/// Delays of up to four steps, up to half of the packets lost.
fn link() -> impl Strategy<Value = DelayDistribution> {
    (prop::collection::vec(0.01..1.0f64, 1..=5), 0.0..0.5f64).prop_map(|(weights, loss)| {
        let sum: f64 = weights.iter().sum();
        let probabilities = weights.iter().map(|weight| weight / sum * (1.0 - loss)).collect();
        DelayDistribution::new(probabilities).expect("a distribution")
    })
}

/// Plants with a spectral radius between 0.5 and 1.3.
fn problem() -> impl Strategy<Value = LoopProblem> {
    (1..=3usize, 1..=2usize, 1..=4usize, any::<bool>()).prop_flat_map(|(states, inputs, length, hold)| {
        let plant = (matrix(states, states), 0.5..1.3f64);
        (plant, matrix(states, inputs), definite(states), definite(inputs), link()).prop_map(
            move |((shape, radius), b, q, r, link)| {
                let largest =
                    shape.complex_eigenvalues().iter().map(|value| value.norm()).fold(1e-3, f64::max);
                let default_input = if hold { DefaultInput::Hold } else { DefaultInput::Zero };
                LoopProblem { a: shape * (radius / largest), b, q, r, link, length, default_input }
            },
        )
    })
}

fn problems(seed: u8) -> Vec<LoopProblem> {
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    (0..DRAWN).map(|_| problem().new_tree(&mut runner).expect("a problem").current()).collect()
}

/// The gains moved by a factor on all of them, so far that the rate is between 1 and `1 + within`; `None` if no factor
/// tried leads there.
fn just_unstable(problem: &LoopProblem, gains: &[DMatrix<f64>], within: f64) -> Option<Vec<DMatrix<f64>>> {
    let scaled = |factor: f64| gains.iter().map(|gain| gain * factor).collect::<Vec<_>>();
    let rate = |factor: f64| mean_square_rate(problem, &scaled(factor));
    let (mut stable, mut unstable) = (1.0, 2.0);
    while rate(unstable) < 1.0 {
        (stable, unstable) = (unstable, 2.0 * unstable);
        if unstable > 1e3 {
            return None;
        }
    }
    for _ in 0..60 {
        if rate(unstable) <= 1.0 + within {
            return Some(scaled(unstable));
        }
        let middle = 0.5 * (stable + unstable);
        *(if rate(middle) < 1.0 { &mut stable } else { &mut unstable }) = middle;
    }
    None
}

#[test]
fn every_stable_reference_case_is_certified() {
    for case in ReferenceCase::all() {
        let problem = case.problem();
        let solution = solve(&problem, Method::InFlight);
        let certificate = certify(&problem, &solution).expect(&case.name);
        assert!(certificate.rate_bound() >= case.spectral_radius, "{}", case.name);
        assert!(certificate.rate_bound() <= 0.5 * (1.0 + case.spectral_radius) + 1e-9, "{}", case.name);
    }
}

#[test]
fn random_stable_loops_are_certified_and_the_rate_proved_is_no_less_than_the_true_one() {
    let certified: usize = problems(11)
        .par_iter()
        .filter_map(|problem| {
            let solution = solve(problem, Method::InFlight);
            if !solution.is_stabilising() {
                return None;
            }
            let certificate = certify(problem, &solution).unwrap_or_else(|why| panic!("{why}: {problem:?}"));
            assert!(certificate.rate_bound() >= solution.mean_square_rate - 1e-9, "{problem:?}");
            Some(1)
        })
        .sum();
    assert!(certified >= 100, "{certified}");
}

#[test]
fn no_unstable_loop_is_certified_whatever_is_claimed_of_its_rate() {
    let refused: usize = problems(12)
        .par_iter()
        .enumerate()
        .filter_map(|(number, problem)| {
            let solution = solve(problem, Method::InFlight);
            let within = [1e-6, 1e-4, 1e-2, 1.0][number % 4];
            let gains = just_unstable(problem, &solution.mode_gains(), within)?;
            for claimed in [0.5, 0.999, 1.0 - 1e-9] {
                let refusal = certify_gains(problem, &gains, claimed).expect_err("an unstable loop");
                assert!(matches!(refusal, NotCertified::Unstable { rate } if rate >= 1.0), "{problem:?}");
            }
            // Nor do the matrices of the stable loop prove anything about this one.
            if let Ok(certificate) = certify(problem, &solution) {
                let x = certificate.matrices().to_vec();
                assert!(Certificate::verify(problem, &gains, x).is_err(), "{problem:?}");
            }
            Some(1)
        })
        .sum();
    assert!(refused >= 50, "{refused}");
}

#[test]
fn a_certificate_with_one_entry_changed_is_refused() {
    let case = &ReferenceCase::all()[0];
    let problem = case.problem();
    let solution = solve(&problem, Method::InFlight);
    let gains = solution.mode_gains();
    let found = certify(&problem, &solution).expect("a certificate");
    let size = found.matrices()[0].nrows();
    for mode in 0..found.matrices().len() {
        for (row, column) in (0..size).flat_map(|row| (0..size).map(move |column| (row, column))) {
            let changed = |value: f64| {
                let mut x = found.matrices().to_vec();
                x[mode][(row, column)] = value;
                Certificate::verify(&problem, &gains, x)
            };
            let entry = found.matrices()[mode][(row, column)];
            assert_eq!(changed(f64::NAN), Err(Rejected::NotFinite));
            if row == column {
                assert_eq!(changed(-entry), Err(Rejected::NotPositive { mode }));
                // Another positive entry is another function, which may well fall too: no tampering, but a proof.
                assert_eq!(changed(0.0), Err(Rejected::NotPositive { mode }));
            } else {
                let nudged = entry + 1e-9 * found.matrices()[mode].amax();
                assert_eq!(changed(nudged), Err(Rejected::NotSymmetric { mode }));
            }
        }
    }
    let x = || found.matrices().to_vec();
    assert_eq!(Certificate::verify(&problem, &gains, x()).as_ref(), Ok(&found));
    assert_eq!(Certificate::verify(&problem, &gains[1..], x()), Err(Rejected::Dimensions));
    assert_eq!(Certificate::verify(&problem.with_length(4), &gains, x()), Err(Rejected::Dimensions));
}
