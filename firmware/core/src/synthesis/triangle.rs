//! Symmetric matrices by rows of their lower triangle: row `i` has entries `0..=i`, and the first rows alone are the
//! leading square.

use crate::Number;
use core::ops::Range;

// Inlined: a row is short, and its place is asked for as often as the row is.

/// Numbers in the triangle of a square of `size` rows.
#[inline]
pub(super) const fn len(size: usize) -> usize {
    size * (size + 1) / 2
}

/// Where row `row` stands.
#[inline]
pub(super) const fn row(row: usize) -> Range<usize> {
    len(row)..len(row + 1)
}

/// Entry `(row, column)`, in either order.
#[inline]
pub(super) fn entry<T: Number>(matrix: &[T], row: usize, column: usize) -> T {
    matrix[len(row.max(column)) + row.min(column)]
}
