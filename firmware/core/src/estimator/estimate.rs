//! One Gaussian estimate of the state: prediction, measurement update, and merging several into one.

use super::{Model, factored::Factored, prepared::Prepared};
use crate::Scalar;
use nalgebra::{SMatrix, SVector};

/// A state estimate: mean and error covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate<T: Scalar, const NX: usize> {
    /// Mean of the state, in state units.
    pub mean: SVector<T, NX>,
    /// Of the error of `mean`.
    pub(super) covariance: Factored<T, NX>,
}

impl<T: Scalar, const NX: usize> Estimate<T, NX> {
    /// What memory for an estimate holds before there is one.
    pub const EMPTY: Self = Self {
        mean: SVector::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; NX]])),
        covariance: Factored::EMPTY,
    };

    /// What is known before the first measurement.
    pub fn initial<const NU: usize, const NY: usize>(model: &Model<T, NX, NU, NY>) -> Self {
        Self { mean: model.initial_mean, covariance: Factored::of(&model.initial_covariance) }
    }

    /// Covariance of the error of the mean, `nx x nx`: symmetric, and positive semidefinite but for the rounding of this
    /// product of its factors.
    pub fn covariance(&self) -> SMatrix<T, NX, NX> {
        self.covariance.matrix()
    }

    /// Becomes `before` one cycle ahead: `A x + B u`, `A P A^T + W`, and `B U B^T` if the input is known with the covariance `U`
    /// only.
    ///
    /// That may overflow: without a measurement for long enough an unstable plant's prediction does.
    // Apart from the update, which follows: the stack then holds what one of them works with, not both.
    #[inline(never)]
    pub(super) fn predict<const NU: usize, const NY: usize>(
        &mut self,
        before: &Self,
        model: &Model<T, NX, NU, NY>,
        prepared: &Prepared<T, NX, NY>,
        (input, input_covariance): (&SVector<T, NU>, Option<&SMatrix<T, NU, NU>>),
    ) {
        self.mean = model.a * before.mean + model.b * input;
        self.covariance = before.covariance.predicted(&model.a, prepared.process_noise());
        if let Some(input_covariance) = input_covariance {
            for (weight, direction) in Factored::of(input_covariance).directions() {
                let moved = model.b * SVector::from(direction);
                self.covariance.add(weight, core::array::from_fn(|state| moved[state]));
            }
        }
    }

    /// Measurement update, one output after the other; and what it says for the estimate, see [`Innovation`].
    ///
    /// A measurement which makes the mean overflow tells nothing that could be used: `None`, and the estimate is none any more.
    #[inline(never)]
    pub(super) fn update<const NY: usize>(
        &mut self,
        prepared: &Prepared<T, NX, NY>,
        output: &SVector<T, NY>,
    ) -> Option<Innovation<T, NY>> {
        let mut said = Innovation { innovation: [T::zero(); NY], variance: [T::zero(); NY] };
        for (place, (measured, row, noise)) in prepared.independent(output).enumerate() {
            // An output that is certain beforehand tells nothing.
            let Some((gain, variance)) = self.covariance.observe(row, noise) else { continue };
            let expected = (0..NX).fold(T::zero(), |sum, state| sum + row[state] * self.mean[state]);
            let innovation = measured - expected;
            for state in 0..NX {
                self.mean[state] += gain[state] * innovation;
            }
            said.innovation[place] = innovation;
            said.variance[place] = variance;
        }
        self.mean.iter().all(|value| value.is_finite()).then_some(said)
    }

    pub(super) fn is_finite(&self) -> bool {
        self.covariance.is_finite() && self.mean.iter().all(|value| value.is_finite())
    }
}

/// The differences between independent outputs and what an estimate expects of each after those before, with their
/// variances; zero of an output that was certain.
pub(super) struct Innovation<T: Scalar, const NY: usize> {
    innovation: [T; NY],
    variance: [T; NY],
}

impl<T: Scalar, const NY: usize> Innovation<T, NY> {
    pub(super) fn variances(&self) -> impl Iterator<Item = T> + '_ {
        self.variance.iter().copied()
    }

    /// Logarithm of the measurement's density under the estimate, but for a constant that is the same for all; of a
    /// measurement too far off to compute it, a number that is finite and lower than any other.
    pub(super) fn log_likelihood(&self) -> T {
        let twice = self.innovation.iter().zip(&self.variance).filter(|(_, variance)| **variance > T::zero());
        let twice = twice.fold(T::zero(), |sum, (innovation, variance)| {
            sum + *innovation * (*innovation / *variance) + variance.logarithm()
        });
        // A distance that overflows is infinite or no number; the maximum of that and a number is the number.
        (-(T::nearest(0.5) * twice)).max(lowest())
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
        let mut covariance = estimate.covariance.mixed(&other.covariance, share);
        covariance.add(share * (T::one() - share), core::array::from_fn(|state| between[state]));
        let mixture = Estimate { mean: estimate.mean + between * share, covariance };
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
