//! How far a backward step moves the cost-to-go: the residual of the fixed-point equation.

use crate::Scalar;

/// How much a part of the cost-to-go changed, in sums of absolute values.
///
/// Four partial sums each, for speed; their order is fixed.
#[derive(Clone, Copy)]
pub(super) struct Change<T> {
    difference: [T; 4],
    size: [T; 4],
}

impl<T: Scalar> Change<T> {
    pub(super) fn none() -> Self {
        Self { difference: [T::zero(); 4], size: [T::zero(); 4] }
    }

    pub(super) fn replace(&mut self, entry: &mut T, value: T) {
        self.difference[0] += (value - *entry).abs();
        self.size[0] += value.abs();
        *entry = value;
    }

    pub(super) fn replace_all(&mut self, entries: &mut [T], values: &[T]) {
        let mut fours = entries.chunks_exact_mut(4);
        let value_fours = values.chunks_exact(4);
        let rest = value_fours.remainder();
        for (entries, values) in fours.by_ref().zip(value_fours) {
            for lane in 0..4 {
                self.difference[lane] += (values[lane] - entries[lane]).abs();
                self.size[lane] += values[lane].abs();
            }
            entries.copy_from_slice(values);
        }
        for (entry, value) in fours.into_remainder().iter_mut().zip(rest) {
            self.replace(entry, *value);
        }
    }

    pub(super) fn relative(self) -> T {
        let total = |sums: [T; 4]| (sums[0] + sums[1]) + (sums[2] + sums[3]);
        let (difference, size) = (total(self.difference), total(self.size));
        // What has overflowed must not look settled: a maximum passes over NaN, and anything over infinity is 0.
        if !(size.is_finite() && difference.is_finite()) {
            return T::nearest(f64::INFINITY);
        }
        if size > T::zero() { difference / size } else { difference }
    }
}
