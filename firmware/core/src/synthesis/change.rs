//! How far a backward step moves the cost-to-go: the residual of the fixed-point equation.

use crate::Number;

/// Partial sums, whose order is fixed: pairs of entries are summed beside each other, for speed.
const LANES: usize = 2;

/// Writes a part of the cost-to-go and, if `MEASURED`, sums the absolute values of what it was changed by and of what it
/// became.
#[derive(Clone, Copy)]
pub(super) struct Change<T, const MEASURED: bool> {
    difference: [T; LANES],
    size: [T; LANES],
}

impl<T: Number, const MEASURED: bool> Change<T, MEASURED> {
    pub(super) fn none() -> Self {
        Self { difference: [T::zero(); LANES], size: [T::zero(); LANES] }
    }

    /// `entries` become `values`.
    #[inline(never)]
    pub(super) fn replace_all(&mut self, entries: &mut [T], values: &[T]) {
        *self = self.replaced(entries, values, values, |value, _| value);
    }

    /// `entries` become `values`, each times `factor`.
    #[inline(never)]
    pub(super) fn replace_scaled(&mut self, entries: &mut [T], values: &[T], factor: T) {
        *self = self.replaced(entries, values, values, |value, _| factor * value);
    }

    /// A triangle becomes the beginning of another one, each entry times `factor` and the weights of its row and column.
    #[inline(never)]
    pub(super) fn replace_triangle(&mut self, entries: &mut [T], values: &[T], factor: T, weights: &[T]) {
        let mut change = *self;
        let (mut entries, mut values) = (entries, values);
        for (row, weight) in weights.iter().enumerate() {
            if entries.is_empty() {
                break;
            }
            let (of_row, rest) = entries.split_at_mut(row + 1);
            let (new, later) = values.split_at(row + 1);
            (entries, values) = (rest, later);
            let factor = factor * *weight;
            change = change.replaced(of_row, new, weights, |value, weight| (factor * weight) * value);
        }
        *self = change;
    }

    /// The sums go through it by value: they stay in registers.
    #[inline(always)]
    fn replaced(mut self, entries: &mut [T], values: &[T], weights: &[T], new: impl Fn(T, T) -> T) -> Self {
        let length = entries.len();
        let (values, weights) = (&values[..length], &weights[..length]);
        if !MEASURED {
            for index in 0..length {
                entries[index] = new(values[index], weights[index]);
            }
            return self;
        }
        let mut pairs = entries.chunks_exact_mut(LANES);
        let (value_pairs, weight_pairs) = (values.chunks_exact(LANES), weights.chunks_exact(LANES));
        let rest = value_pairs.remainder().iter().zip(weight_pairs.remainder());
        for ((entries, values), weights) in pairs.by_ref().zip(value_pairs).zip(weight_pairs) {
            // Both are read before either is written.
            let new_pair = [new(values[0], weights[0]), new(values[1], weights[1])];
            let by = [new_pair[0] - entries[0], new_pair[1] - entries[1]];
            self.difference = [self.difference[0] + by[0].abs(), self.difference[1] + by[1].abs()];
            self.size = [self.size[0] + new_pair[0].abs(), self.size[1] + new_pair[1].abs()];
            entries[0] = new_pair[0];
            entries[1] = new_pair[1];
        }
        for (entry, (value, weight)) in pairs.into_remainder().iter_mut().zip(rest) {
            let value = new(*value, *weight);
            // Beside zero, so that the sums stay pairs.
            let by = [value - *entry, T::zero()];
            self.difference = [self.difference[0] + by[0].abs(), self.difference[1] + by[1].abs()];
            self.size = [self.size[0] + value.abs(), self.size[1] + T::zero().abs()];
            *entry = value;
        }
        self
    }

    /// Sum of the changes over sum of the values.
    pub(super) fn relative(self) -> T {
        let total = |sums: [T; LANES]| sums[0] + sums[1];
        let (difference, size) = (total(self.difference), total(self.size));
        // What has overflowed must not look settled: a maximum passes over NaN, and anything over infinity is 0.
        if !(size.is_finite() && difference.is_finite()) {
            return T::nearest(f64::INFINITY);
        }
        if size > T::zero() { difference / size } else { difference }
    }
}
