//! Rank-revealing solution of `A X = B` for symmetric positive semidefinite `A`.
//!
//! The recursion's `Rbar` is singular when an input of the sequence can never be applied, and nearly so when
//! it is applied with tiny probability. Both are matters of scale, so the matrix is scaled to unit diagonal
//! before it is factored with diagonal pivoting: an input that is applied once in 1e20 cycles then gets its
//! gain as accurately as the first one, and an input without effect gets zero.

use super::dense::{add_scaled, dot};
use crate::Scalar;

/// Numbers a [`SemidefiniteFactor`] of `size` rows needs as workspace.
pub const fn workspace_len(size: usize) -> usize {
    size * size + 3 * size
}

/// Cholesky factor of `D A D` with diagonal pivoting, `D` scaling `A` to unit diagonal.
#[derive(Debug)]
pub struct SemidefiniteFactor<'w, T> {
    size: usize,
    rank: usize,
    /// Row `i` belongs to unknown `i`, column `j` to the `j`-th pivot; row-major.
    factor: &'w mut [T],
    /// Diagonal of `D`: one over the root of `A`'s diagonal, zero where that is zero.
    scale: &'w mut [T],
    /// What elimination has left of the unit diagonal.
    remaining: &'w mut [T],
    /// Unknowns in the order of their pivots. Indices kept as scalars, exactly, since the workspace is of one type.
    order: &'w mut [T],
}

impl<'w, T: Scalar> SemidefiniteFactor<'w, T> {
    /// Factors `matrix`, `size x size` row-major, of which only entries at and right of the diagonal count.
    ///
    /// Pivots below `16 size eps` of the unit diagonal count as zero (8e-14 for 24 rows in `f64`).
    ///
    /// # Panics
    /// If `matrix` has fewer than `size * size` entries or `workspace` fewer than [`workspace_len`].
    pub fn new(matrix: &[T], size: usize, workspace: &'w mut [T]) -> Self {
        let mut this = Self::resumed(size, 0, workspace);
        for i in 0..size {
            let diagonal = matrix[i * size + i];
            let effective = diagonal > T::zero();
            this.scale[i] = if effective { T::one() / diagonal.sqrt() } else { T::zero() };
            this.remaining[i] = if effective { T::one() } else { T::zero() };
        }
        let tolerance = T::nearest(16.0 * size as f64) * T::EPSILON;
        while this.rank < size {
            let Some(pivot) = this.largest_remaining(tolerance) else { break };
            this.eliminate(matrix, pivot);
        }
        this
    }

    /// The factor that [`SemidefiniteFactor::new`] left in `workspace`, of the rank it had.
    pub(super) fn resumed(size: usize, rank: usize, workspace: &'w mut [T]) -> Self {
        let (factor, rest) = workspace.split_at_mut(size * size);
        let (scale, rest) = rest.split_at_mut(size);
        let (remaining, order) = rest.split_at_mut(size);
        Self { size, rank, factor, scale, remaining, order }
    }

    /// Numerical rank.
    pub fn rank(&self) -> usize {
        self.rank
    }

    fn largest_remaining(&self, tolerance: T) -> Option<usize> {
        let mut best = None;
        let mut largest = tolerance;
        for (i, &value) in self.remaining.iter().enumerate() {
            if value > largest {
                largest = value;
                best = Some(i);
            }
        }
        best
    }

    fn eliminate(&mut self, matrix: &[T], pivot: usize) {
        let (size, column) = (self.size, self.rank);
        let diagonal = self.remaining[pivot].sqrt();
        self.remaining[pivot] = T::zero();
        for i in 0..size {
            if self.remaining[i] <= T::zero() {
                continue;
            }
            let upper = if i < pivot { i * size + pivot } else { pivot * size + i };
            let entry = matrix[upper] * self.scale[i] * self.scale[pivot];
            let eliminated = dot(&self.factor[i * size..][..column], &self.factor[pivot * size..][..column]);
            let value = (entry - eliminated) / diagonal;
            self.factor[i * size + column] = value;
            self.remaining[i] -= value * value;
        }
        self.factor[pivot * size + column] = diagonal;
        self.order[column] = T::nearest(pivot as f64);
        self.rank += 1;
    }

    fn pivot(&self, column: usize) -> usize {
        self.order[column].widen() as usize
    }

    /// Replaces `rhs`, `size x columns` row-major, by the solution; unknowns beyond the rank become zero.
    ///
    /// # Panics
    /// If `rhs` has fewer than `size * columns` entries.
    pub fn solve(&self, rhs: &mut [T], columns: usize) {
        let size = self.size;
        for step in 0..self.rank {
            let pivot = self.pivot(step);
            scale_row(rhs, columns, pivot, self.scale[pivot]);
            for earlier in 0..step {
                let factor = self.factor[pivot * size + earlier];
                subtract_row(rhs, columns, pivot, factor, self.pivot(earlier));
            }
            scale_row(rhs, columns, pivot, T::one() / self.factor[pivot * size + step]);
        }
        for step in (0..self.rank).rev() {
            let pivot = self.pivot(step);
            for later in step + 1..self.rank {
                let row = self.pivot(later);
                subtract_row(rhs, columns, pivot, self.factor[row * size + step], row);
            }
            scale_row(rhs, columns, pivot, T::one() / self.factor[pivot * size + step]);
        }
        // Unscale, and clear the rows that are no pivots. `order` names pivots only, so mark by membership.
        for row in 0..size {
            let is_pivot = (0..self.rank).any(|step| self.pivot(step) == row);
            scale_row(rhs, columns, row, if is_pivot { self.scale[row] } else { T::zero() });
        }
    }
}

fn scale_row<T: Scalar>(matrix: &mut [T], columns: usize, row: usize, factor: T) {
    for value in &mut matrix[row * columns..(row + 1) * columns] {
        *value *= factor;
    }
}

/// `matrix[row] -= factor * matrix[other]`, for two different rows.
fn subtract_row<T: Scalar>(matrix: &mut [T], columns: usize, row: usize, factor: T, other: usize) {
    let (before, after) = matrix.split_at_mut(row.max(other) * columns);
    let (low, high) = (&mut before[row.min(other) * columns..][..columns], &mut after[..columns]);
    let (target, source) = if row < other { (low, high) } else { (high, low) };
    add_scaled(target, -factor, source);
}
