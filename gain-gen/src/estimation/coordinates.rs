//! Coordinates in which the plant's states and outputs have no units.
//!
//! First, each state is measured by how far it shows in the outputs, in units of their noise, at once or later: by the
//! square root of its entry on the diagonal of `sum_k (A'/rho)^k C' V^-1 C (A/rho)^k`. Then each is scaled until what it
//! drives is about as large as what drives it (Parlett and Reinsch 1969). The second is what eigenvalues need; the first
//! settles the units of parts that drive each other one way only, which the second leaves open.
//! All factors of states are powers of 2: no digit is lost.

use crate::design::Plant;
use crate::stability::open_loop_modulus;
use nalgebra::DMatrix;

/// A state is scaled anew where that shrinks its row and column together at least to this part.
const WORTHWHILE: f64 = 0.95;
/// Rounds over all states.
const ROUNDS: usize = 100;

/// `A` (nx x nx) and `C` (ny x nx) in balanced coordinates; the rows of `C` have length 1, but for one that is zero.
pub(super) struct Coordinates {
    pub a: DMatrix<f64>,
    pub c: DMatrix<f64>,
}

impl Coordinates {
    pub(super) fn of(plant: &Plant) -> Self {
        let mut balanced = Self { a: plant.a.clone(), c: plant.c.clone() };
        for (mut row, variance) in balanced.c.row_iter_mut().zip(plant.measurement_noise.diagonal().iter()) {
            row /= if *variance > 0.0 { variance.sqrt() } else { largest_or_one(row.amax()) };
        }
        for (state, sight) in balanced.sight().iter().enumerate() {
            if *sight > 0.0 {
                balanced.scale_state(state, power_of_two(1.0 / sight));
            }
        }
        for _ in 0..ROUNDS {
            if (0..plant.a.nrows()).filter(|&state| balanced.balance_state(state)).count() == 0 {
                break;
            }
        }
        for mut row in balanced.c.row_iter_mut() {
            // In two steps, as the squares of very large and very small entries are no numbers.
            row /= largest_or_one(row.amax());
            row /= largest_or_one(row.norm());
        }
        balanced
    }

    /// How large each state is in the outputs, over as many steps as there are states.
    fn sight(&self) -> Vec<f64> {
        let mut sight = vec![0.0_f64; self.a.nrows()];
        let forgetting = largest_or_one(open_loop_modulus(&self.a)).max(1.0);
        let mut seen = self.c.clone();
        for _ in 0..self.a.nrows() {
            for (sum, column) in sight.iter_mut().zip(seen.column_iter()) {
                *sum = column.iter().fold(*sum, |sum, entry| sum.hypot(*entry));
            }
            seen = seen * &self.a / forgetting;
        }
        sight
    }

    /// Scales one state to a row and a column of about the same size; whether that changed anything.
    fn balance_state(&mut self, state: usize) -> bool {
        let others = || (0..self.a.nrows()).filter(|&other| other != state);
        let driven = others().map(|other| self.a[(other, state)].abs()).fold(0.0, f64::max);
        let driving = others().map(|other| self.a[(state, other)].abs()).fold(0.0, f64::max);
        if driven == 0.0 || driving == 0.0 {
            return false;
        }
        let factor = power_of_two((driving / driven).sqrt());
        if driven * factor + driving / factor >= WORTHWHILE * (driven + driving) {
            return false;
        }
        self.scale_state(state, factor);
        true
    }

    fn scale_state(&mut self, state: usize, factor: f64) {
        self.a.column_mut(state).scale_mut(factor);
        self.a.row_mut(state).unscale_mut(factor);
        self.c.column_mut(state).scale_mut(factor);
    }
}

fn power_of_two(value: f64) -> f64 {
    value.log2().round().exp2()
}

fn largest_or_one(value: f64) -> f64 {
    if value > 0.0 && value.is_finite() { value } else { 1.0 }
}
