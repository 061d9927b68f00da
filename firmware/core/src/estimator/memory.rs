//! What the filter remembers of each cycle, in memory that is lent.
//!
//! Cycles stand in a ring. Of each there are its numbers, [`Cycle`]; the probabilities of the ages in the cycle before it,
//! `N + 1`; and the estimates, one or one for each age.

use super::{Estimate, Model, plausibility::Standing};
use crate::{
    Scalar,
    integrity::place_of,
    played::{Age, Ages, Modes},
};
use nalgebra::SVector;

/// One remembered cycle.
#[derive(Debug, Clone)]
pub struct Cycle<T, const NU: usize, const NY: usize> {
    pub(super) measured: Option<SVector<T, NY>>,
    /// The age played in this cycle, if it was acknowledged.
    pub(super) known: Option<Age>,
    /// Estimates given all measurements up to this cycle's; zero before it is filtered for the first time. One stands for
    /// every age that is possible.
    estimates: usize,
    /// The age played in the cycle before, if it is certain.
    certain: Option<Age>,
    /// What was applied in the cycle before: if the buffer was empty then, or inputs may change so much in a cycle only; or
    /// the mean of it.
    pub(super) held: SVector<T, NU>,
    /// How measurements up to this cycle's have fitted.
    pub(super) standing: Standing<NY>,
}

impl<T: Scalar, const NU: usize, const NY: usize> Cycle<T, NU, NY> {
    /// Of which nothing is known.
    pub const EMPTY: Self = Self {
        measured: None,
        known: None,
        estimates: 0,
        certain: None,
        held: SVector::from_array_storage(nalgebra::ArrayStorage([[T::ZERO; NU]])),
        standing: Standing::START,
    };
}

/// Cycles, probabilities and estimates, as they are lent.
#[derive(Debug)]
pub struct Remembered<'m, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    pub(super) cycles: &'m mut [Cycle<T, NU, NY>],
    ages: &'m mut [T],
    /// Probabilities for each cycle.
    likely: usize,
    estimates: &'m mut [Estimate<T, NX>],
    /// Estimates for each cycle.
    kept: usize,
}

/// What is believed in one cycle, given all measurements up to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Belief<'b, T: Scalar, const NX: usize, const NU: usize> {
    /// The age played in the cycle before.
    pub(super) modes: Modes<'b, T, NU>,
    /// One for each possible age, in the order of [`Modes::iter`]; or a single one for all of them.
    pub(super) estimates: &'b [Estimate<T, NX>],
}

/// Room for what is believed in one cycle.
#[derive(Debug)]
pub(super) struct Room<'b, T: Scalar, const NX: usize, const NU: usize> {
    pub(super) ages: &'b mut [T],
    pub(super) estimates: &'b mut [Estimate<T, NX>],
    pub(super) held: &'b mut SVector<T, NU>,
    certain: &'b mut Option<Age>,
    count: &'b mut usize,
}

impl<T: Scalar, const NX: usize, const NU: usize> Room<'_, T, NX, NU> {
    /// `age` was played for certain; `held` is what was applied if that is [`Age::Empty`]. Room for the estimate: there is
    /// always some.
    pub(super) fn certain(&mut self, age: Age, held: SVector<T, NU>) -> Option<&mut Estimate<T, NX>> {
        (*self.certain, *self.held) = (Some(age), held);
        self.single()
    }

    /// Room for one estimate for all ages: there is always some.
    pub(super) fn single(&mut self) -> Option<&mut Estimate<T, NX>> {
        *self.count = 1;
        self.estimates.first_mut()
    }

    /// Writes a number for `age`; of sequences longer than any there is it has no place.
    pub(super) fn set(&mut self, age: Age, number: T) {
        let empty = self.ages.len().saturating_sub(1);
        let place = age.steps().map_or(empty, |steps| if steps < empty { steps } else { usize::MAX });
        if let Some(entry) = self.ages.get_mut(place) {
            *entry = number;
        }
    }

    /// The probabilities that were written are those of the ages, but for a factor.
    pub(super) fn put_ages(&mut self) {
        let sum = self.ages.iter().fold(T::zero(), |sum, probability| sum + *probability);
        if sum > T::zero() {
            self.ages.iter_mut().for_each(|probability| *probability /= sum);
        }
        *self.certain = Modes { ages: Ages::Likely(&*self.ages), held: *self.held }.known();
    }

    /// The numbers that were written are logarithms of probabilities, of which `largest` is the largest; there is an estimate
    /// for each that is not minus infinity, in order. What is too unlikely for a number is forgotten with its estimate.
    pub(super) fn weigh(&mut self, largest: T) {
        let impossible = -T::nearest(f64::INFINITY);
        let (mut found, mut kept) = (0, 0);
        for entry in self.ages.iter_mut() {
            let logarithm = core::mem::replace(entry, T::zero());
            if logarithm == impossible {
                continue;
            }
            *entry = (logarithm - largest).exponential();
            if *entry > T::zero() {
                if let Some((before, [estimate, ..])) = self.estimates.split_at_mut_checked(found)
                    && let Some(forgotten) = before.get_mut(kept)
                {
                    forgotten.clone_from(estimate);
                }
                kept += 1;
            }
            found += 1;
        }
        *self.count = kept;
        self.put_ages();
    }
}

/// Estimates that are lent for `cycles` cycles, if `kept` are kept at once. Saturates.
pub const fn estimates_len(cycles: usize, kept: usize) -> usize {
    // Where several are kept they are merged into one more.
    if kept > 1 { cycles.saturating_mul(kept).saturating_add(1) } else { cycles }
}

impl<'m, T: Scalar, const NX: usize, const NU: usize, const NY: usize> Remembered<'m, T, NX, NU, NY> {
    /// Memory for a filter that remembers one cycle less than `cycles` has, the current one included, of sequences of `length`
    /// inputs; it keeps `kept` estimates at once.
    ///
    /// `None` if that is less than 2 cycles, no estimate, or `ages` has less than `length + 1` numbers for each of `cycles`, or
    /// `estimates` fewer than [`estimates_len`].
    pub fn new(
        cycles: &'m mut [Cycle<T, NU, NY>],
        ages: &'m mut [T],
        estimates: &'m mut [Estimate<T, NX>],
        length: usize,
        kept: usize,
    ) -> Option<Self> {
        let is_enough = cycles.len() > 2
            && kept >= 1
            && ages.len() >= cycles.len().saturating_mul(length.saturating_add(1))
            && estimates.len() >= estimates_len(cycles.len(), kept);
        let estimates = estimates.get_mut(..estimates_len(cycles.len(), kept))?;
        is_enough.then(|| Self { cycles, ages, likely: length + 1, estimates, kept })
    }

    /// Forgets all cycles; the estimate of the first is what is known before it.
    // Once in flash, for the first start and those after it.
    #[inline(never)]
    pub(super) fn begin(&mut self, model: &Model<T, NX, NU, NY>) {
        self.cycles.fill(Cycle::EMPTY);
        if let Some(estimate) = self.estimates.first_mut() {
            *estimate = Estimate::initial(model);
        }
    }

    /// What a checksum is taken of: where this memory is, and how it is divided.
    pub(super) fn word(&self) -> u32 {
        let Self { cycles, ages, likely, estimates, kept } = self;
        place_of(cycles) ^ place_of(ages) ^ place_of(estimates) ^ *likely as u32 ^ *kept as u32
    }

    /// The same for a filter that is told the mean of the input, and keeps no ages.
    pub fn without_ages(
        cycles: &'m mut [Cycle<T, NU, NY>],
        estimates: &'m mut [Estimate<T, NX>],
    ) -> Option<Self> {
        let estimates = estimates.get_mut(..cycles.len())?;
        (cycles.len() > 2).then_some(Self { cycles, ages: &mut [], likely: 0, estimates, kept: 1 })
    }

    /// What is believed in the cycle at `place`; `None` before it is filtered for the first time.
    pub(super) fn belief(&self, place: usize) -> Option<Belief<'_, T, NX, NU>> {
        let (likely, kept) = (self.likely, self.kept);
        let cycle = self.cycles.get(place).filter(|cycle| cycle.estimates > 0)?;
        Some(Belief {
            modes: Modes {
                ages: match cycle.certain {
                    Some(age) => Ages::Certain(age),
                    None => Ages::Likely(self.ages.get(place * likely..)?.get(..likely)?),
                },
                held: cycle.held,
            },
            estimates: self.estimates.get(place * kept..)?.get(..cycle.estimates)?,
        })
    }

    /// Room for what is believed in the cycle at `place`.
    pub(super) fn room(&mut self, place: usize) -> Option<Room<'_, T, NX, NU>> {
        let (likely, kept) = (self.likely, self.kept);
        let cycle = self.cycles.get_mut(place)?;
        Some(Room {
            ages: self.ages.get_mut(place * likely..)?.get_mut(..likely)?,
            estimates: self.estimates.get_mut(place * kept..)?.get_mut(..kept)?,
            held: &mut cycle.held,
            certain: &mut cycle.certain,
            count: &mut cycle.estimates,
        })
    }

    /// What is believed in the cycle at `from`, if that is filtered, and room for it in the other one at `to`.
    #[allow(clippy::type_complexity)]
    pub(super) fn belief_and_room(
        &mut self,
        from: usize,
        to: usize,
    ) -> Option<(Option<Belief<'_, T, NX, NU>>, Room<'_, T, NX, NU>)> {
        let (likely, kept) = (self.likely, self.kept);
        let ([before], [cycle]) = two(self.cycles, 1, from, to)? else { return None };
        let (ages_before, ages) = two(self.ages, likely, from, to)?;
        let (estimates_before, estimates) = two(self.estimates, kept, from, to)?;
        let ages_before = match before.certain {
            Some(age) => Ages::Certain(age),
            None => Ages::Likely(&*ages_before),
        };
        let belief = Belief {
            modes: Modes { ages: ages_before, held: before.held },
            estimates: estimates_before.get(..before.estimates)?,
        };
        let room = Room {
            ages,
            estimates,
            held: &mut cycle.held,
            certain: &mut cycle.certain,
            count: &mut cycle.estimates,
        };
        Some(((before.estimates > 0).then_some(belief), room))
    }

    /// Where several estimates are merged into one; `None` where there is never more than one.
    pub(super) fn merged(&mut self) -> Option<&mut Estimate<T, NX>> {
        if self.kept > 1 { self.estimates.last_mut() } else { None }
    }

    /// The only estimate of the cycle at `place`, or else that of [`Remembered::merged`].
    pub(super) fn estimate(&self, place: Option<usize>) -> &Estimate<T, NX> {
        // There are as many estimates as places, at least: a filter has some.
        let place = place.map_or(self.estimates.len() - 1, |place| place * self.kept);
        &self.estimates[place]
    }
}

/// The entries of two places of `entries`, which has `stride` for each: those of `from`, and those of `to`.
#[inline]
fn two<E>(entries: &mut [E], stride: usize, from: usize, to: usize) -> Option<(&mut [E], &mut [E])> {
    let (first, second) = if from < to { (from, to) } else { (to, from) };
    // One after the other: the same place twice is none.
    let (before, after) = entries.split_at_mut_checked(second * stride)?;
    let first = before.get_mut(first * stride..)?.get_mut(..stride)?;
    let second = after.get_mut(..stride)?;
    Some(if from < to { (first, second) } else { (second, first) })
}
