//! One Gaussian estimate of the state: prediction, measurement update, and merging several into one.

use super::{Model, factored::Factored, plausibility::Heard, prepared::Prepared};
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

    /// Measurement update, one output after the other, but for those that `said` has as rejected; and what it says for the
    /// estimate, see [`Innovation`].
    ///
    /// An output that is no finite number is not measured. Unless the measurement is taken, the estimate is none any more: an
    /// output whose squared innovation is more than `gate` times its variance has come to be rejected, or the mean overflows.
    #[inline(never)]
    pub(super) fn update<const NY: usize>(
        &mut self,
        prepared: &Prepared<T, NX, NY>,
        output: &SVector<T, NY>,
        gate: T,
        said: &mut Innovation<T, NY>,
    ) -> Update {
        for (place, (measured, row, noise)) in prepared.independent(output).enumerate() {
            if said.left_out & (1 << place) != 0 {
                continue;
            }
            // An output that is certain beforehand tells nothing.
            let Some((gain, variance)) = self.covariance.observe(row, noise) else { continue };
            let expected = (0..NX).fold(T::zero(), |sum, state| sum + row[state] * self.mean[state]);
            let innovation = measured - expected;
            said.innovation[place] = innovation;
            said.variance[place] = variance;
            let distance = innovation * innovation;
            // What is no number is not measured.
            if distance > gate * variance || distance.partial_cmp(&T::zero()).is_none() {
                said.leave_out(place, noise);
                return Update::Rejects;
            }
            said.heard.believe(place);
            for state in 0..NX {
                self.mean[state] += gain[state] * innovation;
            }
        }
        if self.mean.iter().all(|value| value.is_finite()) { Update::Taken } else { Update::Overflows }
    }

    /// Becomes `prior` with the measurement in it, and what that says; `None`: nothing that could be used, and it is `prior`.
    pub(super) fn updated<const NY: usize>(
        &mut self,
        prior: &Self,
        prepared: &Prepared<T, NX, NY>,
        output: &SVector<T, NY>,
        gate: T,
    ) -> Option<Innovation<T, NY>> {
        let mut said = Innovation::NOTHING;
        loop {
            self.clone_from(prior);
            match self.update(prepared, output, gate, &mut said) {
                Update::Taken => return Some(said),
                Update::Rejects => (),
                Update::Overflows => {
                    self.clone_from(prior);
                    return None;
                }
            }
        }
    }

    /// The same mean, and `times` the covariance.
    pub(super) fn widen(&mut self, times: T) {
        self.covariance.scale(times);
    }

    pub(super) fn is_finite(&self) -> bool {
        self.covariance.is_finite() && self.mean.iter().all(|value| value.is_finite())
    }
}

/// What has become of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Update {
    /// It is in the estimate.
    Taken,
    /// One more of its outputs is rejected.
    Rejects,
    /// It tells nothing that could be used.
    Overflows,
}

/// The differences between independent outputs and what an estimate expects of each after those before, with their
/// variances; zero of an output that was certain.
pub(super) struct Innovation<T: Scalar, const NY: usize> {
    innovation: [T; NY],
    variance: [T; NY],
    /// Outputs that are not measured or not believed, a bit for each.
    left_out: u32,
    /// Which outputs were measured, and which were taken in.
    pub(super) heard: Heard,
    /// By what the covariance grows for those that were not.
    pub(super) widening: T,
}

/// A rejected output's innovation variance grows by this.
const WIDER: f64 = 4.0;
/// And the covariance at most by this: where the estimate is much better than the sensor.
const WIDEST: f64 = 100.0;

impl<T: Scalar, const NY: usize> Innovation<T, NY> {
    pub(super) const NOTHING: Self = Self {
        innovation: [T::ZERO; NY],
        variance: [T::ZERO; NY],
        left_out: 0,
        heard: Heard::NOTHING,
        widening: T::ZERO,
    };

    pub(super) fn variances(&self) -> impl Iterator<Item = T> + '_ {
        self.variance.iter().copied()
    }

    /// An output with this noise is not measured, or not believed.
    #[cold]
    #[inline(never)]
    fn leave_out(&mut self, place: usize, noise: T) {
        self.left_out |= 1 << place;
        let (innovation, variance) = (self.innovation[place], self.variance[place]);
        if innovation.partial_cmp(&T::zero()).is_none() {
            self.variance[place] = T::zero();
            return;
        }
        self.heard.reject(place);
        // What is so far off that rounding of its value is larger than any noise says nothing, of the estimate neither.
        let says_something = innovation * innovation <= absurd::<T>() * variance;
        let explained = variance - noise;
        if says_something && explained > T::zero() {
            let wider = (T::nearest(WIDER) * variance - noise) / explained;
            let widest = T::nearest(WIDEST);
            let wider = if wider < widest { wider } else { widest };
            if wider > self.widening {
                self.widening = wider;
            }
        }
    }

    /// Logarithm of the measurement's density under the estimate, but for a constant that is the same for all; of a
    /// measurement too far off to compute it, a number that is finite and lower than any other. An output that was not believed is
    /// held to be just at the `gate`: how far beyond it is tells nothing.
    pub(super) fn log_likelihood(&self, gate: T) -> T {
        let told = (0..NY).filter(|place| self.variance[*place] > T::zero());
        let twice = told.fold(T::zero(), |sum, place| {
            let (innovation, variance) = (self.innovation[place], self.variance[place]);
            let distance =
                if self.heard.rejects(place) { gate } else { innovation * (innovation / variance) };
            sum + distance + variance.logarithm()
        });
        // A distance that overflows is infinite or no number; the maximum of that and a number is the number.
        (-(T::nearest(0.5) * twice)).max(lowest())
    }
}

/// Squared innovations beyond this many times their variance are no measurement of anything: they are as far off as the
/// largest and the smallest number that a sum can tell apart.
pub(super) fn absurd<T: Scalar>() -> T {
    T::one() / (T::EPSILON * T::EPSILON)
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
