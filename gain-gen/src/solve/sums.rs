//! Costs of a loop that is a single matrix: `X = F' X F + C`, by doubling the number of terms of its series.

use nalgebra::DMatrix;

/// Radius above which plain iteration takes too long for a loop to be worth its powers.
const SLOW: f64 = 0.99;
/// Squarings after which a sum of powers below 1 has converged: 2^64 terms.
const SQUARINGS: usize = 64;

/// The powers `F, F^2, F^4, ..` until nothing is left of them, `nx x nx` each.
pub(super) struct Sums {
    powers: Vec<DMatrix<f64>>,
}

impl Sums {
    /// Of a loop with this spectral radius; `None` for one that forgets quickly.
    pub(super) fn of(closed: &DMatrix<f64>, radius: f64) -> Option<Self> {
        if radius <= SLOW {
            return None;
        }
        let mut powers = vec![closed.clone()];
        while powers.len() < SQUARINGS {
            let last = &powers[powers.len() - 1];
            let next = last * last;
            if !next.iter().all(|entry| entry.is_finite()) || next.amax() <= f64::EPSILON * closed.amax() {
                break;
            }
            powers.push(next);
        }
        Some(Self { powers })
    }

    /// `X` for a symmetric `C`.
    pub(super) fn total(&self, stage: DMatrix<f64>) -> DMatrix<f64> {
        self.powers.iter().fold(stage, |sum, power| {
            let more = power.tr_mul(&(&sum * power));
            sum + more
        })
    }

    /// The same for a whole cost-to-go, which begins with `C` by rows; the rest stays as it is.
    pub(super) fn of_value(&self, states: usize, value: &[f64]) -> Vec<f64> {
        let mut result = value.to_vec();
        let stage = &mut result[..states * states];
        let total = self.total(DMatrix::from_row_slice(states, states, stage));
        let symmetric = (&total + total.transpose()) * 0.5;
        stage.copy_from_slice(symmetric.as_slice());
        result
    }
}
