//! States that a constant input holds: `x = A x + B u`, and which outputs `z = Z x` can be held so.
//!
//! **The set.** All (x, u) with `(A - I) x + B u = 0` are the null space of `[A-I B]`. As (A, B) is stabilisable, its
//! rows are independent, and the null space has nu dimensions: constant inputs hold at most nu outputs independently.
//!
//! **Units.** Ranks must not depend on the units of states, inputs and outputs. So rows and columns of
//!
//! ```text
//! [A-I  B]
//! [ Z   0]
//! ```
//!
//! are scaled until entries that are not zero are close to 1 in the sense of least squares of their logarithms, which
//! no change of units changes, and then rows once more to a largest entry of 1. All decisions are made there.

use super::Plant;
use nalgebra::{Cholesky, DMatrix, DVector};

/// What is smaller than this, in a matrix scaled to entries of 1, is zero.
const RANK: f64 = 1e-9;
/// Part by which an output may miss a point that counts as held.
const MISS: f64 = 1e-9;
/// The same for outputs that are to be 0, as part of the largest one after scaling; and entries of the solution that
/// are this small are rounding.
const ROUNDING: f64 = 1e-12;
/// Rounds of scaling; a few are enough unless the plant is a long chain.
const ROUNDS: usize = 200;

/// The states that constant inputs hold, by the tracked outputs they have.
pub(super) struct Equilibria {
    /// (nx + nu) x nz: state and input for outputs z that can be held, `(x, u) = solution z`, with the least u'Ru.
    /// What of z cannot be held is projected away first.
    solution: DMatrix<f64>,
    states: usize,
    /// nz: factors that scale z.
    scale: DVector<f64>,
    /// nz x any, orthonormal: the scaled z that can be held.
    held: DMatrix<f64>,
}

impl Equilibria {
    /// `z`: nz x nx, no row of zeros. `r`: nu x nu, positive definite.
    pub(super) fn of(plant: &Plant, z: &DMatrix<f64>, r: &DMatrix<f64>) -> Self {
        let (states, inputs, outputs) = (plant.states(), plant.inputs(), z.nrows());
        let mut system = DMatrix::zeros(states + outputs, states + inputs);
        system.view_mut((0, 0), (states, states)).copy_from(&plant.a);
        for state in 0..states {
            system[(state, state)] -= 1.0;
            // A pole at 1 - 1e-12 is one at 1 that was rounded.
            if system[(state, state)].abs() < ROUNDING {
                system[(state, state)] = 0.0;
            }
        }
        system.view_mut((0, states), (states, inputs)).copy_from(&plant.b);
        system.view_mut((states, 0), (outputs, states)).copy_from(z);
        let (rows, columns) = equilibrate(&mut system);
        let scale = rows.rows(states, outputs).into_owned();

        // Scaled (x, u) = resting a for any a, so that scaled z = outputs_of a.
        let resting = Factors::of(&system.rows(0, states).into_owned(), 1.0).kernel;
        let outputs_of = system.rows(states, outputs) * &resting;
        let Factors { range, kernel, inverse } = Factors::of(&outputs_of, 1.0);
        // a = inverse z + kernel b, with the b of least u'Ru = |price (inverse z + kernel b)|^2.
        let root = Cholesky::new(r.clone()).expect("R is positive definite").l();
        let inputs_of = DMatrix::from_diagonal(&columns.rows(states, inputs)) * resting.rows(states, inputs);
        let price = root.transpose() * inputs_of;
        let free = &price * &kernel;
        let chosen = if free.is_empty() {
            inverse
        } else {
            let best = Factors::of(&free, price.amax()).inverse * &price * &inverse;
            inverse - kernel * best
        };
        let mut solution = resting * chosen;
        let negligible = ROUNDING * solution.amax();
        solution.apply(|entry| *entry = if entry.abs() <= negligible { 0.0 } else { *entry });
        let solution = DMatrix::from_diagonal(&columns) * solution * DMatrix::from_diagonal(&scale);
        Equilibria { solution, states, scale, held: range }
    }

    /// nu x nz: `u = input z`.
    pub(super) fn input(&self) -> DMatrix<f64> {
        self.solution.rows(self.states, self.solution.nrows() - self.states).into_owned()
    }

    /// How many tracked outputs constant inputs set independently.
    pub(super) fn dimensions(&self) -> usize {
        self.held.ncols()
    }

    /// Whether a constant input holds the tracked outputs at `value` (nz).
    pub(super) fn hold(&self, value: &DVector<f64>) -> bool {
        let scaled = value.component_mul(&self.scale);
        let miss = self.projected(&scaled) - &scaled;
        let floor = ROUNDING * scaled.amax();
        miss.iter().zip(&scaled).all(|(miss, value)| miss.abs() <= MISS * value.abs() + floor)
    }

    /// The point nearest to `value` (nz) that can be held: least squares after scaling.
    pub(super) fn nearest(&self, value: &DVector<f64>) -> DVector<f64> {
        let mut nearest = self.projected(&value.component_mul(&self.scale));
        let negligible = ROUNDING * nearest.amax();
        nearest.apply(|entry| *entry = if entry.abs() <= negligible { 0.0 } else { *entry });
        nearest.component_div(&self.scale)
    }

    fn projected(&self, scaled: &DVector<f64>) -> DVector<f64> {
        &self.held * self.held.tr_mul(scaled)
    }
}

/// Scales `matrix` as the units would have been chosen to make its entries alike. Returns the factors of rows and columns.
fn equilibrate(matrix: &mut DMatrix<f64>) -> (DVector<f64>, DVector<f64>) {
    let (height, width) = matrix.shape();
    let size = matrix.map(|entry| entry.abs().log2());
    let (mut rows, mut columns) = (DVector::zeros(height), DVector::zeros(width));
    // Minus the mean of the logarithms, of entries that are not zero.
    let correction = |sizes: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = sizes
            .filter(|size| size.is_finite())
            .fold((0.0, 0_usize), |(sum, count), size| (sum + size, count + 1));
        if count == 0 { 0.0 } else { -sum / count as f64 }
    };
    for _ in 0..ROUNDS {
        for i in 0..height {
            rows[i] = correction(&mut (0..width).map(|j| size[(i, j)] + columns[j]));
        }
        for j in 0..width {
            columns[j] = correction(&mut (0..height).map(|i| size[(i, j)] + rows[i]));
        }
    }
    for i in 0..height {
        let largest = (0..width).map(|j| size[(i, j)] + columns[j]).fold(f64::NEG_INFINITY, f64::max);
        rows[i] = if largest.is_finite() { -largest } else { 0.0 };
    }
    // Powers of two: scaling rounds nothing.
    let (rows, columns) = (rows.map(|row| row.round().exp2()), columns.map(|column| column.round().exp2()));
    *matrix = DMatrix::from_fn(height, width, |i, j| matrix[(i, j)] * rows[i] * columns[j]);
    (rows, columns)
}

/// A matrix taken apart by a complete orthogonal decomposition.
struct Factors {
    /// Orthonormal basis of its range.
    range: DMatrix<f64>,
    /// Orthonormal basis of its null space.
    kernel: DMatrix<f64>,
    /// Its pseudo-inverse.
    inverse: DMatrix<f64>,
}

impl Factors {
    /// What is below 1e-9 of `size` counts as zero.
    fn of(matrix: &DMatrix<f64>, size: f64) -> Self {
        let (height, width) = matrix.shape();
        // matrix = Q R with columns of R in another order, and the rows of R from `rank` on are zero.
        let first = matrix.clone().col_piv_qr();
        let mut upper = first.r();
        let most = height.min(width);
        let rank = (0..most).take_while(|&pivot| upper[(pivot, pivot)].abs() > RANK * size).count();
        if rank == 0 {
            return Factors {
                range: DMatrix::zeros(height, 0),
                kernel: DMatrix::identity(width, width),
                inverse: DMatrix::zeros(width, height),
            };
        }
        first.p().inv_permute_columns(&mut upper);
        let range = first.q().columns(0, rank).into_owned();
        // R' = Y T', so that matrix = Q T Y' with T lower triangular.
        let second = upper.rows(0, rank).transpose().qr();
        let mut transposed = DMatrix::identity(width, width);
        second.q_tr_mul(&mut transposed);
        let y = transposed.transpose();
        let core = second.r().transpose().solve_lower_triangular(&range.transpose());
        let inverse = y.columns(0, rank) * core.expect("no pivot is zero");
        Factors { range, kernel: y.columns(rank, width - rank).into_owned(), inverse }
    }
}

#[cfg(test)]
mod tests;
