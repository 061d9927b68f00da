//! A loop that is a single matrix, which one over a network is often like: its radius, and its costs
//! `X = F' X F + C` by doubling the number of terms of their series.

use super::radius::radius;
use crate::extended::widened;
use nalgebra::DMatrix;

/// Radius above which plain iteration takes too long for a loop to be worth its powers.
const SLOW: f64 = 0.99;
/// Squarings after which a sum of powers below 1 has converged: 2^64 terms.
const SQUARINGS: usize = 64;

/// `x+ = F x`.
pub(super) struct StateLoop {
    closed: DMatrix<f64>,
    radius: f64,
}

impl StateLoop {
    /// Of a loop with this matrix, `nx x nx`, and spectral radius.
    pub(super) fn new(closed: DMatrix<f64>, radius: f64) -> Self {
        Self { closed, radius }
    }

    /// The same; the radius is found.
    pub(super) fn of(closed: DMatrix<f64>) -> Self {
        let radius = radius(&widened(&closed));
        Self::new(closed, radius)
    }

    /// Its costs; `None` for a loop that forgets quickly, or never.
    pub(super) fn sums(&self) -> Option<Sums> {
        (self.radius > SLOW && self.radius < 1.0).then(|| Sums::of(self.closed.clone()))
    }

    /// Its costs where each cycle counts `1 / growth` of the one before; `None` where they have no end.
    pub(super) fn discounted(&self, growth: f64) -> Option<Sums> {
        (self.radius.powi(2) < growth).then(|| Sums::of(&self.closed / growth.sqrt()))
    }
}

/// The powers `F, F^2, F^4, ..` until nothing is left of them, `nx x nx` each.
pub(super) struct Sums {
    powers: Vec<DMatrix<f64>>,
}

impl Sums {
    /// Of a loop `x+ = F x` that may grow: `None` if it does.
    pub(super) fn decaying(closed: DMatrix<f64>) -> Option<Self> {
        let sums = Self::of(closed);
        let last = sums.powers.last()?;
        (sums.powers.len() < SQUARINGS && last.norm() < 1.0).then_some(sums)
    }

    fn of(closed: DMatrix<f64>) -> Self {
        let size = closed.amax();
        let mut powers = vec![closed];
        while powers.len() < SQUARINGS {
            let last = &powers[powers.len() - 1];
            let next = last * last;
            if !next.iter().all(|entry| entry.is_finite()) || next.amax() <= f64::EPSILON * size {
                break;
            }
            powers.push(next);
        }
        Self { powers }
    }

    /// `X` for a symmetric `C`.
    pub(super) fn total(&self, stage: DMatrix<f64>) -> DMatrix<f64> {
        self.powers.iter().fold(stage, |sum, power| {
            let more = power.tr_mul(&(&sum * power));
            sum + more
        })
    }

    /// Makes of the `C` that a whole cost-to-go begins with, by rows, its `X`; the rest stays as it is.
    pub(super) fn add_to(&self, states: usize, value: &mut [f64]) {
        let stage = &mut value[..states * states];
        let total = self.total(DMatrix::from_row_slice(states, states, stage));
        let symmetric = (&total + total.transpose()) * 0.5;
        stage.copy_from_slice(symmetric.as_slice());
    }
}
