//! The critical probability against closed forms and the growth of the iteration that it is about.

use gain_gen::estimation::{critical_probability, modified_riccati};
use nalgebra::{DMatrix, DVector};
use plants::{agree, matrix, plant, seen};

mod plants;

#[test]
fn with_as_many_outputs_as_states_the_fastest_mode_alone_decides() {
    let turn = matrix([[0.9, -0.8], [0.8, 0.9]]);
    let skew = matrix([[1.0, 0.7], [0.0, 1.3]]);
    let turning = &skew * turn * skew.clone().try_inverse().unwrap();
    let units = DMatrix::from_diagonal(&DVector::from_vec(vec![1e-4, 1.0, 1e3]));
    let mixed = matrix([[1.5, 0.4, 0.0], [0.0, 1.2, 1.0], [0.0, 0.0, 0.6]]);
    let scaled = &units * mixed.clone() * units.clone().try_inverse().unwrap();
    for (a, largest) in
        [(matrix([[1.5, 0.0], [0.0, 1.2]]), 1.5_f64), (turning, 1.45_f64.sqrt()), (mixed, 1.5), (scaled, 1.5)]
    {
        let c = DMatrix::identity(a.nrows(), a.nrows());
        let expected = 1.0 - largest.powi(-2);
        let found = critical_probability(&seen(&a, &c));
        assert!(agree(found, expected, 1e-12), "{found} instead of {expected} for {a}");
    }
}

#[test]
fn coinciding_modes_that_outputs_see_apart_are_judged_by_their_modulus() {
    let (a, c) = (matrix([[1.1, 1.0], [0.0, 1.1]]), DMatrix::identity(2, 2));
    assert!(agree(critical_probability(&seen(&a, &c)), 1.0 - 1.1_f64.powi(-2), 1e-12));
}

#[test]
fn with_one_unstable_mode_that_mode_decides_whatever_is_measured() {
    for (a, c) in [
        (matrix([[1.5]]), matrix([[0.1]])),
        (matrix([[1.3, 0.5], [0.2, 0.4]]), matrix([[1.0, 0.0]])),
        (matrix([[1.3, 0.5], [0.2, 0.4]]), matrix([[0.0, 2.0], [1.0, 1.0]])),
    ] {
        let largest = a.clone().complex_eigenvalues().iter().map(|lambda| lambda.norm()).fold(0.0, f64::max);
        let expected = 1.0 - largest.powi(-2);
        assert!(agree(critical_probability(&seen(&a, &c)), expected, 1e-12));
    }
}

#[test]
fn with_a_single_output_the_product_of_the_unstable_modes_decides() {
    for (a, c, product) in [
        (matrix([[1.5, 0.0], [0.0, 1.2]]), matrix([[1.0, 1.0]]), 1.8_f64),
        (matrix([[0.9, -0.8], [0.8, 0.9]]), matrix([[1.0, 0.0]]), 1.45),
        (matrix([[1.2, 1.0, 0.0], [0.0, 1.1, 1.0], [0.0, 0.0, 0.5]]), matrix([[1.0, 0.0, 0.0]]), 1.32),
    ] {
        let expected = 1.0 - product.powi(-2);
        assert!(agree(critical_probability(&seen(&a, &c)), expected, 1e-12));
    }
}

/// `q` at which the modified Riccati iteration without noise, but for too little to matter, neither grows nor shrinks, by
/// bisection on its growth after many steps.
fn bisected(a: &DMatrix<f64>, c: &DMatrix<f64>) -> f64 {
    const NOISE: f64 = 1e-11;
    let (states, outputs) = (a.nrows(), c.nrows());
    let grows = |q: f64| {
        let mut x = DMatrix::identity(states, states);
        let mut growth = 0.0;
        for _ in 0..2000 {
            let noise = NOISE * x.trace();
            let seen = c * &x * a.transpose();
            let innovation = c * &x * c.transpose() + DMatrix::identity(outputs, outputs) * noise;
            let gain = innovation.try_inverse().expect("positive definite") * &seen;
            let next = a * &x * a.transpose() - seen.transpose() * gain * q
                + DMatrix::identity(states, states) * noise;
            growth = next.trace() / x.trace();
            // The mean of both ends of a step: where modes rotate, the iteration alone goes round for ever.
            x = &next / next.trace() + &x / x.trace();
            x = (&x + x.transpose()) * 0.25;
        }
        growth > 1.0
    };
    let (mut lower, mut upper) = (0.0, 1.0);
    while upper - lower > 1e-6 {
        let middle = 0.5 * (lower + upper);
        if grows(middle) { lower = middle } else { upper = middle }
    }
    upper
}

#[test]
fn between_the_formulas_the_iterations_growth_is_1_at_the_critical_probability() {
    let stable = matrix([
        [1.4, 0.3, 0.0, 0.7, 0.1],
        [0.0, 1.3, 0.2, 0.0, 0.2],
        [0.0, -0.4, 1.2, 0.0, 0.3],
        [0.0, 0.0, 0.0, 0.9, 0.5],
        [0.0, 0.0, 0.0, -0.5, 0.6],
    ]);
    let sight = matrix([[1.0, 0.0, 0.5, 0.0, 1.0], [0.0, 0.3, 1.0, 2.0, 0.0]]);
    // The fastest mode alone decides, though not all modes are seen apart.
    let one_fast = DMatrix::from_diagonal(&DVector::from_vec(vec![1.5, 1.1, -1.05, 1.02]));
    let mixed = matrix([[1.0, 0.2, 0.3, 0.7], [0.4, 1.0, -0.6, 0.5], [0.1, -0.3, 1.0, 0.2]]);
    assert!(agree(critical_probability(&seen(&one_fast, &mixed)), 1.0 - 1.5_f64.powi(-2), 1e-6));
    let turns = matrix([[0.0, 1.2, 0.1], [-1.2, 0.0, 0.0], [0.0, 0.0, 1.3]]);
    for (a, c) in [
        (
            matrix([[1.4, 0.3, 0.0], [0.0, 1.3, 0.2], [0.0, 0.0, 1.2]]),
            matrix([[1.0, 0.0, 0.5], [0.0, 0.3, 1.0]]),
        ),
        (stable, sight),
        (turns, matrix([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])),
        (
            DMatrix::from_diagonal(&DVector::from_vec(vec![1.3, -1.3, 1.1])),
            matrix([[1.0, 1.0, 1.0], [0.0, 0.0, 1.0]]),
        ),
    ] {
        let (found, expected) = (critical_probability(&seen(&a, &c)), bisected(&a, &c));
        assert!(agree(found, expected, 3e-6), "{found} instead of {expected} for {a}");
    }
}

#[test]
fn between_the_formulas_the_equation_is_solvable_just_above_the_critical_probability_only() {
    let a = matrix([[1.4, 0.3, 0.0], [0.0, 1.3, 0.2], [0.0, 0.0, 1.2]]);
    let c = matrix([[1.0, 0.0, 0.5], [0.0, 0.3, 1.0]]);
    let critical = critical_probability(&seen(&a, &c));
    assert!(
        1.0 - 1.4_f64.powi(-2) < critical && critical < 1.0 - (1.4_f64 * 1.3 * 1.2).powi(-2),
        "{critical}"
    );
    let plant = plant(a, c, DMatrix::identity(3, 3), DMatrix::identity(2, 2));
    assert!(modified_riccati(&plant, critical + 1e-4).is_some());
    assert!(modified_riccati(&plant, critical - 1e-4).is_none());
}

#[test]
fn a_plant_without_growing_modes_needs_no_more_than_some_measurements() {
    for a in [matrix([[0.5, 3.0], [0.0, 0.9]]), matrix([[1.0, 1.0], [0.0, 1.0]])] {
        assert_eq!(critical_probability(&seen(&a, &DMatrix::identity(2, 2))), 0.0);
        assert_eq!(critical_probability(&seen(&a, &matrix([[1.0, 0.0]]))), 0.0);
    }
}
