//! The in-flight recursion equals the coupled one on random plants, costs and links, zero and hold.
//!
//! This is the project's strongest test: the two share nothing but the rank-revealing solve.

use gain_gen::{
    design::DelayDistribution,
    solve::{LoopProblem, Method, Outcome, solve},
};
use nalgebra::{DMatrix, DVector};
use proptest::{
    prelude::*,
    strategy::ValueTree,
    test_runner::{Config, RngAlgorithm, TestRng, TestRunner},
};
use rayon::prelude::*;
use slqg::DefaultInput;
use slqg_tests::relative_difference;

/// Designs drawn: enough that 200 of them are stabilisable and not too close to the boundary.
const DRAWN: usize = 230;
/// Second moments that shrink by less than this a step are left to the slower tests near the boundary: the coupled
/// solver takes minutes on the largest of them.
const SLOWEST: f64 = 0.995;

fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0f64, rows * columns)
        .prop_map(move |entries| DMatrix::from_row_slice(rows, columns, &entries))
}

/// Plants with a spectral radius between 0.5 and 1.25.
fn plant(states: usize) -> impl Strategy<Value = DMatrix<f64>> {
    (matrix(states, states), 0.5..1.25f64).prop_map(|(shape, radius)| {
        let largest = shape.complex_eigenvalues().iter().map(|value| value.norm()).fold(1e-3, f64::max);
        shape * (radius / largest)
    })
}

/// Positive semidefinite, `floor` above singular.
fn definite(size: usize, floor: f64) -> impl Strategy<Value = DMatrix<f64>> {
    matrix(size, size)
        .prop_map(move |root| &root * root.transpose() + DMatrix::<f64>::identity(size, size) * floor)
}

/// Delays of up to eight steps: with and without loss, with certain arrival, with nothing arriving at once.
fn link() -> impl Strategy<Value = DelayDistribution> {
    let weights = prop::collection::vec(prop_oneof![4 => 0.0..1.0f64, 1 => Just(0.0)], 1..=8);
    (weights, prop_oneof![1 => Just(0.0), 2 => 0.0..0.5f64], any::<bool>()).prop_filter_map(
        "something must arrive",
        |(mut weights, loss, at_once)| {
            if !at_once {
                weights[0] = 0.0;
            }
            let sum: f64 = weights.iter().sum();
            let probabilities = weights.iter().map(|weight| weight / sum * (1.0 - loss)).collect();
            (sum > 1e-3).then(|| DelayDistribution::new(probabilities).ok()).flatten()
        },
    )
}

/// Units of the states, apart by up to a factor of 10 000 in one design of two.
fn units(states: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop_oneof![Just(vec![0.0; states]), prop::collection::vec(-2.0..2.0f64, states),].prop_map(|exponents| {
        DMatrix::from_diagonal(&DVector::from_vec(exponents).map(|exponent| 10f64.powf(exponent)))
    })
}

fn inverse(diagonal: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_diagonal(&diagonal.diagonal().map(|unit| 1.0 / unit))
}

fn problem() -> impl Strategy<Value = LoopProblem> {
    (1..=6usize, 1..=3usize, 1..=8usize, any::<bool>()).prop_flat_map(|(states, inputs, length, hold)| {
        let plant = (plant(states), matrix(states, inputs), units(states));
        let costs = (definite(states, 1e-3), definite(inputs, 0.1));
        (plant, costs, link()).prop_map(move |((a, b, units), (q, r), link)| LoopProblem {
            a: &units * a * inverse(&units),
            b: units * b,
            q,
            r,
            link,
            length,
            default_input: if hold { DefaultInput::Hold } else { DefaultInput::Zero },
        })
    })
}

/// How one design came out.
enum Compared {
    Agreed,
    Unstable,
    TooSlow,
}

fn compare(problem: &LoopProblem) -> Compared {
    let found = solve(problem, Method::InFlight);
    if found.outcome != Outcome::Converged {
        assert!(found.mean_square_rate >= 1.0, "{problem:?}");
        return Compared::Unstable;
    }
    if found.mean_square_rate > SLOWEST {
        return Compared::TooSlow;
    }
    let expected = solve(problem, Method::Coupled);
    assert_eq!(found.outcome, expected.outcome, "{problem:?}");
    assert!(relative_difference(&found.cost_to_go, &expected.cost_to_go) < 1e-9, "{problem:?}");
    let rate = (found.mean_square_rate - expected.mean_square_rate).abs();
    assert!(rate < 1e-8, "rates {} and {}: {problem:?}", found.mean_square_rate, expected.mean_square_rate);
    for (mode, (gain, reference)) in found.mode_gains().iter().zip(expected.mode_gains().iter()).enumerate() {
        let difference = relative_difference(gain, reference);
        assert!(difference < 1e-9, "gain of mode {mode} differs by {difference:e}: {problem:?}");
    }
    Compared::Agreed
}

#[test]
fn both_solvers_agree_on_random_designs() {
    let mut runner =
        TestRunner::new_with_rng(Config::default(), TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]));
    let problems: Vec<_> =
        (0..DRAWN).map(|_| problem().new_tree(&mut runner).expect("a problem").current()).collect();
    let compared: Vec<_> = problems.par_iter().map(compare).collect();
    let count = |wanted: fn(&Compared) -> bool| compared.iter().filter(|outcome| wanted(outcome)).count();
    let agreed = count(|outcome| matches!(outcome, Compared::Agreed));
    let unstable = count(|outcome| matches!(outcome, Compared::Unstable));
    let nothing_at_once = problems
        .iter()
        .zip(&compared)
        .filter(|(problem, outcome)| {
            matches!(outcome, Compared::Agreed) && problem.link.probability(0) == 0.0
        })
        .count();
    eprintln!("{agreed} of {DRAWN} agree, {nothing_at_once} of them with q(0) = 0; {unstable} unstable");
    assert!(agreed >= 200 && nothing_at_once >= 20 && unstable >= 5);
}
