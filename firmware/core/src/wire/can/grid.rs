//! `Grid`: the values that counts of a step can express.
//!
//! Where grids come from is the generator's business; when inputs are rounded to one, [`crate::controller`]'s.

use crate::Scalar;
use nalgebra::SVector;

/// The largest count there is. Its negative is the smallest one: the range is symmetric, and -32768 is no count.
pub const LARGEST_COUNT: i16 = i16::MAX;
/// The largest count in a frame that is full, that is of [`super::MOST_VALUES`]: its counts have 13 bits.
pub const LARGEST_OF_FULL_FRAME: i16 = (1 << 12) - 1;

/// The largest count that a compact frame of `values` values has room for.
pub const fn largest_count(values: usize) -> i16 {
    if values < super::MOST_VALUES { LARGEST_COUNT } else { LARGEST_OF_FULL_FRAME }
}

/// Vectors whose entries are whole multiples of a step each: `value = count * step`, rounded as the scalar rounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid<T, const D: usize> {
    /// What a count of one stands for, in the entry's unit; positive.
    pub step: SVector<T, D>,
    /// Largest absolute count, 1 to [`LARGEST_COUNT`]; values beyond it saturate.
    pub largest_count: i16,
}

impl<T: Scalar, const D: usize> Grid<T, D> {
    /// Whether every step is positive and every value on the grid finite.
    pub fn is_valid(&self) -> bool {
        let most = T::nearest(f64::from(self.largest_count));
        // NaN is not positive.
        self.largest_count >= 1 && self.step.iter().all(|&step| step > T::zero() && (step * most).is_finite())
    }

    /// The value on the grid that is nearest to each entry. One that is not finite stays what it is.
    ///
    /// Ties of the rounded quotient by the step go away from zero. Beyond the largest count an entry saturates. What is on
    /// the grid stays there to the bit, except that zero loses its sign.
    pub fn round(&self, vector: &SVector<T, D>) -> SVector<T, D> {
        vector.zip_map(&self.step, |value, step| {
            self.count(value, step).map_or(value, |count| self.value(count, step))
        })
    }

    /// The count nearest to `value`; `None` if that is not finite.
    pub(super) fn count(&self, value: T, step: T) -> Option<i16> {
        if !value.is_finite() {
            return None;
        }
        let largest = T::nearest(f64::from(self.largest_count));
        // A quotient of 32767 counts is wrong by less than 1/100 in f32: a value on the grid finds its own count.
        let count = (value / step).round().max(-largest).min(largest);
        Some(count.widen() as i16)
    }

    /// What `count` stands for: the same bits at both ends of the bus.
    pub(super) fn value(&self, count: i16, step: T) -> T {
        T::nearest(f64::from(count)) * step
    }

    /// `counts` as values; `None` if one is beyond the largest count.
    pub(super) fn values(&self, counts: &SVector<i16, D>) -> Option<SVector<T, D>> {
        let most = self.largest_count.unsigned_abs();
        let is_counted = counts.iter().all(|count| count.unsigned_abs() <= most);
        is_counted.then(|| counts.zip_map(&self.step, |count, step| self.value(count, step)))
    }
}
