//! Bounds on the error covariance against exact enumeration and the equations they solve.

use gain_gen::design::Plant;
use gain_gen::estimation::{
    CovarianceBounds, covariance_bounds, critical_probability, kalman_covariance, modified_riccati,
};
use nalgebra::DMatrix;
use plants::{agree, corrected, link, matrix, oscillator, plant, predicted, scalar_plant};

mod plants;

#[test]
fn solutions_solve_their_riccati_equation() {
    let plant = oscillator();
    for q in [1.0, 0.9, 0.5] {
        let found = modified_riccati(&plant, q).expect("above the critical probability");
        let residual = predicted(&plant, &corrected(&plant, &found, q)) - &found;
        assert!(residual.amax() < 1e-11 * found.amax(), "{q}: {residual}");
    }
    let posterior = kalman_covariance(&plant);
    let again = corrected(&plant, &predicted(&plant, &posterior), 1.0);
    assert!((again - &posterior).amax() < 1e-12);
}

#[test]
fn measurements_that_come_for_sure_at_a_fixed_delay_leave_nothing_open() {
    let plant = oscillator();
    let mut expected = kalman_covariance(&plant);
    for delay in 0..4 {
        let mut delays = vec![0.0; delay + 1];
        delays[delay] = 1.0;
        let CovarianceBounds { lower, upper } = covariance_bounds(&plant, &link(&delays), 7);
        for bound in [lower.expect("bounded"), upper.expect("bounded")] {
            assert!((bound - &expected).amax() < 1e-11 * expected.amax(), "delay {delay}");
        }
        expected = predicted(&plant, &expected);
    }
}

/// `E[e e']` by going through all patterns of which of the last `depth` measurements have come, each pattern started
/// from `start` before.
fn enumerated(plant: &Plant, arrival: &[f64], start: &DMatrix<f64>) -> DMatrix<f64> {
    let Some((oldest, newer)) = arrival.split_first() else { return start.clone() };
    let prior = predicted(plant, start);
    let mut expected = DMatrix::zeros(start.nrows(), start.nrows());
    for (share, covariance) in [(*oldest, corrected(plant, &prior, 1.0)), (1.0 - oldest, prior.clone())] {
        if share > 0.0 {
            expected += enumerated(plant, newer, &covariance) * share;
        }
    }
    expected
}

#[test]
fn bounds_enclose_what_enumeration_of_all_arrivals_gives() {
    for (plant, delays, buffer) in [
        (scalar_plant(1.1), &[0.5, 0.2, 0.1][..], 2),
        (scalar_plant(0.8), &[0.0, 0.3, 0.0, 0.4], 2),
        (oscillator(), &[0.6, 0.2, 0.15], 4),
    ] {
        let link = link(delays);
        let CovarianceBounds { lower, upper } = covariance_bounds(&plant, &link, buffer);
        let (lower, upper) = (lower.expect("bounded").trace(), upper.expect("bounded").trace());
        // Oldest first; what came before the last fourteen measurements hardly matters, and is bounded too.
        let arrival: Vec<f64> = (0..14).rev().map(|age: usize| link.arrival(age.min(buffer))).collect();
        let best = enumerated(&plant, &arrival, &kalman_covariance(&plant)).trace();
        let start = modified_riccati(&plant, link.arrival(buffer)).expect("above the critical probability");
        let worst = enumerated(&plant, &arrival, &start).trace();
        assert!(lower <= worst && best <= upper, "{lower} to {upper} against {best} to {worst}");
        assert!(worst - best < 0.05 * best, "{best} to {worst}: enumerate more");
        assert!(upper - lower < 0.35 * lower, "{lower} to {upper}: too wide to be of use");
    }
}

/// Covariance `x`, with its states in other units, relative to the standard deviations of `plain`.
fn off(x: &DMatrix<f64>, plain: &DMatrix<f64>, units: &[f64]) -> f64 {
    let size = |i: usize| plain[(i, i)].sqrt() * units[i];
    let difference = |i: usize, j: usize| x[(i, j)] - plain[(i, j)] * units[i] * units[j];
    let places = (0..x.nrows()).flat_map(|i| (0..x.nrows()).map(move |j| (i, j)));
    places.map(|(i, j)| difference(i, j).abs() / (size(i) * size(j))).fold(0.0, f64::max)
}

#[test]
fn units_change_covariances_by_their_factors_and_nothing_else() {
    let third = plant(
        matrix([[1.3, 0.3, 0.0], [0.0, 1.1, 0.2], [0.1, -0.4, 0.8]]),
        matrix([[1.0, 0.0, 0.5], [0.0, 0.3, 1.0]]),
        matrix([[0.3, 0.1, 0.0], [0.1, 0.2, 0.0], [0.0, 0.0, 0.4]]),
        matrix([[0.7, 0.2], [0.2, 0.4]]),
    );
    let delays = link(&[0.6, 0.2, 0.1]);
    for (plain, powers) in [(oscillator(), [9, -9, 0]), (third.clone(), [-9, 3, 9]), (third, [6, 9, -8])] {
        let unit = |power: i32| 10.0_f64.powi(power);
        let states: Vec<f64> = powers[..plain.a.nrows()].iter().map(|&power| unit(power)).collect();
        let outputs: Vec<f64> = powers[..plain.c.nrows()].iter().map(|&power| unit(-power)).collect();
        let scaled = plant(
            plain.a.map_with_location(|i, j, entry| entry * states[i] / states[j]),
            plain.c.map_with_location(|i, j, entry| entry * outputs[i] / states[j]),
            plain.process_noise.map_with_location(|i, j, entry| entry * states[i] * states[j]),
            plain.measurement_noise.map_with_location(|i, j, entry| entry * outputs[i] * outputs[j]),
        );
        let (expected, found) =
            (covariance_bounds(&plain, &delays, 3), covariance_bounds(&scaled, &delays, 3));
        for (found, expected) in [(found.lower, expected.lower), (found.upper, expected.upper)] {
            let off = off(&found.expect("bounded"), &expected.expect("bounded"), &states);
            assert!(off < 1e-9, "{powers:?}: {off}");
        }
        assert!(agree(critical_probability(&plain), critical_probability(&scaled), 1e-9), "{powers:?}");
    }
}

#[test]
fn no_measurements_leave_the_open_loops_covariance() {
    let stable = scalar_plant(0.5);
    let found = covariance_bounds(&stable, &link(&[0.0, 1.0]), 0);
    let expected = 0.5 / (1.0 - 0.25);
    for bound in [found.lower, found.upper] {
        assert!(agree(bound.expect("bounded")[0], expected, 1e-14));
    }
    for a in [1.0, 1.2] {
        let found = covariance_bounds(&scalar_plant(a), &link(&[0.0, 1.0]), 0);
        assert_eq!((found.lower, found.upper), (None, None));
    }
}
