//! Coordinates in which the plant's states and outputs have no units.
//!
//! First, each state is measured by how far it shows in the outputs, in units of their noise, at once or later: by the
//! square root of its entry on the diagonal of `sum_k (A'/rho)^k C' V^-1 C (A/rho)^k`. Then what goes into each is made as
//! large as what comes out of it ([`crate::balance`]). The second is what eigenvalues need; the first settles the units of
//! parts that drive each other one way only, which the second leaves open.

use crate::balance::{in_units, power_of_two, state_units};
use crate::design::Plant;
use crate::stability::open_loop_modulus;
use nalgebra::DMatrix;

/// `A` (nx x nx) and `C` (ny x nx) in balanced coordinates; the rows of `C` have length 1, but for one that is zero.
pub(super) struct Coordinates {
    pub a: DMatrix<f64>,
    pub c: DMatrix<f64>,
}

impl Coordinates {
    pub(super) fn of(plant: &Plant) -> Self {
        let mut c = plant.c.clone();
        for (mut row, variance) in c.row_iter_mut().zip(plant.measurement_noise.diagonal().iter()) {
            row /= if *variance > 0.0 { variance.sqrt() } else { or_one(row.amax()) };
        }
        let unit = |sight: f64| if sight > 0.0 { power_of_two(sight.recip()) } else { 1.0 };
        let mut units: Vec<f64> = sight(&plant.a, &c).into_iter().map(unit).collect();
        let none = DMatrix::zeros(units.len(), 0);
        let more = state_units(&in_units(&plant.a, &units), &none, &none.transpose());
        units.iter_mut().zip(more).for_each(|(unit, more)| *unit *= more);
        for (mut column, unit) in c.column_iter_mut().zip(&units) {
            column *= *unit;
        }
        for mut row in c.row_iter_mut() {
            // In two steps, as the squares of very large and very small entries are no numbers.
            row /= or_one(row.amax());
            row /= or_one(row.norm());
        }
        Self { a: in_units(&plant.a, &units), c }
    }
}

/// How large each state is in the outputs `c`, over as many steps as there are states.
fn sight(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Vec<f64> {
    let mut sight = vec![0.0_f64; a.nrows()];
    let forgetting = or_one(open_loop_modulus(a)).max(1.0);
    let mut seen = c.clone();
    for _ in 0..a.nrows() {
        for (sum, column) in sight.iter_mut().zip(seen.column_iter()) {
            *sum = column.iter().fold(*sum, |sum, entry| sum.hypot(*entry));
        }
        seen = seen * a / forgetting;
    }
    sight
}

fn or_one(value: f64) -> f64 {
    if value > 0.0 && value.is_finite() { value } else { 1.0 }
}
