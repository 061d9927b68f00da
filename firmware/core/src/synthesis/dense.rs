//! Products of dense row-major slices, each with its order of summation fixed.
//!
//! Own code and not nalgebra's dynamic matrices: those need a heap, and choose their order of summation by
//! platform and feature. Only what the recursion uses is here.

use crate::Scalar;

/// `out += scale * a b`, with `a` of `columns_a` columns and `b` of `columns_b`.
///
/// Each entry of `out` receives its terms in order of the inner index.
pub(super) fn add_product<T: Scalar>(
    out: &mut [T],
    scale: T,
    (a, columns_a): (&[T], usize),
    (b, columns_b): (&[T], usize),
) {
    if columns_a == 0 || columns_b == 0 {
        return;
    }
    for (out_row, a_row) in out.chunks_exact_mut(columns_b).zip(a.chunks_exact(columns_a)) {
        for (factor, b_row) in a_row.iter().zip(b.chunks_exact(columns_b)) {
            add_scaled(out_row, scale * *factor, b_row);
        }
    }
}

/// `out += scale * a^T b`, with `a` of `columns_a` columns and `b` of `columns_b`, both of as many rows.
pub(super) fn add_transposed_product<T: Scalar>(
    out: &mut [T],
    scale: T,
    (a, columns_a): (&[T], usize),
    (b, columns_b): (&[T], usize),
) {
    if columns_a == 0 || columns_b == 0 {
        return;
    }
    for (a_row, b_row) in a.chunks_exact(columns_a).zip(b.chunks_exact(columns_b)) {
        for (out_row, factor) in out.chunks_exact_mut(columns_b).zip(a_row) {
            add_scaled(out_row, scale * *factor, b_row);
        }
    }
}

/// `out += scale * row`.
pub(super) fn add_scaled<T: Scalar>(out: &mut [T], scale: T, row: &[T]) {
    for (value, term) in out.iter_mut().zip(row) {
        *value += scale * *term;
    }
}

/// Copies the upper triangle of a square matrix of `size` rows onto the lower one.
pub(super) fn mirror_upper<T: Scalar>(matrix: &mut [T], size: usize) {
    for row in 1..size {
        for column in 0..row {
            matrix[row * size + column] = matrix[column * size + row];
        }
    }
}
