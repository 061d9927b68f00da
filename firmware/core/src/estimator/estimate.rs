//! One Gaussian estimate of the state: prediction, measurement update, and merging several into one.

use super::Model;
use crate::Scalar;
use nalgebra::{Cholesky, SMatrix, SVector};

/// A state estimate: mean and error covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate<T: Scalar, const NX: usize> {
    /// Mean of the state, in state units.
    pub mean: SVector<T, NX>,
    /// Covariance of the error of `mean`.
    pub covariance: SMatrix<T, NX, NX>,
}

impl<T: Scalar, const NX: usize> Estimate<T, NX> {
    /// What memory for an estimate holds before there is one.
    pub const EMPTY: Self = Self {
        mean: SVector::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; NX]])),
        covariance: SMatrix::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; NX]; NX])),
    };

    /// What is known before the first measurement.
    pub fn initial<const NU: usize, const NY: usize>(model: &Model<T, NX, NU, NY>) -> Self {
        Self { mean: model.initial_mean, covariance: model.initial_covariance }
    }

    /// One cycle ahead: `A x + B u`, `A P A^T + W`, and `B U B^T` if the input is known with the covariance `U` only.
    ///
    /// Without a measurement for long enough an unstable plant's prediction overflows; by then nothing is known
    /// any more, and the filter starts anew from the initial mean and covariance rather than carry a NaN.
    pub(super) fn predict<const NU: usize, const NY: usize>(
        &self,
        model: &Model<T, NX, NU, NY>,
        input: &SVector<T, NU>,
        input_covariance: Option<&SMatrix<T, NU, NU>>,
    ) -> Self {
        let mean = model.a * self.mean + model.b * input;
        let mut covariance = model.a * self.covariance * model.a.transpose() + model.process_noise;
        if let Some(input_covariance) = input_covariance {
            covariance += model.b * input_covariance * model.b.transpose();
        }
        let predicted = Self { mean, covariance: symmetric(covariance) };
        if predicted.is_finite() { predicted } else { Self::initial(model) }
    }

    /// Measurement update in Joseph's form, which keeps the covariance positive semidefinite in `f32`; and what it says
    /// for the estimate, see [`Innovation`].
    ///
    /// A measurement whose innovation covariance is not numerically positive definite, or which would make the
    /// estimate overflow, tells nothing that could be used and is left out: `None`.
    pub(super) fn update<const NU: usize, const NY: usize>(
        &self,
        model: &Model<T, NX, NU, NY>,
        output: &SVector<T, NY>,
    ) -> Option<(Self, Innovation<T, NY>)> {
        let output_covariance = model.c * self.covariance;
        let innovation_covariance = output_covariance * model.c.transpose() + model.measurement_noise;
        let factor = Cholesky::new(symmetric(innovation_covariance))?;
        let filter_gain = factor.solve(&output_covariance).transpose();
        let innovation = output - model.c * self.mean;
        let mean = self.mean + filter_gain * innovation;
        let kept = SMatrix::<T, NX, NX>::identity() - filter_gain * model.c;
        let covariance = kept * self.covariance * kept.transpose()
            + filter_gain * model.measurement_noise * filter_gain.transpose();
        let posterior = Self { mean, covariance };
        posterior.is_finite().then(|| {
            let covariance = symmetric(posterior.covariance);
            (Self { covariance, ..posterior }, Innovation { innovation, factor })
        })
    }

    fn is_finite(&self) -> bool {
        self.mean.iter().chain(self.covariance.iter()).all(|value| value.is_finite())
    }
}

/// The difference between a measurement and what an estimate expects, with the factor of its covariance.
pub(super) struct Innovation<T: Scalar, const NY: usize> {
    innovation: SVector<T, NY>,
    factor: Cholesky<T, nalgebra::Const<NY>>,
}

impl<T: Scalar, const NY: usize> Innovation<T, NY> {
    /// Logarithm of the measurement's density under the estimate, but for a constant that is the same for all; of a
    /// measurement too far off to compute it, a number that is finite and lower than any other.
    pub(super) fn log_likelihood(&self) -> T {
        let lower = self.factor.l_dirty();
        let log_root = (0..NY).fold(T::zero(), |sum, row| sum + lower[(row, row)].logarithm());
        let distance = self.innovation.dot(&self.factor.solve(&self.innovation));
        // A distance that overflows is infinite or no number; the maximum of that and a number is the number.
        (-(T::nearest(0.5) * distance + log_root)).max(lowest())
    }
}

/// Estimates merged into one of the same mean and covariance as their mixture.
///
/// Weights are logarithms, so that none underflows. A single estimate comes out as it went in, to the bit.
#[derive(Debug, Clone)]
pub(super) struct Merged<T: Scalar, const NX: usize> {
    log_weight: T,
    estimate: Option<Estimate<T, NX>>,
}

impl<T: Scalar, const NX: usize> Merged<T, NX> {
    pub(super) fn none() -> Self {
        Self { log_weight: T::zero(), estimate: None }
    }

    /// Logarithm of the sum of all weights; meaningless of none.
    pub(super) fn log_weight(&self) -> T {
        self.log_weight
    }

    pub(super) fn into_estimate(self) -> Option<Estimate<T, NX>> {
        self.estimate
    }

    /// Estimates so far apart that their mixture overflows are not merged: the likelier one stays.
    pub(super) fn absorb(&mut self, log_weight: T, other: &Estimate<T, NX>) {
        if !log_weight.is_finite() {
            return;
        }
        let Some(estimate) = &mut self.estimate else {
            self.estimate = Some(other.clone());
            self.log_weight = log_weight;
            return;
        };
        let largest = self.log_weight.max(log_weight);
        let [own, new] = [self.log_weight, log_weight].map(|weight| (weight - largest).exponential());
        let share = new / (own + new);
        let between = other.mean - estimate.mean;
        let covariance = estimate.covariance * (T::one() - share)
            + other.covariance * share
            + between * between.transpose() * (share * (T::one() - share));
        let mixture = Estimate { mean: estimate.mean + between * share, covariance: symmetric(covariance) };
        if mixture.is_finite() {
            *estimate = mixture;
        } else if new > own {
            *estimate = other.clone();
        }
        self.log_weight = largest + (own + new).logarithm();
    }
}

/// Far below every logarithm of a weight, and as far from overflowing if one is added.
fn lowest<T: Scalar>() -> T {
    -T::max_value().unwrap_or_else(T::one) * T::nearest(0.25)
}

fn symmetric<T: Scalar, const D: usize>(matrix: SMatrix<T, D, D>) -> SMatrix<T, D, D> {
    (matrix + matrix.transpose()) * T::nearest(0.5)
}
