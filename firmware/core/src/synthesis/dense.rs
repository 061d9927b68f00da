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

/// Sum of products. Four partial sums, each in index order, added pairwise: as deterministic as one, and four times
/// as fast where additions take several cycles.
pub(super) fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    let (a_fours, b_fours) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = a_fours.remainder().iter().zip(b_fours.remainder());
    let rest = rest.fold(T::zero(), |sum, (a, b)| sum + *a * *b);
    let mut sums = [T::zero(); 4];
    for (a, b) in a_fours.zip(b_fours) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += *a * *b;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
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
