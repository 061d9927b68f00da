//! Rank-revealing solution of `A X = B` for symmetric positive semidefinite `A`.
//!
//! The recursion's `Rbar` is singular when an input of the sequence can never be applied, and nearly so when
//! it is applied with tiny probability. Both are matters of scale, so the matrix is scaled to unit diagonal
//! before it is factored with diagonal pivoting: an input that is applied once in 1e20 cycles then gets its
//! gain as accurately as the first one, and an input without effect gets zero.

use super::dense::{add_rows, scale};
use crate::Number;

/// Numbers a [`SemidefiniteFactor`] of `size` rows needs as workspace.
pub const fn workspace_len(size: usize) -> usize {
    size * size + 3 * size + 1
}

/// Cholesky factor `U^T U` of `D A D` with diagonal pivoting, `D` scaling `A` to unit diagonal.
#[derive(Debug)]
pub struct SemidefiniteFactor<'w, T> {
    size: usize,
    /// `U`, row-major: rows and columns in the order of the pivots, and behind them what is none.
    factor: &'w mut [T],
    /// Diagonal of `D` in the same order: one over the root of `A`'s diagonal, zero where that is zero.
    scale: &'w mut [T],
    /// What elimination has left of the unit diagonal, in the same order.
    remaining: &'w mut [T],
    /// The place from which each pivot came: with that it was exchanged. Indices kept as scalars, exactly, since the
    /// workspace is of one type.
    origin: &'w mut [T],
    /// Numerical rank, one number.
    rank: &'w mut [T],
}

impl<'w, T: Number> SemidefiniteFactor<'w, T> {
    /// Factors `matrix`, `size x size` row-major, of which only entries at and right of the diagonal count.
    ///
    /// Pivots below `16 size eps` of the unit diagonal count as zero (8e-14 for 24 rows in `f64`).
    ///
    /// # Panics
    /// If `matrix` has fewer than `size * size` entries or `workspace` fewer than [`workspace_len`].
    pub fn new(matrix: &[T], size: usize, workspace: &'w mut [T]) -> Self {
        let mut this = Self::resumed(size, workspace);
        for i in 0..size {
            let diagonal = matrix[i * size + i];
            let effective = diagonal > T::zero();
            this.scale[i] = if effective { T::one() / diagonal.sqrt() } else { T::zero() };
            this.remaining[i] = if effective { T::one() } else { T::zero() };
        }
        for (i, row) in this.factor.chunks_exact_mut(size.max(1)).enumerate() {
            let entries = matrix[i * size..][i..size].iter().zip(&this.scale[i..]);
            for (entry, (value, scale)) in row[i..].iter_mut().zip(entries) {
                *entry = *value * this.scale[i] * *scale;
            }
        }
        let tolerance = T::nearest(16.0 * size as f64) * T::EPSILON;
        let mut rank = 0;
        while let Some(pivot) = this.next_pivot(rank, tolerance) {
            this.exchange(rank, pivot);
            this.eliminate(rank);
            rank += 1;
        }
        this.rank[0] = T::nearest(rank as f64);
        this
    }

    /// The factor that [`SemidefiniteFactor::new`] left in `workspace`.
    pub(super) fn resumed(size: usize, workspace: &'w mut [T]) -> Self {
        let (factor, rest) = workspace.split_at_mut(size * size);
        let (scale, rest) = rest.split_at_mut(size);
        let (remaining, rest) = rest.split_at_mut(size);
        let (origin, rest) = rest.split_at_mut(size);
        Self { size, factor, scale, remaining, origin, rank: &mut rest[..1] }
    }

    /// Numerical rank.
    pub fn rank(&self) -> usize {
        index(self.rank[0]).min(self.size)
    }

    /// Where the next pivot stands, from `first` on: the largest one, unless the first is at least half of that; `None` if none
    /// is above `tolerance`.
    fn next_pivot(&self, first: usize, tolerance: T) -> Option<usize> {
        let remaining = &self.remaining[first..];
        let largest = remaining.iter().fold(tolerance, |largest, value| largest.max(*value));
        if largest <= tolerance {
            return None;
        }
        if remaining[0] + remaining[0] >= largest {
            return Some(first);
        }
        remaining.iter().position(|value| *value >= largest).map(|place| first + place)
    }

    /// Exchanges unknown `later` with the one at `place`, in all rows and columns: those above are of `U` already, the others
    /// still of `D A D`.
    fn exchange(&mut self, place: usize, later: usize) {
        self.origin[place] = T::nearest(later as f64);
        if later == place {
            return;
        }
        let size = self.size;
        for row in self.factor.chunks_exact_mut(size).take(place) {
            row.swap(place, later);
        }
        for between in place + 1..later {
            self.factor.swap(place * size + between, between * size + later);
        }
        let (above, below) = self.factor.split_at_mut(later * size);
        above[place * size..][later + 1..size].swap_with_slice(&mut below[later + 1..size]);
        self.scale.swap(place, later);
        self.remaining.swap(place, later);
    }

    /// Row `place` of `U`.
    fn eliminate(&mut self, place: usize) {
        let size = self.size;
        let (above, own) = self.factor.split_at_mut(place * size);
        let diagonal = self.remaining[place].sqrt();
        own[place] = diagonal;
        let next = place + 1;
        let own = &mut own[next..size];
        if !own.is_empty() {
            let factors = above.get(place..).unwrap_or_default();
            add_rows(own, -T::one(), place, (factors, size), (above.get(next..).unwrap_or_default(), size));
        }
        for (entry, remaining) in own.iter_mut().zip(&mut self.remaining[next..]) {
            *entry /= diagonal;
            *remaining -= *entry * *entry;
        }
    }

    /// Replaces `rhs`, `size x columns` row-major, by the solution; unknowns beyond the rank become zero.
    ///
    /// # Panics
    /// If `rhs` has fewer than `size * columns` entries.
    pub fn solve(&self, rhs: &mut [T], columns: usize) {
        self.solve_half(rhs, columns);
        self.solve_rest(rhs, columns);
    }

    /// Replaces `rhs` by `W = U^-T D rhs`, so that `W^T W = rhs^T A^# rhs`: rows in the order of the pivots, and those beyond the
    /// rank zero.
    pub(super) fn solve_half(&self, rhs: &mut [T], columns: usize) {
        let (size, rank) = (self.size, self.rank());
        for place in 0..rank {
            exchange_rows(rhs, columns, place, index(self.origin[place]));
        }
        for place in 0..rank {
            let (above, own) = rhs.split_at_mut(place * columns);
            let own = &mut own[..columns];
            scale(own, self.scale[place]);
            add_rows(own, -T::one(), place, (&self.factor[place..], size), (above, columns));
            scale(own, T::one() / self.factor[place * size + place]);
        }
        rhs[rank * columns..size * columns].fill(T::zero());
    }

    /// Replaces `W` of [`SemidefiniteFactor::solve_half`] by the solution.
    pub(super) fn solve_rest(&self, rhs: &mut [T], columns: usize) {
        let (size, rank) = (self.size, self.rank());
        for place in (0..rank).rev() {
            let (own, below) = rhs[place * columns..].split_at_mut(columns);
            let row = &self.factor[place * size..][place..size];
            add_rows(own, -T::one(), rank - place - 1, (&row[1..], 1), (below, columns));
            scale(own, T::one() / row[0]);
        }
        for (row, factor) in rhs.chunks_exact_mut(columns).zip(&self.scale[..rank]) {
            scale(row, *factor);
        }
        for place in (0..rank).rev() {
            exchange_rows(rhs, columns, place, index(self.origin[place]));
        }
    }
}

/// The index that was stored as a scalar.
fn index<T: Number>(stored: T) -> usize {
    stored.widen() as usize
}

fn exchange_rows<T: Number>(matrix: &mut [T], columns: usize, row: usize, later: usize) {
    if row < later {
        let (before, after) = matrix.split_at_mut(later * columns);
        before[row * columns..][..columns].swap_with_slice(&mut after[..columns]);
    }
}
