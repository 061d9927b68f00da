//! Exact discretisation of a continuous plant. Reading and checking the plant is in [`crate::design`].
//!
//! Every entry of the result is as good as its own last digit: a chain of integrators at 0.1 ms has entries of 1e-18 beside
//! others of 1, and where entries of 1e10 cancel, `f64` would keep six digits. So scaling and squaring runs on
//! Extended numbers, in units in which the entries of the plant are of like size (`balance`), and only what
//! comes out is rounded to `f64`. That rounding, half a unit in the last place of each entry, remains as the uncertainty of
//! A and B, as the rounding of `a` and `b` remains where they were written down: where the last digit of an entry moves
//! the gains, nothing that follows can be better.

use crate::balance::{in_units, power_of_two, state_units_with_free_inputs};
use crate::extended::{Extended, product};
use nalgebra::DMatrix;

/// Largest entry of `a` times the sample time that is accepted, in balanced units.
const LARGEST: f64 = 1e15;
/// Norm to which the exponent is halved before its series is summed: more halvings would save fewer terms than they cost.
const SERIES_NORM: f64 = 0.0625;
/// A term below this part of an entry no longer counts there.
const NEGLIGIBLE: f64 = f64::EPSILON * f64::EPSILON / 4.0;

/// (A, B) of `x+ = A x + B u` for `dx/dt = a x + b u` with u held over each step (zero-order hold).
///
/// `a`: nx x nx, `b`: nx x nu, `sample_time` in the time unit of `a`. Both results come out of one matrix
/// exponential, `exp([a b; 0 0] sample_time) = [A B; 0 I]`, which also covers a singular `a`. They do not depend on the units
/// of states and inputs, and each entry errs by no more than its last place.
/// `None`: the result exceeds the range of f64, or `a` times `sample_time` has an entry beyond 1e15, of which
/// no digit would be right.
///
/// # Panics
/// If `a` is not square or `b` has another number of rows.
pub fn zero_order_hold(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    sample_time: f64,
) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let (nx, nu) = b.shape();
    assert_eq!(a.shape(), (nx, nx), "a must be square with as many rows as b");
    let states = state_units_with_free_inputs(a, b);
    let inputs: Vec<f64> = (0..nu).map(|input| input_unit(b, input, &states)).collect();
    let balanced = in_units(a, &states);
    let norm = column_norm(&balanced) * sample_time;
    // The number of halvings follows from the size; beyond all sense it would not end.
    let makes_sense = |entry: &f64| (entry * sample_time).abs() <= LARGEST;
    if !balanced.iter().all(makes_sense) {
        return None;
    }
    let halvings = (norm / SERIES_NORM).log2().ceil().max(0.0) as i32;
    let step = Extended::from(sample_time) * Extended::from(2.0_f64.powi(-halvings));
    let rates = DMatrix::from_fn(nx, nx + nu, |i, j| {
        Extended::from(if j < nx { balanced[(i, j)] } else { b[(i, j - nx)] / states[i] / inputs[j - nx] })
            * step
    });
    let mut transition = series(&rates);
    for _ in 0..halvings {
        transition = doubled(&transition);
    }
    let unit = |i: usize, j: usize| states[i] * if j < nx { states[j].recip() } else { inputs[j - nx] };
    let rounded = DMatrix::from_fn(nx, nx + nu, |i, j| transition[(i, j)].rounded() * unit(i, j));
    let in_range = rounded.iter().all(|entry| entry.is_finite());
    in_range.then(|| (rounded.columns(0, nx).into(), rounded.columns(nx, nu).into()))
}

/// The size of a column of `b` in units of the states, as a power of two.
fn input_unit(b: &DMatrix<f64>, input: usize, states: &[f64]) -> f64 {
    let size = b.column(input).iter().zip(states).map(|(entry, unit)| entry.abs() / unit).fold(0.0, f64::max);
    if size > 0.0 { power_of_two(size) } else { 1.0 }
}

fn column_norm(matrix: &DMatrix<f64>) -> f64 {
    matrix.column_iter().map(|column| column.iter().map(|entry| entry.abs()).sum()).fold(0.0, f64::max)
}

/// `[A B]`, `nx x (nx + nu)`, over one step for `rates = [a b]` times the step, by the exponential's series.
///
/// It ends where no entry changes any more. An entry that belongs to a path of k states first appears in term k, and the
/// beginning of that path in each term before, so that no entry is left out.
fn series(rates: &DMatrix<Extended>) -> DMatrix<Extended> {
    let nx = rates.nrows();
    let mut sum = rates.clone();
    let mut term = rates.clone();
    // Each term is less than half the one before as soon as all paths have begun.
    for order in 2..nx + 64 {
        let divisor = Extended::from(order as f64);
        term = product(&term.columns(0, nx).into(), rates).map(|entry| entry / divisor);
        let mut counts = false;
        for (entry, part) in sum.iter_mut().zip(term.iter()) {
            counts |= part.magnitude() > NEGLIGIBLE * entry.magnitude();
            *entry += *part;
        }
        if !counts {
            break;
        }
    }
    for state in 0..nx {
        sum[(state, state)] += Extended::ONE;
    }
    sum
}

/// `[A B]` over two steps from one: `[A^2, A B + B]`.
fn doubled(transition: &DMatrix<Extended>) -> DMatrix<Extended> {
    let nx = transition.nrows();
    let mut twice = product(&transition.columns(0, nx).into(), transition);
    let driven = nx..transition.ncols();
    for (entry, once) in
        twice.columns_range_mut(driven.clone()).iter_mut().zip(transition.columns_range(driven).iter())
    {
        *entry += *once;
    }
    twice
}

#[cfg(test)]
mod tests {
    use super::*;

    fn difference(x: &DMatrix<f64>, y: &DMatrix<f64>) -> f64 {
        (x - y).amax()
    }

    #[test]
    fn double_integrator_has_its_textbook_form() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
        for t in [1e-4, 0.1, 1.0, 25.0] {
            let (ad, bd) = zero_order_hold(&a, &b, t).unwrap();
            assert!(
                difference(&ad, &DMatrix::from_row_slice(2, 2, &[1.0, t, 0.0, 1.0])) < 1e-14 * t.max(1.0)
            );
            assert!(
                difference(&bd, &DMatrix::from_row_slice(2, 1, &[t * t / 2.0, t])) < 1e-14 * (t * t).max(1.0)
            );
        }
    }

    #[test]
    fn a_lag_approaches_its_input_exponentially() {
        for (pole, t) in [(-3.0, 0.5), (-4000.0, 0.01), (0.7, 2.0)] {
            let (ad, bd) =
                zero_order_hold(&DMatrix::from_element(1, 1, pole), &DMatrix::from_element(1, 1, 2.0), t)
                    .unwrap();
            let decay = (pole * t).exp();
            assert!((ad[0] - decay).abs() < 1e-14 * decay.max(1.0), "{pole}: {}", ad[0] - decay);
            assert!((bd[0] - 2.0 * (decay - 1.0) / pole).abs() < 1e-14 * decay.max(1.0));
        }
    }

    #[test]
    fn an_oscillator_turns_by_its_angle() {
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 7.0, -7.0, 0.0]);
        let (ad, _) = zero_order_hold(&a, &DMatrix::zeros(2, 1), 0.3).unwrap();
        let (sin, cos) = 2.1_f64.sin_cos();
        assert!(difference(&ad, &DMatrix::from_row_slice(2, 2, &[cos, sin, -sin, cos])) < 1e-14);
    }

    #[test]
    fn the_unit_of_the_input_does_not_matter() {
        let a = DMatrix::from_row_slice(2, 2, &[-0.3, 1.0, 0.2, -2.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.5, 1.0]);
        let (expected_a, expected_b) = zero_order_hold(&a, &b, 0.1).unwrap();
        for unit in [1e-200, 1e200] {
            let (ad, bd) = zero_order_hold(&a, &(&b * unit), 0.1).unwrap();
            assert_eq!(ad, expected_a);
            assert!(difference(&(bd / unit), &expected_b) < 1e-15);
        }
    }

    #[test]
    fn growth_out_of_range_is_refused() {
        for pole in [800.0, 1e60, 1e300, -1e60] {
            let a = DMatrix::from_element(1, 1, pole);
            assert_eq!(zero_order_hold(&a, &DMatrix::from_element(1, 1, 1.0), 1.0), None, "{pole}");
        }
    }

    #[test]
    fn two_steps_are_one_of_double_length() {
        for scale in [1e-3, 0.1, 1.0, 10.0] {
            let a = DMatrix::from_fn(4, 4, |i, j| ((3 * i + 5 * j) % 7) as f64 / 7.0 - 0.5) * scale;
            let b = DMatrix::from_fn(4, 2, |i, j| 1.0 - (i * j) as f64 / 5.0);
            let (a1, b1) = zero_order_hold(&a, &b, 0.5).unwrap();
            let (a2, b2) = zero_order_hold(&a, &b, 1.0).unwrap();
            assert!(difference(&a2, &(&a1 * &a1)) < 1e-12 * a2.amax().max(1.0), "{scale}");
            assert!(difference(&b2, &(&a1 * &b1 + &b1)) < 1e-12 * b2.amax().max(1.0), "{scale}");
        }
    }
}
