//! Units in which a plant's entries are of like size: they come from the data, so that no answer depends on the units in
//! which a plant was written down.
//!
//! A state measured in units of `d` has its column of `A` multiplied and its row divided by `d`. Osborne's method (J. ACM
//! 7, 1960) makes what goes into each state as large as what comes out of it, one state after the other; inputs count as
//! going in, outputs and weights as coming out. The result is a property of the plant alone: the sum of all entries is
//! convex in the logarithms of the units and has one minimum. Units are powers of two, so that changing to them and back
//! is exact.

use nalgebra::DMatrix;

/// Rounds over all states, at most.
const SWEEPS: usize = 60;
/// Change of a unit below which a round has changed nothing.
const SETTLED: f64 = 1.1;
/// Rounds in which the units of states and those of free inputs follow each other.
const ROUNDS: usize = 8;

/// The unit of each state, `nx`, for transitions `a` (`nx x nx`), what drives the states, `inflow` (`nx` rows), and what
/// is seen of them, `outflow` (`nx` columns), both in units that are settled.
pub(crate) fn state_units(a: &DMatrix<f64>, inflow: &DMatrix<f64>, outflow: &DMatrix<f64>) -> Vec<f64> {
    let mut units = vec![1.0; a.nrows()];
    settle(a, inflow, outflow, &mut units);
    units.iter().map(|&unit| power_of_two(unit)).collect()
}

/// The same for inputs whose units are open: each column of `b` counts with the size that makes it 1.
pub(crate) fn state_units_with_free_inputs(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Vec<f64> {
    let none = DMatrix::zeros(0, a.nrows());
    let mut units = vec![1.0; a.nrows()];
    for _ in 0..ROUNDS {
        let mut inflow = b.clone();
        for mut column in inflow.column_iter_mut() {
            let size: f64 = column.iter().zip(&units).map(|(entry, unit)| entry.abs() / unit).sum();
            if size > 0.0 {
                column /= size;
            }
        }
        settle(a, &inflow, &none, &mut units);
    }
    units.iter().map(|&unit| power_of_two(unit)).collect()
}

/// `diag(units)^-1 matrix diag(units)`.
pub(crate) fn in_units(matrix: &DMatrix<f64>, units: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * (units[j] / units[i]))
}

/// The power of two nearest to a positive number, by ratio.
pub(crate) fn power_of_two(value: f64) -> f64 {
    value.log2().round().clamp(-900.0, 900.0).exp2()
}

fn settle(a: &DMatrix<f64>, inflow: &DMatrix<f64>, outflow: &DMatrix<f64>, units: &mut [f64]) {
    for _ in 0..SWEEPS {
        let mut moved = 1.0_f64;
        for state in 0..units.len() {
            let others = (0..units.len()).filter(|&other| other != state);
            let (mut enters, mut leaves) = (0.0, 0.0);
            for other in others {
                enters += a[(state, other)].abs() * units[other];
                leaves += a[(other, state)].abs() / units[other];
            }
            enters += inflow.row(state).iter().map(|entry| entry.abs()).sum::<f64>();
            leaves += outflow.column(state).iter().map(|entry| entry.abs()).sum::<f64>();
            // Where nothing goes in, or nothing comes out, the one that there is becomes 1.
            let unit = match (enters > 0.0, leaves > 0.0) {
                (true, true) => (enters / leaves).sqrt(),
                (true, false) => enters,
                (false, true) => leaves.recip(),
                (false, false) => continue,
            };
            let change = unit / units[state];
            moved = moved.max(change.max(change.recip()));
            units[state] = unit;
        }
        if moved < SETTLED {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_follow_those_of_the_data() {
        let a = DMatrix::from_row_slice(3, 3, &[1.0, 1e-3, 0.0, 0.0, 1.0, 2.0, 0.3, 0.0, 0.9]);
        let b = DMatrix::from_row_slice(3, 1, &[0.0, 0.0, 0.5]);
        let plain = state_units_with_free_inputs(&a, &b);
        let scale = [1e-6, 1e3, 1e9];
        let changed = DMatrix::from_fn(3, 3, |i, j| a[(i, j)] * scale[i] / scale[j]);
        let changed_b = DMatrix::from_fn(3, 1, |i, _| b[i] * scale[i] * 1e-7);
        let followed = state_units_with_free_inputs(&changed, &changed_b);
        for state in 0..3 {
            let ratio = followed[state] / (plain[state] * scale[state]) * (plain[0] * scale[0]) / followed[0];
            assert!((0.2..5.0).contains(&ratio), "{state}: {ratio}");
        }
    }

    #[test]
    fn a_weak_coupling_becomes_as_large_as_the_others() {
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 5e-10, 0.0, 0.9]);
        let units = state_units_with_free_inputs(&a, &DMatrix::from_row_slice(2, 1, &[0.0, 0.1]));
        let balanced = in_units(&a, &units);
        assert!((0.3..3.0).contains(&balanced[(0, 1)]), "{balanced}");
    }
}
