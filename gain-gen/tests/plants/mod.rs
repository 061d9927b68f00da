//! Plants of which only what an estimator knows matters, and the steps of its covariance.

#![allow(dead_code)]

use gain_gen::design::{DelayDistribution, Plant};
use nalgebra::{DMatrix, DVector};

/// The matrix with these rows.
pub(super) fn matrix<const R: usize, const C: usize>(rows: [[f64; C]; R]) -> DMatrix<f64> {
    DMatrix::from_fn(R, C, |i, j| rows[i][j])
}

/// P(delay = 0, 1, ..).
pub(super) fn link(probabilities: &[f64]) -> DelayDistribution {
    DelayDistribution::new(probabilities.to_vec()).expect("a distribution")
}

/// A plant of which only what the estimator knows matters.
pub(super) fn plant(a: DMatrix<f64>, c: DMatrix<f64>, w: DMatrix<f64>, v: DMatrix<f64>) -> Plant {
    let states = a.nrows();
    Plant {
        sample_time: 1.0,
        b: DMatrix::identity(states, states),
        initial_mean: DVector::zeros(states),
        initial_covariance: DMatrix::zeros(states, states),
        continuous: None,
        a,
        c,
        process_noise: w,
        measurement_noise: v,
    }
}

/// A plant of which only how its modes show in measurements matters.
pub(super) fn seen(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Plant {
    let unit = |size| DMatrix::identity(size, size);
    plant(a.clone(), c.clone(), unit(a.nrows()), unit(c.nrows()))
}

/// One state that is measured.
pub(super) fn scalar_plant(a: f64) -> Plant {
    plant(matrix([[a]]), matrix([[1.0]]), matrix([[0.5]]), matrix([[2.0]]))
}

/// Two states that grow slowly, of which one combination is measured.
pub(super) fn oscillator() -> Plant {
    plant(
        matrix([[1.05, 0.4], [-0.3, 0.98]]),
        matrix([[1.0, 0.2]]),
        matrix([[0.3, 0.1], [0.1, 0.2]]),
        matrix([[0.7]]),
    )
}

/// To an absolute tolerance.
pub(super) fn agree(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance
}

/// `A X A' + W`.
pub(super) fn predicted(plant: &Plant, covariance: &DMatrix<f64>) -> DMatrix<f64> {
    &plant.a * covariance * plant.a.transpose() + &plant.process_noise
}

/// After a measurement that comes with probability `q`.
pub(super) fn corrected(plant: &Plant, prior: &DMatrix<f64>, q: f64) -> DMatrix<f64> {
    let seen = &plant.c * prior;
    let innovation = &seen * plant.c.transpose() + &plant.measurement_noise;
    prior - seen.transpose() * innovation.try_inverse().expect("positive definite") * &seen * q
}
