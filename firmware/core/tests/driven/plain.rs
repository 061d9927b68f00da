//! The Kalman filter of the textbooks, to compare with.

use nalgebra::{Cholesky, SMatrix, SVector};
use slqg::estimator::Model;
use slqg::{Scalar, nalgebra};

/// Mean and covariance of a state.
#[derive(Debug, Clone)]
pub(crate) struct Plain<T: Scalar, const NX: usize> {
    pub(crate) mean: SVector<T, NX>,
    pub(crate) covariance: SMatrix<T, NX, NX>,
}

impl<T: Scalar, const NX: usize> Plain<T, NX> {
    pub(crate) fn new<const NU: usize, const NY: usize>(model: &Model<T, NX, NU, NY>) -> Self {
        Self { mean: model.initial_mean, covariance: model.initial_covariance }
    }

    /// One cycle ahead under `input`.
    pub(crate) fn predict<const NU: usize, const NY: usize>(
        &mut self,
        model: &Model<T, NX, NU, NY>,
        input: SVector<T, NU>,
    ) {
        let (a, b) = (model.a, model.b);
        self.mean = a * self.mean + b * input;
        self.covariance = symmetric(a * self.covariance * a.transpose() + model.process_noise);
    }

    /// Takes a measurement, and returns the logarithm of its density but for a constant.
    pub(crate) fn update<const NU: usize, const NY: usize>(
        &mut self,
        model: &Model<T, NX, NU, NY>,
        output: SVector<T, NY>,
    ) -> f64 {
        let (c, noise) = (model.c, model.measurement_noise);
        let cross = c * self.covariance;
        let spread = symmetric(cross * c.transpose() + noise);
        let factor = Cholesky::new(spread).expect("positive definite");
        let gain = factor.solve(&cross).transpose();
        let innovation = output - c * self.mean;
        let kept = SMatrix::<T, NX, NX>::identity() - gain * c;
        self.mean += gain * innovation;
        let kept = kept * self.covariance * kept.transpose();
        self.covariance = symmetric(kept + gain * noise * gain.transpose());
        let distance = innovation.dot(&factor.solve(&innovation)).widen();
        -0.5 * (distance + spread.map(T::widen).cholesky().expect("positive definite").determinant().ln())
    }

    /// Mean and covariance.
    #[allow(dead_code)]
    pub(crate) fn numbers(&self) -> Vec<f64> {
        self.mean.iter().chain(self.covariance.iter()).map(|number| number.widen()).collect()
    }
}

fn symmetric<T: Scalar, const D: usize>(matrix: SMatrix<T, D, D>) -> SMatrix<T, D, D> {
    (matrix + matrix.transpose()) * T::nearest(0.5)
}

/// The same plant in the highest precision.
#[allow(dead_code)]
pub(crate) fn widened<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    model: &Model<T, NX, NU, NY>,
) -> Model<f64, NX, NU, NY> {
    Model {
        a: model.a.map(T::widen),
        b: model.b.map(T::widen),
        c: model.c.map(T::widen),
        process_noise: model.process_noise.map(T::widen),
        measurement_noise: model.measurement_noise.map(T::widen),
        initial_mean: model.initial_mean.map(T::widen),
        initial_covariance: model.initial_covariance.map(T::widen),
    }
}

/// Whether two lists of numbers agree but for rounding.
#[allow(dead_code)]
pub(crate) fn agree(found: &[f64], expected: &[f64], tolerance: f64) -> bool {
    let scale = expected.iter().fold(1.0, |scale: f64, number| scale.max(number.abs()));
    found.len() == expected.len()
        && found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < tolerance * scale)
}
