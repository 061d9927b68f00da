//! Kalman filter with a measurement buffer: thesis 3.4.1, after Schenato (2008).
//!
//! Remembers the last `H` cycles. A measurement or an input that becomes known late is put where it belongs
//! and everything after it is filtered again, so that the estimate is the one that would have come out had
//! it been known at once: the order of arrival within the memory does not matter, to the bit.

use super::Model;
use crate::{Scalar, Tick};
use heapless::Deque;
use nalgebra::{Cholesky, SMatrix, SVector};

/// Why a measurement did not enter the filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectedMeasurement {
    /// Older than the filter remembers.
    TooOld,
    /// From a cycle that has not begun: the two ends' ticks disagree.
    Future,
    /// There is already one for that cycle.
    Duplicate,
    /// It holds a number that is not finite.
    NotFinite,
}

/// One remembered cycle.
#[derive(Debug, Clone)]
struct Cycle<T, const NX: usize, const NU: usize, const NY: usize> {
    prior_mean: SVector<T, NX>,
    prior_covariance: SMatrix<T, NX, NX>,
    measured: Option<SVector<T, NY>>,
    /// What the actuator applied in this cycle, as far as is known.
    input: SVector<T, NU>,
}

/// State estimate given everything that has arrived.
///
/// `H` is the capacity of the memory in cycles, the current one included; how late a measurement may be is
/// data. What applied in a cycle is known only after it, so the filter runs as lazily as it can: a cycle's
/// input enters when the next one is filtered, and the plain path costs one prediction and one update.
#[derive(Debug, Clone)]
pub struct Kalman<T: Scalar, const NX: usize, const NU: usize, const NY: usize, const H: usize> {
    /// The current cycle, the last one in memory.
    tick: Tick,
    /// Most cycles a measurement may be late, `N^B`.
    measurement_buffer: usize,
    /// Oldest first, the current cycle last. Never empty.
    memory: Deque<Cycle<T, NX, NU, NY>, H>,
    /// Position of the cycle whose posterior is at hand; `None` before the first is filtered.
    filtered: Option<usize>,
    /// Position of the first cycle that must be filtered again, if any.
    changed: Option<usize>,
    posterior_mean: SVector<T, NX>,
    posterior_covariance: SMatrix<T, NX, NX>,
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize, const H: usize> Kalman<T, NX, NU, NY, H> {
    /// A filter whose first cycle is `tick` and which takes measurements up to `measurement_buffer` cycles
    /// late (`N^B`, thesis 3.34), at most `H - 1`.
    ///
    /// Does not compile for `H < 2`: the last cycle's input becomes known in the current one.
    pub fn new(model: &Model<T, NX, NU, NY>, measurement_buffer: usize, tick: Tick) -> Self {
        const { assert!(H >= 2, "the filter must remember the current cycle and the one before") };
        let mut memory = Deque::new();
        // There is room: H >= 2.
        let _ = memory.push_back(Cycle {
            prior_mean: model.initial_mean,
            prior_covariance: model.initial_covariance,
            measured: None,
            input: SVector::zeros(),
        });
        Self {
            tick,
            measurement_buffer: measurement_buffer.min(H - 1),
            memory,
            filtered: None,
            changed: Some(0),
            posterior_mean: model.initial_mean,
            posterior_covariance: model.initial_covariance,
        }
    }

    /// The current cycle.
    pub fn tick(&self) -> Tick {
        self.tick
    }

    /// Position of `tick` in memory.
    fn position(&self, tick: Tick) -> Option<usize> {
        let age = usize::try_from(self.tick.age_of(tick)?).ok()?;
        (self.memory.len() - 1).checked_sub(age)
    }

    fn must_filter_from(&mut self, position: usize) {
        self.changed = Some(self.changed.map_or(position, |earlier| earlier.min(position)));
    }

    /// Takes the measurement of cycle `tick`, late or not. [`Kalman::filter`] makes it count.
    ///
    /// # Errors
    /// Says why the filter did not take it.
    pub fn measure(&mut self, tick: Tick, output: SVector<T, NY>) -> Result<(), RejectedMeasurement> {
        if !output.iter().all(|value| value.is_finite()) {
            return Err(RejectedMeasurement::NotFinite);
        }
        let age = self.tick.age_of(tick).ok_or(RejectedMeasurement::Future)?;
        let position = self.position(tick).ok_or(RejectedMeasurement::TooOld)?;
        if usize::try_from(age).map_or(true, |age| age > self.measurement_buffer) {
            return Err(RejectedMeasurement::TooOld);
        }
        let cycle = self.memory.iter_mut().nth(position).ok_or(RejectedMeasurement::TooOld)?;
        if cycle.measured.is_some() {
            return Err(RejectedMeasurement::Duplicate);
        }
        cycle.measured = Some(output);
        if self.filtered.is_some_and(|filtered| position <= filtered) {
            self.must_filter_from(position);
        }
        Ok(())
    }

    /// What is held to be the input of cycle `tick`; `None` if the filter does not remember that cycle.
    pub fn input(&self, tick: Tick) -> Option<&SVector<T, NU>> {
        self.memory.iter().nth(self.position(tick)?).map(|cycle| &cycle.input)
    }

    /// Sets the input applied in cycle `tick`. [`Kalman::filter`] makes it count.
    ///
    /// Returns whether the filter still remembers that cycle.
    pub fn set_input(&mut self, tick: Tick, input: SVector<T, NU>) -> bool {
        let Some(position) = self.position(tick) else { return false };
        let Some(cycle) = self.memory.iter_mut().nth(position) else { return false };
        let differs = cycle.input != input;
        cycle.input = input;
        // An input acts on the next cycle's prior; if that is not computed yet there is nothing to redo.
        if differs && self.filtered.is_some_and(|filtered| position < filtered) {
            self.must_filter_from(position);
        }
        true
    }

    /// Filters up to the current cycle, again from the first cycle whose data changed.
    pub fn filter(&mut self, model: &Model<T, NX, NU, NY>) {
        let (start, mut prior) = match (self.changed.take(), self.filtered) {
            (Some(changed), _) => (changed, None),
            (None, None) => (0, None),
            (None, Some(filtered)) => {
                let input = self.memory.iter().nth(filtered).map_or_else(SVector::zeros, |cycle| cycle.input);
                (filtered + 1, Some(predict(model, &self.posterior_mean, &self.posterior_covariance, &input)))
            }
        };
        let last = self.memory.len() - 1;
        for (position, cycle) in self.memory.iter_mut().enumerate().skip(start) {
            if let Some((mean, covariance)) = prior {
                cycle.prior_mean = mean;
                cycle.prior_covariance = covariance;
            }
            let (mean, covariance) = match &cycle.measured {
                Some(output) => update(model, &cycle.prior_mean, &cycle.prior_covariance, output),
                None => (cycle.prior_mean, cycle.prior_covariance),
            };
            if position < last {
                prior = Some(predict(model, &mean, &covariance, &cycle.input));
            }
            self.posterior_mean = mean;
            self.posterior_covariance = covariance;
        }
        self.filtered = Some(last);
    }

    /// Moves on to the next cycle; `input` is what is held to be applied in the one that ends, until
    /// [`Kalman::set_input`] knows better.
    pub fn advance(&mut self, model: &Model<T, NX, NU, NY>, input: SVector<T, NU>) {
        self.filter(model);
        if let Some(current) = self.memory.back_mut() {
            current.input = input;
        }
        if self.memory.is_full() || self.memory.len() > self.measurement_buffer.max(1) {
            self.memory.pop_front();
            self.filtered = self.filtered.and_then(|filtered| filtered.checked_sub(1));
        }
        // The prior is a placeholder: the next `filter` predicts it, when the input is known.
        let _ = self.memory.push_back(Cycle {
            prior_mean: self.posterior_mean,
            prior_covariance: self.posterior_covariance,
            measured: None,
            input: SVector::zeros(),
        });
        self.tick += 1;
    }

    /// Estimate of the state in the last cycle that was filtered, given everything taken before that.
    pub fn posterior_mean(&self) -> &SVector<T, NX> {
        &self.posterior_mean
    }

    /// Covariance of the error of [`Kalman::posterior_mean`].
    pub fn posterior_covariance(&self) -> &SMatrix<T, NX, NX> {
        &self.posterior_covariance
    }
}

/// One cycle ahead: `A x + B u`, `A P A^T + W`.
///
/// Without a measurement for long enough an unstable plant's prediction overflows; by then nothing is known
/// any more, and the filter starts anew from the initial mean and covariance rather than carry a NaN.
fn predict<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    model: &Model<T, NX, NU, NY>,
    mean: &SVector<T, NX>,
    covariance: &SMatrix<T, NX, NX>,
    input: &SVector<T, NU>,
) -> (SVector<T, NX>, SMatrix<T, NX, NX>) {
    let mean = model.a * mean + model.b * input;
    let covariance = symmetric(model.a * covariance * model.a.transpose() + model.process_noise);
    if all_finite(&mean, &covariance) {
        (mean, covariance)
    } else {
        (model.initial_mean, model.initial_covariance)
    }
}

/// Measurement update in Joseph's form, which keeps the covariance positive semidefinite in `f32`.
///
/// A measurement whose innovation covariance is not numerically positive definite, or which would make the
/// estimate overflow, tells nothing that could be used and is left out.
fn update<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    model: &Model<T, NX, NU, NY>,
    mean: &SVector<T, NX>,
    covariance: &SMatrix<T, NX, NX>,
    output: &SVector<T, NY>,
) -> (SVector<T, NX>, SMatrix<T, NX, NX>) {
    let output_covariance = model.c * covariance;
    let innovation_covariance = output_covariance * model.c.transpose() + model.measurement_noise;
    let Some(factor) = Cholesky::new(symmetric(innovation_covariance)) else {
        return (*mean, *covariance);
    };
    let filter_gain = factor.solve(&output_covariance).transpose();
    let posterior_mean = mean + filter_gain * (output - model.c * mean);
    let kept = SMatrix::<T, NX, NX>::identity() - filter_gain * model.c;
    let posterior = kept * covariance * kept.transpose()
        + filter_gain * model.measurement_noise * filter_gain.transpose();
    if all_finite(&posterior_mean, &posterior) {
        (posterior_mean, symmetric(posterior))
    } else {
        (*mean, *covariance)
    }
}

fn all_finite<T: Scalar, const NX: usize>(mean: &SVector<T, NX>, covariance: &SMatrix<T, NX, NX>) -> bool {
    mean.iter().chain(covariance.iter()).all(|value| value.is_finite())
}

fn symmetric<T: Scalar, const D: usize>(matrix: SMatrix<T, D, D>) -> SMatrix<T, D, D> {
    (matrix + matrix.transpose()) * T::nearest(0.5)
}
