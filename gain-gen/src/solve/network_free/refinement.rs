//! Newton's method for the Riccati equation, with residuals of twice the precision: the gains to the last digit of `f64`,
//! and how far they were off.
//!
//! A solution's own digits do not suffice where the gains are small differences of large costs. So the solution is kept
//! as [`Extended`], and so is what is left when it is put into its equation; the correction for that,
//! `D = F' D F + rest` with `F = A + B K`, needs but a few digits, and `f64` computes it.

use crate::extended::{
    Extended, cholesky, product, rounded, solve_lower, symmetric, transposed_product, widened,
};
use nalgebra::DMatrix;

/// Corrections allowed.
const MOST: usize = 12;
/// Squarings after which a sum of powers below 1 has converged: 2^64 terms.
const SQUARINGS: usize = 64;
/// Change of the gains, relative to the largest of their row, that leaves every digit of `f64` as it is.
pub(super) const SETTLED: f64 = 1e-16;
/// Corrections that may leave the gains as far off as they were.
const SETBACKS: usize = 3;

/// A solution of the Riccati equation, and what follows from it.
pub(super) struct Refined {
    /// `P`, `nx x nx`.
    pub(super) cost: DMatrix<Extended>,
    /// `K = -(R + B' P B)^-1 B' P A`, `nu x nx`.
    pub(super) gain: DMatrix<Extended>,
    /// `A + B K`, `nx x nx`.
    pub(super) closed: DMatrix<Extended>,
    /// What the last correction moved in the gains, relative to the largest of each row.
    pub(super) error: f64,
}

/// The plant and its weights in twice the precision.
pub(super) struct Equation {
    a: DMatrix<Extended>,
    b: DMatrix<Extended>,
    q: DMatrix<Extended>,
    r: DMatrix<Extended>,
}

impl Equation {
    pub(super) fn new(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>) -> Self {
        Self { a: widened(a), b: widened(b), q: widened(q), r: widened(r) }
    }

    /// `B R^-1 B'`, `nx x nx`; `None` if `R` is not positive definite.
    pub(super) fn spread(&self) -> Option<DMatrix<Extended>> {
        let half = solve_lower(&cholesky(&self.r)?, &self.b.transpose());
        Some(transposed_product(&half, &half))
    }

    /// `A` and `Q`.
    pub(super) fn transition_and_weight(&self) -> (&DMatrix<Extended>, &DMatrix<Extended>) {
        (&self.a, &self.q)
    }

    /// The gain that `cost` asks for, the loop it closes, and what is left of `cost` in its equation.
    fn put_in(
        &self,
        cost: &DMatrix<Extended>,
    ) -> Option<(DMatrix<Extended>, DMatrix<Extended>, DMatrix<f64>)> {
        let ahead = product(cost, &self.a);
        let coupling = transposed_product(&self.b, &ahead);
        let price = sum(&self.r, &symmetric(&transposed_product(&self.b, &product(cost, &self.b))));
        let gain = solve_definite(&price, &coupling)?.map(|entry| -entry);
        let closed = sum(&self.a, &product(&self.b, &gain));
        let after = sum(&transposed_product(&self.a, &ahead), &transposed_product(&coupling, &gain));
        let rest = sum(&sum(&self.q, &symmetric(&after)), &cost.map(|entry| -entry));
        Some((gain, closed, rounded(&rest)))
    }

    /// The solution nearest to `cost`, corrected until a correction moves the gains by no more than `settled`, relative to the
    /// largest of each row; `None` if `cost` gives no gains that shrink all costs.
    pub(super) fn refine(&self, cost: DMatrix<Extended>, settled: f64) -> Option<Refined> {
        let mut cost = cost;
        let (mut gain, mut closed, mut rest) = self.put_in(&cost)?;
        let mut error = f64::INFINITY;
        let mut setbacks = 0;
        for _ in 0..MOST {
            cost = sum(&cost, &widened(&correction(&rounded(&closed), rest)?));
            let next = self.put_in(&cost)?;
            let moved = greatest_change(&next.0, &gain);
            (gain, closed, rest) = next;
            setbacks += usize::from(moved > 0.5 * error);
            error = error.min(moved);
            if moved <= settled || setbacks == SETBACKS {
                break;
            }
        }
        // The gains themselves are rounded in the end.
        error.is_finite().then_some(Refined { cost, gain, closed, error: error.max(f64::EPSILON) })
    }
}

/// `D = F' D F + rest` by doubling the number of terms; `None` if the sum has no end.
fn correction(closed: &DMatrix<f64>, rest: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let mut power = closed.clone();
    let mut total = rest;
    for _ in 0..SQUARINGS {
        let more = power.tr_mul(&(&total * &power));
        if !more.iter().all(|entry| entry.is_finite()) {
            return None;
        }
        let settled = more.amax() <= f64::EPSILON * total.amax();
        total += more;
        if settled {
            return Some((&total + total.transpose()) * 0.5);
        }
        power = &power * &power;
    }
    None
}

/// Largest difference, relative to the largest gain of each row.
fn greatest_change(new: &DMatrix<Extended>, old: &DMatrix<Extended>) -> f64 {
    let rows = new.row_iter().zip(old.row_iter());
    let of_row = rows.map(|(new, old)| {
        let largest = new.iter().map(|entry| entry.magnitude()).fold(0.0, f64::max);
        let change =
            new.iter().zip(old.iter()).map(|(new, old)| (*new - *old).magnitude()).fold(0.0, f64::max);
        if change == 0.0 { 0.0 } else { change / largest }
    });
    of_row.fold(0.0, f64::max)
}

/// `matrix^-1 right` for a positive definite matrix, scaled to unit diagonal first.
fn solve_definite(matrix: &DMatrix<Extended>, right: &DMatrix<Extended>) -> Option<DMatrix<Extended>> {
    let size = matrix.nrows();
    let scale: Vec<Extended> = (0..size).map(|i| Extended::ONE / matrix[(i, i)].sqrt()).collect();
    let scaled = DMatrix::from_fn(size, size, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let factor = cholesky(&scaled)?;
    let right = DMatrix::from_fn(size, right.ncols(), |i, j| right[(i, j)] * scale[i]);
    let half = solve_lower(&factor, &right);
    // The transposed factor, turned upside down, is lower again.
    let turned = |matrix: &DMatrix<Extended>| {
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(matrix.nrows() - 1 - i, j)])
    };
    let upper = DMatrix::from_fn(size, size, |i, j| factor[(size - 1 - j, size - 1 - i)]);
    let solution = turned(&solve_lower(&upper, &turned(&half)));
    Some(DMatrix::from_fn(size, solution.ncols(), |i, j| solution[(i, j)] * scale[i]))
}

fn sum(a: &DMatrix<Extended>, b: &DMatrix<Extended>) -> DMatrix<Extended> {
    a.zip_map(b, |a, b| a + b)
}
