//! Dense linear algebra for any [`Real`]: what nalgebra has for `f64` only.
//!
//! Sums run in index order, so that the same input gives the same bits everywhere.

use super::Extended;
use nalgebra::{DMatrix, Scalar};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A real number to compute with: `f64` or [`Extended`].
pub(crate) trait Real:
    Scalar
    + Copy
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Relative rounding error of one operation.
    const PRECISION: f64;
    /// The nearest `f64`.
    fn narrow(self) -> f64;
    /// Square root; zero of what is negative.
    fn root(self) -> Self;
    /// `a b`, of any matching shapes.
    fn multiply(a: &DMatrix<Self>, b: &DMatrix<Self>) -> DMatrix<Self>;
}

impl Real for f64 {
    const PRECISION: f64 = f64::EPSILON;
    fn narrow(self) -> f64 {
        self
    }
    fn root(self) -> Self {
        self.max(0.0).sqrt()
    }
    fn multiply(a: &DMatrix<Self>, b: &DMatrix<Self>) -> DMatrix<Self> {
        a * b
    }
}

impl Real for Extended {
    const PRECISION: f64 = f64::EPSILON * f64::EPSILON;
    fn narrow(self) -> f64 {
        self.rounded()
    }
    fn root(self) -> Self {
        self.sqrt()
    }
    fn multiply(a: &DMatrix<Self>, b: &DMatrix<Self>) -> DMatrix<Self> {
        let mut product = DMatrix::from_element(a.nrows(), b.ncols(), Self::ZERO);
        for (column, factors) in product.column_iter_mut().zip(b.column_iter()) {
            let mut column = column;
            for (part, factor) in a.column_iter().zip(factors.iter()) {
                if factor.magnitude() == 0.0 {
                    continue;
                }
                for (sum, entry) in column.iter_mut().zip(part.iter()) {
                    *sum += *entry * *factor;
                }
            }
        }
        product
    }
}

/// `a b`.
pub(crate) fn product<T: Real>(a: &DMatrix<T>, b: &DMatrix<T>) -> DMatrix<T> {
    T::multiply(a, b)
}

/// `a^T b`.
pub(crate) fn transposed_product<T: Real>(a: &DMatrix<T>, b: &DMatrix<T>) -> DMatrix<T> {
    T::multiply(&a.transpose(), b)
}

/// The same matrix in another precision.
pub(crate) fn widened<T: Real>(matrix: &DMatrix<f64>) -> DMatrix<T> {
    matrix.map(T::from)
}

/// Every entry rounded to `f64`.
pub(crate) fn rounded<T: Real>(matrix: &DMatrix<T>) -> DMatrix<f64> {
    matrix.map(T::narrow)
}

/// The mean of a square matrix and its transpose.
pub(crate) fn symmetric<T: Real>(matrix: &DMatrix<T>) -> DMatrix<T> {
    let half = T::from(0.5);
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| (matrix[(i, j)] + matrix[(j, i)]) * half)
}

/// Lower Cholesky factor of a symmetric positive definite matrix; `None` if it is not, to working precision.
pub(crate) fn cholesky<T: Real>(matrix: &DMatrix<T>) -> Option<DMatrix<T>> {
    let size = matrix.nrows();
    let zero = T::from(0.0);
    let mut factor = DMatrix::from_element(size, size, zero);
    for column in 0..size {
        for row in column..size {
            let mut rest = matrix[(row, column)];
            for before in 0..column {
                rest -= factor[(row, before)] * factor[(column, before)];
            }
            if row > column {
                factor[(row, column)] = rest / factor[(column, column)];
                continue;
            }
            let least = matrix[(row, row)].narrow() * T::PRECISION * size as f64;
            if rest.narrow() <= least || !rest.narrow().is_finite() {
                return None;
            }
            factor[(row, row)] = rest.root();
        }
    }
    Some(factor)
}

/// `L^-1 right` for a lower triangular matrix without zeros on its diagonal.
pub(crate) fn solve_lower<T: Real>(lower: &DMatrix<T>, right: &DMatrix<T>) -> DMatrix<T> {
    let mut solution = right.clone();
    for mut column in solution.column_iter_mut() {
        for row in 0..lower.nrows() {
            let mut rest = column[row];
            for before in 0..row {
                rest -= lower[(row, before)] * column[before];
            }
            column[row] = rest / lower[(row, row)];
        }
    }
    solution
}

/// `P M = L U` with rows exchanged for the largest pivot.
pub(crate) struct Lu<T: Real> {
    factors: DMatrix<T>,
    order: Vec<usize>,
}

impl<T: Real> Lu<T> {
    /// `None` if the square matrix is singular or not finite.
    pub(crate) fn new(mut factors: DMatrix<T>) -> Option<Self> {
        let size = factors.nrows();
        let mut order: Vec<usize> = (0..size).collect();
        for step in 0..size {
            let size_of = |row: usize| factors[(row, step)].narrow().abs();
            let pivot = (step..size).max_by(|&a, &b| size_of(a).total_cmp(&size_of(b)))?;
            if !(size_of(pivot) > 0.0 && size_of(pivot).is_finite()) {
                return None;
            }
            factors.swap_rows(step, pivot);
            order.swap(step, pivot);
            let diagonal = factors[(step, step)];
            for row in step + 1..size {
                factors[(row, step)] = factors[(row, step)] / diagonal;
            }
            for column in step + 1..size {
                let above = factors[(step, column)];
                if above.narrow() == 0.0 {
                    continue;
                }
                for row in step + 1..size {
                    let part = factors[(row, step)] * above;
                    factors[(row, column)] -= part;
                }
            }
        }
        Some(Self { factors, order })
    }

    /// `M^-1 right`.
    pub(crate) fn solve(&self, right: &DMatrix<T>) -> DMatrix<T> {
        let size = self.order.len();
        let mut solution =
            DMatrix::from_fn(size, right.ncols(), |row, column| right[(self.order[row], column)]);
        for mut column in solution.column_iter_mut() {
            for step in 0..size {
                let known = column[step];
                for row in step + 1..size {
                    column[row] -= self.factors[(row, step)] * known;
                }
            }
            for step in (0..size).rev() {
                column[step] = column[step] / self.factors[(step, step)];
                let known = column[step];
                for row in 0..step {
                    column[row] -= self.factors[(row, step)] * known;
                }
            }
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries `1 / (i + j + 1)`: the textbook example of a matrix that `f64` cannot invert.
    fn hilbert(size: usize) -> DMatrix<Extended> {
        DMatrix::from_fn(size, size, |i, j| Extended::ONE / Extended::from((i + j + 1) as f64))
    }

    #[test]
    fn a_matrix_beyond_f64_is_solved_to_f64() {
        let size = 12;
        let ones = DMatrix::from_element(size, 1, Extended::ONE);
        let right = product(&hilbert(size), &ones);
        let solution = Lu::new(hilbert(size)).expect("not singular").solve(&right);
        assert!(solution.iter().all(|value| (*value - Extended::ONE).magnitude() < 1e-14));
    }

    #[test]
    fn a_cholesky_factor_times_its_transpose_gives_the_matrix_back() {
        let matrix = hilbert(8);
        let factor = cholesky(&matrix).expect("positive definite");
        let again = product(&factor, &factor.transpose());
        assert!(again.iter().zip(matrix.iter()).all(|(a, b)| (*a - *b).magnitude() < 1e-30));
        let unit = solve_lower(&factor, &factor);
        assert!((rounded(&unit) - DMatrix::identity(8, 8)).amax() < 1e-20);
    }

    #[test]
    fn a_matrix_that_is_not_definite_has_no_factor() {
        assert!(cholesky(&DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0])).is_none());
    }
}
