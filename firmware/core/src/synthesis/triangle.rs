//! Symmetric matrices by rows of their lower triangle: row `i` has entries `0..=i`, and the first rows alone are the
//! leading square.

use crate::Number;
use core::ops::Range;

/// Numbers in the triangle of a square of `size` rows.
pub(super) const fn len(size: usize) -> usize {
    size * (size + 1) / 2
}

/// Where row `row` stands.
pub(super) const fn row(row: usize) -> Range<usize> {
    len(row)..len(row + 1)
}

/// Entry `(row, column)`, in either order.
pub(super) fn entry<T: Number>(matrix: &[T], row: usize, column: usize) -> T {
    matrix[len(row.max(column)) + row.min(column)]
}
