//! Sums and products of dense row-major slices, each with its order of summation fixed.
//!
//! Own code and not nalgebra's dynamic matrices: those need a heap, and choose their order of summation by
//! platform and feature. Only what the recursion uses is here.

use crate::Number;

/// Every `stride`-th of some numbers, or the rows that begin there.
pub(super) type Strided<'m, T> = (&'m [T], usize);

/// `out += scale * sum of factor row`, of `count` factors and rows in their order. Four rows are added in one pass, so that
/// `out` is read and written once for them.
pub(super) fn add_rows<T: Number>(
    out: &mut [T],
    scale: T,
    count: usize,
    (factors, factor_stride): Strided<'_, T>,
    (rows, row_stride): Strided<'_, T>,
) {
    let (mut factors, mut rows, mut left) = (factors, rows, count);
    while left > 4 {
        add_four(out, scale, (factors, factor_stride), (rows, row_stride));
        (factors, rows) = (&factors[4 * factor_stride..], &rows[4 * row_stride..]);
        left -= 4;
    }
    match left {
        0 => (),
        1 => add_scaled(out, scale * factors[0], rows),
        2 => add_two(out, scale, (factors, factor_stride), (rows, row_stride)),
        3 => {
            add_two(out, scale, (factors, factor_stride), (rows, row_stride));
            add_scaled(out, scale * factors[2 * factor_stride], &rows[2 * row_stride..]);
        }
        _ => add_four(out, scale, (factors, factor_stride), (rows, row_stride)),
    }
}

// Functions of their own, so that the compiler knows that what is written does not overlap what is read.

#[inline(never)]
fn add_four<T: Number>(
    out: &mut [T],
    scale: T,
    (factors, factor_stride): Strided<'_, T>,
    (rows, row_stride): Strided<'_, T>,
) {
    let width = out.len();
    let (first, rows) = (&rows[..width], &rows[row_stride..]);
    let (second, rows) = (&rows[..width], &rows[row_stride..]);
    let (third, fourth) = (&rows[..width], &rows[row_stride..][..width]);
    let (first_factor, factors) = (scale * factors[0], &factors[factor_stride..]);
    let (second_factor, factors) = (scale * factors[0], &factors[factor_stride..]);
    let (third_factor, fourth_factor) = (scale * factors[0], scale * factors[factor_stride]);
    for index in 0..width {
        out[index] = out[index]
            + first_factor * first[index]
            + second_factor * second[index]
            + third_factor * third[index]
            + fourth_factor * fourth[index];
    }
}

#[inline(never)]
fn add_two<T: Number>(
    out: &mut [T],
    scale: T,
    (factors, factor_stride): Strided<'_, T>,
    (rows, row_stride): Strided<'_, T>,
) {
    let width = out.len();
    let (first, second) = (&rows[..width], &rows[row_stride..][..width]);
    let factors = [scale * factors[0], scale * factors[factor_stride]];
    for index in 0..width {
        out[index] = out[index] + factors[0] * first[index] + factors[1] * second[index];
    }
}

/// `tile += scale * a^T b`, of as many columns of `a` from the first given one on as the tile has rows, and the same of `b`; both
/// have `columns` in all. Sums go by the rows of `a` and `b`, and stay in registers.
#[inline(never)]
pub(super) fn add_tile<T: Number, const SIZE: usize>(
    tile: &mut [[T; SIZE]; SIZE],
    scale: T,
    (a, first_a): (&[T], usize),
    (b, first_b): (&[T], usize),
    columns: usize,
) {
    let mut sums = *tile;
    for (a, b) in a.chunks_exact(columns).zip(b.chunks_exact(columns)) {
        let (a, b) = (&a[first_a..][..SIZE], &b[first_b..][..SIZE]);
        // The sign is applied to the smaller number of factors.
        let factors: [T; SIZE] = core::array::from_fn(|row| scale * a[row]);
        for row in 0..SIZE {
            for column in 0..SIZE {
                sums[row][column] += factors[row] * b[column];
            }
        }
    }
    *tile = sums;
}

/// `out += scale * row`.
pub(super) fn add_scaled<T: Number>(out: &mut [T], scale: T, row: &[T]) {
    for (value, term) in out.iter_mut().zip(row) {
        *value += scale * *term;
    }
}

/// `out *= scale`.
pub(super) fn scale<T: Number>(out: &mut [T], scale: T) {
    for value in out {
        *value *= scale;
    }
}

/// `out += a b`, with `a` of `columns_a` columns and `b` of `columns_b`.
pub(super) fn add_product<T: Number>(
    out: &mut [T],
    (a, columns_a): (&[T], usize),
    (b, columns_b): (&[T], usize),
) {
    if columns_a == 0 || columns_b == 0 {
        return;
    }
    for (out_row, a_row) in out.chunks_exact_mut(columns_b).zip(a.chunks_exact(columns_a)) {
        add_rows(out_row, T::one(), columns_a, (a_row, 1), (b, columns_b));
    }
}

/// `out += a^T b`, with `a` of `columns_a` columns and `b` of `columns_b`, both of as many rows.
pub(super) fn add_transposed_product<T: Number>(
    out: &mut [T],
    (a, columns_a): (&[T], usize),
    (b, columns_b): (&[T], usize),
) {
    if columns_a == 0 || columns_b == 0 {
        return;
    }
    for (column, out_row) in out.chunks_exact_mut(columns_b).take(columns_a).enumerate() {
        add_rows(out_row, T::one(), a.len() / columns_a, (&a[column..], columns_a), (b, columns_b));
    }
}

/// Sum of products in index order.
pub(super) fn dot<T: Number>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + *a * *b)
}

/// Copies the upper triangle of a square matrix of `size` rows onto the lower one.
pub(super) fn mirror_upper<T: Number>(matrix: &mut [T], size: usize) {
    for row in 1..size {
        for column in 0..row {
            matrix[row * size + column] = matrix[column * size + row];
        }
    }
}
