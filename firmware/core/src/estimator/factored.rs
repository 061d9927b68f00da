//! A covariance as `U D U^T`: positive semidefinite whatever rounding does to the numbers in it.
//!
//! Sums of squares only: a weight of `D` is never the difference of two numbers, so none can become negative, and what is
//! known of one direction is not drowned by how little is known of another one. In `f32` that tells apart variances of a
//! ratio of `2^46` where the matrix itself ends at `2^23`. Bierman, Factorization Methods for Discrete Sequential
//! Estimation, 1977; Thornton, Triangular Covariance Factorizations for Kalman Filtering, 1976.

use crate::Scalar;
use nalgebra::SMatrix;

/// A block for each place in `0..NX`, upwards or downwards. Of small dimensions the places are constants, and so are the
/// bounds of all loops within: the compiler leaves none.
macro_rules! places {
    (up $dimension:ident, $place:ident => $block:block) => {
        places!(@each $dimension, $place => $block, 0, 1, 2, 3, 4, 5; 0..$dimension)
    };
    (down $dimension:ident, $place:ident => $block:block) => {
        places!(@each $dimension, $place => $block, 5, 4, 3, 2, 1, 0; (0..$dimension).rev())
    };
    (@each $dimension:ident, $place:ident => $block:block, $($constant:literal),*; $all:expr) => {
        if $dimension > 6 {
            for $place in $all $block
        } else {
            $(if $constant < $dimension {
                let $place = $constant;
                $block
            })*
        }
    };
}

/// A symmetric positive semidefinite matrix `U D U^T`, `NX x NX`: `U` upper triangular with a diagonal of ones, `D`
/// diagonal and not negative.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Factored<T, const NX: usize> {
    /// Row by row: `D` on the diagonal, `U` above it, zeros below.
    rows: [[T; NX]; NX],
}

impl<T: Scalar, const NX: usize> Factored<T, NX> {
    /// Of what is certain.
    pub(super) const EMPTY: Self = Self { rows: [[T::ZERO; NX]; NX] };

    /// Of independent variances.
    pub(super) fn diagonal(variances: &[T; NX]) -> Self {
        let mut rows = [[T::zero(); NX]; NX];
        for (place, variance) in variances.iter().enumerate() {
            rows[place][place] = *variance;
        }
        Self { rows }
    }

    /// All numbers in it.
    pub(super) fn numbers(&self) -> &[T] {
        self.rows.as_flattened()
    }

    /// Of a symmetric positive semidefinite matrix, singular or not. What is negative by rounding, or by mistake, is taken
    /// for zero.
    pub(super) fn of(matrix: &SMatrix<T, NX, NX>) -> Self {
        let mut rows = [[T::zero(); NX]; NX];
        for row in 0..NX {
            for column in row..NX {
                rows[row][column] = matrix[(row, column)];
            }
        }
        // What is left of a pivot by rounding alone is at most about this part of it.
        let noise = T::EPSILON * T::nearest(NX as f64);
        for pivot in (0..NX).rev() {
            let weight = rows[pivot][pivot];
            // A pivot that is not a number fails, too.
            let counts = weight > noise * matrix[(pivot, pivot)];
            let inverse = if counts { T::one() / weight } else { T::zero() };
            rows[pivot][pivot] = if counts { weight } else { T::zero() };
            for row in 0..pivot {
                let ratio = rows[row][pivot] * inverse;
                for above in 0..=row {
                    let covariance = rows[above][pivot];
                    rows[above][row] -= ratio * covariance;
                }
            }
            for row in rows.iter_mut().take(pivot) {
                row[pivot] *= inverse;
            }
        }
        Self { rows }
    }

    /// The matrix itself; symmetric to the bit.
    pub(super) fn matrix(&self) -> SMatrix<T, NX, NX> {
        let entry = |row: usize, column: usize| {
            (row.max(column)..NX).fold(T::zero(), |sum, place| {
                let [left, right] = [row, column].map(|at| self.unit(at, place));
                sum + left * right * self.rows[place][place]
            })
        };
        SMatrix::from_fn(|row, column| if row <= column { entry(row, column) } else { entry(column, row) })
    }

    /// An entry of `U` on or above its diagonal.
    fn unit(&self, row: usize, column: usize) -> T {
        if row == column { T::one() } else { self.rows[row][column] }
    }

    /// The variance of `row x`: `row U D U^T row^T`.
    pub(super) fn variance(&self, row: &[T; NX]) -> T {
        let seen = self.seen_by(row);
        (0..NX).fold(T::zero(), |sum, place| sum + seen[place] * seen[place] * self.rows[place][place])
    }

    /// `U^T row^T`.
    fn seen_by(&self, row: &[T; NX]) -> [T; NX] {
        let mut seen = *row;
        for place in 0..NX {
            for above in 0..place {
                seen[place] += self.rows[above][place] * row[above];
            }
        }
        seen
    }

    /// One cycle ahead: `A P A^T + W`. Thornton's modified weighted Gram-Schmidt method on the rows of `[A U, U_W]`.
    #[inline]
    pub(super) fn predicted(&self, a: &SMatrix<T, NX, NX>, noise: &Self) -> Self {
        let mut moved = [[T::zero(); NX]; NX];
        places!(up NX, column => {
            for (row, moved) in moved.iter_mut().enumerate() {
                let mut sum = a[(row, column)];
                for place in 0..column {
                    sum += a[(row, place)] * self.rows[place][column];
                }
                moved[column] = sum;
            }
        });
        Self::sum(moved, &core::array::from_fn(|place| self.rows[place][place]), noise, None)
    }

    /// `(1 - share) P + share Q`, for a share within 0..=1.
    pub(super) fn mixed(&self, other: &Self, share: T) -> Self {
        let mut own = self.rows;
        let weights = core::array::from_fn(|place| self.rows[place][place] * (T::one() - share));
        for (place, row) in own.iter_mut().enumerate() {
            row[place] = T::one();
        }
        Self::sum(own, &weights, other, Some(share))
    }

    /// `F diag(weights) F^T + share Q`, all of `Q` without a share: modified weighted Gram-Schmidt on the rows of
    /// `[F, U_Q]`, from the last one up.
    #[inline(always)]
    fn sum(mut full: [[T; NX]; NX], weights: &[T; NX], other: &Self, share: Option<T>) -> Self {
        let mut unit = other.rows;
        let mut unit_weights = [T::zero(); NX];
        for (place, row) in unit.iter_mut().enumerate() {
            unit_weights[place] = share.map_or(row[place], |share| row[place] * share);
            row[place] = T::one();
        }
        let mut rows = [[T::zero(); NX]; NX];
        places!(down NX, last => {
            let (own, unit_own) = (full[last], unit[last]);
            let mut weight = T::zero();
            let (mut weighed, mut unit_weighed) = (own, unit_own);
            for place in 0..NX {
                weighed[place] *= weights[place];
                weight += weighed[place] * own[place];
            }
            for place in last..NX {
                unit_weighed[place] *= unit_weights[place];
                weight += unit_weighed[place] * unit_own[place];
            }
            rows[last][last] = weight;
            let inverse = T::one() / weight;
            // Where nothing of this row is uncertain, nothing of others goes with it.
            if inverse.is_finite() {
                for row in 0..last {
                    let mut product = T::zero();
                    for place in 0..NX {
                        product += full[row][place] * weighed[place];
                    }
                    for place in last..NX {
                        product += unit[row][place] * unit_weighed[place];
                    }
                    let ratio = product * inverse;
                    rows[row][last] = ratio;
                    for place in 0..NX {
                        full[row][place] -= ratio * own[place];
                    }
                    for place in last..NX {
                        unit[row][place] -= ratio * unit_own[place];
                    }
                }
            }
        });
        Self { rows }
    }

    /// Adds `weight vector vector^T`, for a weight that is not negative: Agee and Turner's rank-one update.
    pub(super) fn add(&mut self, weight: T, vector: [T; NX]) {
        let (mut weight, mut vector) = (weight, vector);
        for last in (0..NX).rev() {
            let (own, before) = (vector[last], self.rows[last][last]);
            let weighed = weight * own;
            let sum = before + weighed * own;
            let inverse = T::one() / sum;
            if !inverse.is_finite() {
                continue;
            }
            self.rows[last][last] = sum;
            let ratio = weighed * inverse;
            weight *= before * inverse;
            for row in 0..last {
                vector[row] -= own * self.rows[row][last];
                self.rows[row][last] += ratio * vector[row];
            }
        }
    }

    /// Takes in a measurement of `row x` with the variance `noise`: Bierman's update.
    ///
    /// Returns the filter gain, `NX`, and the innovation's variance; `None` of a measurement that is certain beforehand and
    /// tells nothing.
    #[inline]
    pub(super) fn observe(&mut self, row: &[T; NX], noise: T) -> Option<([T; NX], T)> {
        let rows = &mut self.rows;
        let mut gain = [T::zero(); NX];
        let mut variance = noise;
        let mut inverse = if noise > T::zero() { T::one() / noise } else { T::zero() };
        places!(up NX, place => {
            let mut seen = row[place];
            for above in 0..place {
                seen += rows[above][place] * row[above];
            }
            let weighed = seen * rows[place][place];
            let before = variance;
            variance += seen * weighed;
            let ratio = -(seen * inverse);
            for above in 0..place {
                let unit = rows[above][place];
                rows[above][place] = unit + gain[above] * ratio;
                gain[above] += unit * weighed;
            }
            gain[place] = weighed;
            if variance > T::zero() {
                inverse = T::one() / variance;
                rows[place][place] *= before * inverse;
            }
        });
        (variance > T::zero()).then(|| (gain.map(|entry| entry * inverse), variance))
    }

    /// `times P`, for a number that is not negative.
    pub(super) fn scale(&mut self, times: T) {
        for (place, row) in self.rows.iter_mut().enumerate() {
            row[place] *= times;
        }
    }

    /// Weights of `D` and columns of `U`: the matrix is the sum of `weight column column^T`.
    pub(super) fn directions(&self) -> impl Iterator<Item = (T, [T; NX])> + '_ {
        (0..NX).map(|place| {
            let column = |row| if row <= place { self.unit(row, place) } else { T::zero() };
            (self.rows[place][place], core::array::from_fn(column))
        })
    }

    /// Whether every number in it is one.
    pub(super) fn is_finite(&self) -> bool {
        // Nothing times zero is anything but zero, unless it is infinite or no number.
        self.rows.iter().flatten().fold(T::zero(), |sum, value| sum + *value * T::zero()) == T::zero()
    }
}
