//! What is seen of a measurement before any estimate: readings that a sensor cannot have, and one that does not change.

use super::Controller;
use crate::{
    Scalar, Tick,
    estimator::Plausibility,
    health::{Cause, Health},
    wire::Measurement,
};
use nalgebra::SVector;

/// The newest measurement, and for how long each of its outputs has read the same.
#[derive(Debug, Clone, Copy)]
pub(super) struct Watch<T, const NY: usize> {
    newest: Option<Tick>,
    readings: SVector<T, NY>,
    /// Readings that are the same to the bit, in a row; the first one is none.
    same: [u16; NY],
}

impl<T: Scalar, const NY: usize> Watch<T, NY> {
    pub(super) const NEW: Self = Self {
        newest: None,
        readings: SVector::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; NY]])),
        same: [0; NY],
    };

    /// What of `measurement` is to be believed in cycle `now` before anything else is known: what is not is no number.
    #[inline]
    pub(super) fn sees(
        &mut self,
        plausibility: &Plausibility<T, NY>,
        measurement: &Measurement<T, NY>,
        now: Tick,
    ) -> SVector<T, NY> {
        let mut output = measurement.output;
        // What is late tells nothing of how the sensor is now; and after one from a cycle to come nothing would be new any more.
        if !measurement.tick.is_after(now)
            && self.newest.is_none_or(|newest| measurement.tick.is_after(newest))
        {
            let is_first = self.newest.is_none();
            for (place, same) in self.same.iter_mut().enumerate() {
                let is_same = output[place] == self.readings[place] && !is_first;
                *same = if is_same { same.saturating_add(1) } else { 0 };
            }
            self.newest = Some(measurement.tick);
            self.readings = output;
        }
        if plausibility.rejects_stuck || plausibility.range.is_some() {
            for place in 0..NY {
                let is_stuck = plausibility.rejects_stuck && self.is_stuck(plausibility, place);
                if is_stuck || plausibility.is_out_of_range(place, output[place]) {
                    output[place] = T::nearest(f64::NAN);
                }
            }
        }
        output
    }

    fn is_stuck(&self, plausibility: &Plausibility<T, NY>, output: usize) -> bool {
        let after = plausibility.stuck_after.get(output).copied().unwrap_or_default();
        after > 0 && self.same.get(output).is_some_and(|same| *same >= after)
    }

    fn is_out_of_range(&self, plausibility: &Plausibility<T, NY>, output: usize) -> bool {
        self.newest.is_some() && plausibility.is_out_of_range(output, self.readings[output])
    }
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Controller<'_, T, NX, NU, NY> {
    /// Whether nothing was believed for so long that the loop is open, or memory has changed by itself.
    pub(super) fn is_lost(&self) -> bool {
        self.check.is_damaged || is_due(self.design.plausibility.lost_after, self.filter.standing().silent())
    }

    /// How this end of the loop is, after the cycle that ran last.
    ///
    /// While it is lost, [`Controller::cycle`] sends nothing: what it would send does not follow from the plant. The first
    /// measurement that is believed ends that. Where memory has changed by itself, only [`Controller::new`] does.
    pub fn health(&self) -> Health {
        let plausibility = self.design.plausibility;
        if self.check.is_damaged {
            return Health::Lost(Cause::Memory);
        }
        if self.is_lost() {
            return Health::Lost(Cause::NotMeasured);
        }
        let standing = self.filter.standing();
        let implausible = || {
            (0..NY).find(|output| {
                standing.rejected(*output) > 0 || self.watch.is_out_of_range(plausibility, *output)
            })
        };
        let stuck = || (0..NY).find(|output| self.watch.is_stuck(plausibility, *output));
        let cause = if self.last.not_finite {
            Some(Cause::NotFinite)
        } else if self.last.begun_anew {
            Some(Cause::BegunAnew)
        } else if is_due(plausibility.stale_after, standing.silent()) {
            Some(Cause::NotMeasured)
        } else if let Some(output) = implausible() {
            // No controller has more than 32 outputs.
            Some(Cause::Implausible(output as u8))
        } else {
            stuck().map(|output| Cause::Stuck(output as u8))
        };
        cause.map_or(Health::Nominal, Health::Degraded)
    }
}

/// Whether so many cycles are too many; after none nothing is.
fn is_due(after: u16, cycles: u16) -> bool {
    after > 0 && cycles >= after
}
