//! The steady state of a loop with one law: second moments, costs-to-go, and the exact cost.

use super::{
    closed::{Closed, Slope, symmetric},
    jump::Jump,
};
use crate::solve::{evaluation::solve_like, spectral::spectral_radius, sums::Sums};
use nalgebra::{DMatrix, SymmetricEigen};

/// Accuracy of second moments and costs, relative to their norm.
const ACCURACY: f64 = 1e-12;
/// Times that they are corrected, at most.
const REFINEMENTS: usize = 6;
/// Part of the cost by which second moments may be negative through rounding.
const NEGATIVE: f64 = 1e-7;
/// Cycles that a space of the rate takes as one: packets shift through the loop before they are gone.
const MOST_SHIFTS: usize = 8;

/// What a law comes to.
#[derive(Clone)]
pub(super) struct Steady {
    /// `X`, `n x n`.
    pub(super) moments: DMatrix<f64>,
    /// `Y`, `n x n`.
    pub(super) cost_to_go: DMatrix<f64>,
    /// Average cost of a cycle.
    pub(super) cost: f64,
}

impl Jump<'_> {
    /// The steady state with `law`, found from one nearby if there is one; `None` if there is none, as the loop is unstable.
    pub(super) fn steady(&self, law: &DMatrix<f64>, near: Option<&Steady>) -> Option<Steady> {
        let closed = self.closed(law);
        let noise = closed.noise();
        let mean = closed.mean();
        let forward = Sums::decaying(mean.transpose())?;
        let moments = fixed_point(&noise, near.map(|near| &near.moments), &forward, |moments| {
            closed.moments_after(moments)
        })?;
        let (stage, constant) = closed.stage();
        let backward = Sums::decaying(mean)?;
        let cost_to_go = fixed_point(&stage, near.map(|near| &near.cost_to_go), &backward, |cost| {
            closed.cost_before(cost)
        })?;
        if !is_semidefinite(&moments, &cost_to_go) || !is_semidefinite(&cost_to_go, &moments) {
            return None;
        }
        let cost = cost_to_go.component_mul(&noise).sum() + constant;
        (cost >= 0.0).then_some(Steady { moments, cost_to_go, cost })
    }

    /// Derivatives of [`Steady::cost`].
    pub(super) fn slope(&self, law: &DMatrix<f64>, steady: &Steady) -> Slope {
        self.closed(law).slope(&steady.moments, &steady.cost_to_go)
    }

    /// Factor by which second moments change per cycle in the long run.
    pub(super) fn rate(&self, law: &DMatrix<f64>) -> f64 {
        self.closed(law).rate()
    }
}

impl Closed<'_, '_> {
    fn rate(&self) -> f64 {
        let mut start = self.noise();
        let size = start.nrows();
        start += DMatrix::identity(size, size) * (start.trace() / size as f64).max(f64::MIN_POSITIVE);
        let strides = [1, MOST_SHIFTS / 2 + 1, MOST_SHIFTS + 1];
        spectral_radius(start.as_slice(), strides, |from, to| {
            let after = self.moments_after(&DMatrix::from_column_slice(size, size, from));
            to.copy_from_slice(after.as_slice());
        })
    }
}

/// `X = F(X) + C` for a linear `F` that is about `M X M'`; `None` if that is not found.
fn fixed_point(
    constant: &DMatrix<f64>,
    near: Option<&DMatrix<f64>>,
    mean: &Sums,
    after: impl Fn(&DMatrix<f64>) -> DMatrix<f64>,
) -> Option<DMatrix<f64>> {
    let size = constant.nrows();
    let square = |entries: &[f64]| DMatrix::from_column_slice(size, size, entries);
    let mut found = near.map_or_else(|| mean.total(constant.clone()), DMatrix::clone);
    for _ in 0..REFINEMENTS {
        let residual = symmetric(constant + after(&found) - &found);
        let scale = found.norm().max(constant.norm());
        if residual.norm() <= ACCURACY * scale {
            return found.iter().all(|entry| entry.is_finite()).then(|| symmetric(found));
        }
        let correction = solve_like(
            residual.as_slice(),
            scale,
            0.5 * ACCURACY,
            |entries| entries.copy_from_slice(mean.total(square(entries)).as_slice()),
            |entries| entries.copy_from_slice(after(&square(entries)).as_slice()),
        )?;
        found += square(&correction);
    }
    None
}

/// Whether it is one of a loop that is stable: of one that is not, the fixed point is indefinite.
///
/// It is looked at in units in which `other` has a diagonal of ones, so that what counts is what shows in the cost.
fn is_semidefinite(matrix: &DMatrix<f64>, other: &DMatrix<f64>) -> bool {
    let unit = other.diagonal().map(|entry| entry.abs().sqrt());
    let weighed = matrix.map_with_location(|i, k, entry| entry * unit[i] * unit[k]);
    let scale = weighed.trace();
    scale >= 0.0 && SymmetricEigen::new(weighed).eigenvalues.min() >= -NEGATIVE * scale
}
