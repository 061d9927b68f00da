//! What an estimator computes of its model once: factors of the noises, and what it begins anew with.

use super::{Estimate, Model, factored::Factored};
use crate::{Scalar, integrity::Part};
use nalgebra::{SMatrix, SVector};

/// Outputs may be this many standard deviations of the measurement noise away from zero when an estimate begins anew.
const RANGE: f64 = 100.0;
/// Where measurements say nothing of a state, its standard deviation is this many times the largest it is known to have.
const UNKNOWN: f64 = 1e3;

/// Constants of the filter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Prepared<T: Scalar, const NX: usize, const NY: usize> {
    /// `W`.
    process_noise: Factored<T, NX>,
    /// Outputs with independent noises: `L^-1 C`, where `V = L diag(noises) L^T` and `L` has a diagonal of ones.
    outputs: [[T; NX]; NY],
    /// `L`, of which only what is below the diagonal counts.
    mixing: [[T; NY]; NY],
    noises: [T; NY],
    /// Variances of the innovations of `outputs` beyond which an estimate is of no use.
    limits: [T; NY],
    /// What an estimate that is of no use begins anew with.
    joining: Estimate<T, NX>,
}

impl<T: Scalar, const NX: usize, const NY: usize> Prepared<T, NX, NY> {
    /// For measurements that may be `late` cycles late.
    pub(super) fn new<const NU: usize>(model: &Model<T, NX, NU, NY>, late: usize) -> Self {
        let (mixing, noises) = decorrelated(&model.measurement_noise);
        let mut outputs = [[T::zero(); NX]; NY];
        for (output, row) in outputs.iter_mut().enumerate() {
            *row = core::array::from_fn(|state| model.c[(output, state)]);
        }
        for output in 0..NY {
            for before in 0..output {
                for state in 0..NX {
                    let part = mixing[output][before] * outputs[before][state];
                    outputs[output][state] -= part;
                }
            }
        }
        let process_noise = Factored::of(&model.process_noise);
        let joining = joining(model, &outputs, &noises, late);
        let initial = Factored::of(&model.initial_covariance);
        let limits = core::array::from_fn(|output| {
            let known = [&joining, &initial, &process_noise].map(|one| one.variance(&outputs[output]));
            let largest = T::max_value().unwrap_or_else(T::one);
            (known.iter().fold(noises[output], |sum, variance| sum + *variance) / T::EPSILON).min(largest)
        });
        let joining = Estimate { mean: SVector::zeros(), covariance: joining };
        Self { process_noise, outputs, mixing, noises, limits, joining }
    }

    /// What an estimate of no use begins anew with: see [`Prepared::is_of_use`].
    pub(super) fn joining(&self) -> &Estimate<T, NX> {
        &self.joining
    }

    pub(super) fn process_noise(&self) -> &Factored<T, NX> {
        &self.process_noise
    }

    /// Outputs with independent noises, one by one: what was measured, its row and the variance of its noise.
    pub(super) fn independent<'s>(
        &'s self,
        output: &SVector<T, NY>,
    ) -> impl Iterator<Item = (T, &'s [T; NX], T)> + 's {
        let mut values: [T; NY] = core::array::from_fn(|place| output[place]);
        for place in 0..NY {
            for before in 0..place {
                let mixing = self.mixing[place][before];
                // What is not measured takes with it only what shares its noise.
                if mixing != T::zero() {
                    values[place] -= mixing * values[before];
                }
            }
        }
        (0..NY).map(move |place| (values[place], &self.outputs[place], self.noises[place]))
    }

    /// Whether an estimate tells what the next measurements can improve on.
    ///
    /// It does not if the variance of an output is more than `1 / epsilon` times what it is when an estimate begins: as the
    /// larger one of a controller that joins and the design's initial state, noises included. That is a ratio, whatever the
    /// units. From there on rounding of the mean is as large as the measurement's noise, and nothing is lost by beginning
    /// anew.
    pub(super) fn is_of_use(&self, estimate: &Estimate<T, NX>) -> bool {
        let variance = |(row, noise): (&[T; NX], &T)| estimate.covariance.variance(row) + *noise;
        estimate.is_finite() && self.bears(self.outputs.iter().zip(&self.noises).map(variance))
    }

    /// The same of the variances of the independent outputs' innovations; of an estimate that is not finite they are not
    /// either.
    pub(super) fn bears(&self, variances: impl Iterator<Item = T>) -> bool {
        // No number is not of use.
        self.limits.iter().zip(variances).all(|(limit, variance)| variance <= *limit)
    }
}

impl<T: Scalar, const NX: usize, const NY: usize> Prepared<T, NX, NY> {
    /// What a checksum is taken of.
    pub(super) fn part(&self, place: usize) -> Part<'_, T> {
        match place {
            0 => Part::Numbers(self.process_noise.numbers()),
            1 => Part::Numbers(self.outputs.as_flattened()),
            2 => Part::Numbers(self.mixing.as_flattened()),
            3 => Part::Numbers(&self.noises),
            4 => Part::Numbers(&self.limits),
            5 => Part::Numbers(self.joining.mean.as_slice()),
            6 => Part::Numbers(self.joining.covariance.numbers()),
            _ => Part::End,
        }
    }

    /// With the number at this place, of all but those that estimates begin anew with, changed; `false` if there is none. For
    /// tests of what comes of it.
    #[cfg(test)]
    pub(super) fn damage(&mut self, place: usize, change: impl FnOnce(&mut T)) -> bool {
        let tables = self.outputs.as_flattened_mut().iter_mut().chain(self.mixing.as_flattened_mut());
        let found = tables.chain(&mut self.noises).chain(&mut self.limits).nth(place);
        found.map(change).is_some()
    }
}

/// `V = L diag(noises) L^T`.
fn decorrelated<T: Scalar, const NY: usize>(noise: &SMatrix<T, NY, NY>) -> ([[T; NY]; NY], [T; NY]) {
    let mut lower = [[T::zero(); NY]; NY];
    let mut noises = [T::zero(); NY];
    for place in 0..NY {
        let known = |row: &[T; NY], other: &[T; NY], noises: &[T; NY]| {
            (0..place).fold(T::zero(), |sum, before| sum + row[before] * other[before] * noises[before])
        };
        let weight = noise[(place, place)] - known(&lower[place], &lower[place], &noises);
        let counts = weight > T::zero();
        noises[place] = if counts { weight } else { T::zero() };
        for row in place + 1..NY {
            let covariance = noise[(row, place)] - known(&lower[row], &lower[place], &noises);
            lower[row][place] = if counts { covariance / weight } else { T::zero() };
        }
    }
    (lower, noises)
}

/// Covariance of the state about zero for an estimate that begins in the middle: as after `late` measurements, and no fewer
/// than there are states, without any knowledge before them, 100 times as uncertain.
///
/// ```text
/// P = (I / 100^2 + D)^-1,    I = sum_k (C A^k)^T V^-1 (C A^k)
/// ```
///
/// So it is wide in units of what the sensors can tell. `D` is small, and there for states that no sensor sees.
fn joining<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    model: &Model<T, NX, NU, NY>,
    outputs: &[[T; NX]; NY],
    noises: &[T; NY],
    late: usize,
) -> Factored<T, NX> {
    let unknown = T::nearest(UNKNOWN * UNKNOWN);
    let spread = core::array::from_fn(|state| {
        let known = model.initial_covariance[(state, state)]
            + model.initial_mean[state] * model.initial_mean[state]
            + model.process_noise[(state, state)];
        let spread = known * unknown;
        if spread > T::zero() && spread.is_finite() { spread } else { unknown }
    });
    let mut covariance = Factored::diagonal(&spread);
    let mut observed = *outputs;
    for _ in 0..late.max(NX) {
        for (row, noise) in observed.iter_mut().zip(noises) {
            // A sensor without noise would tell everything at once.
            if *noise > T::zero() {
                let mut better = covariance.clone();
                let observed = better.observe(row, *noise * T::nearest(RANGE * RANGE));
                if observed.is_some_and(|(_, variance)| variance.is_finite()) && better.is_finite() {
                    covariance = better;
                }
            }
            *row = core::array::from_fn(|state| {
                (0..NX).fold(T::zero(), |sum, place| sum + row[place] * model.a[(place, state)])
            });
        }
    }
    covariance
}
