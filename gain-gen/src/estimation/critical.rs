//! The critical probability: how often measurements must come for the modified Riccati equation to have a solution.
//!
//! `q_crit` is the least `q` above which gains `K` exist such that `X -> (1-q) A X A' + q (A + K C) X (A + K C)'` shrinks
//! (Theorem 3.3 a), Sinopoli et al. 2004). Modes that do not grow play no part. In general
//!
//! ```text
//! 1 - 1 / max |lambda|^2  <=  q_crit  <=  1 - 1 / prod |lambda|^2         over the eigenvalues with |lambda| > 1
//! ```
//!
//! with equality on the right where the outputs see one combination of the growing modes (Schenato et al. 2007), and on the
//! left where they see as many as there are growing modes: then `K` can make `A + K C` zero.
//!
//! **In between**, far from its start the Riccati iteration is the same without noise: `f(X) = A X A' - q A X C' (C X C')^-1
//! C X A'`, which is monotone, concave and homogeneous of degree 1. With noise in proportion to `tr X`, too little to matter,
//! it stays so and has one definite `X` with `f(X) = b X`; `b`, its growth, falls with `q`, and `q_crit` is where it is 1. Since the
//! derivative of `f` by `X` is the step with the gains of `X` held fixed, Newton's method for `f(X) = X`, `tr X = 1` in `X` and
//! `q` together is policy iteration: linear equations for the upper triangle of `X` at each step, few of them.

use super::coordinates::Coordinates;
use super::spectrum::growing_part;
use crate::design::{Plant, modes};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Outputs that see less of the growing modes than this part of what they see of all are rounding.
const UNSEEN: f64 = 1e-10;
/// Width of the interval between the limits below which the upper one is taken.
const WIDTH: f64 = 1e-9;
/// Noise, as a part of the trace of the covariance: less and less of it, each from the solution before. Where slow modes are
/// seen well, their covariance is of this size, and rounding ends the row.
const NOISES: [f64; 6] = [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14];
/// Steps of the Riccati iteration ahead of Newton's method, and after a step of it that leads astray.
const WARM: usize = 8;
/// Change of `q` at which Newton's method ends.
const SETTLED: f64 = 1e-9;
/// Steps of Newton's method.
const MOST: usize = 30;
/// Growing modes beyond which the upper limit is taken: equations for their covariance fill the memory.
const MANY: usize = 40;

/// `q_crit` for a plant whose outputs see every mode that does not decay. 0 if no mode grows.
///
/// By formula where there is one; otherwise to 1e-6, or 1e-4 from above where modes coincide (the growth of a Jordan block
/// answers to the cube root of the noise). With very many growing modes and several outputs an upper bound.
pub fn critical_probability(plant: &Plant) -> f64 {
    let Some((lower, upper, count)) = limits(&plant.a) else { return 1.0 };
    if count == 0 {
        return 0.0;
    }
    let balanced = Coordinates::of(plant);
    let Some(growing) = growing_part(&balanced.a, count) else { return upper };
    let seen = combinations(&(balanced.c * &growing));
    if seen.nrows() >= count {
        lower
    } else if seen.nrows() <= 1 || upper - lower <= WIDTH || count > MANY {
        upper
    } else {
        let mut iteration =
            Iteration { a: growing.tr_mul(&(balanced.a * &growing)), c: seen, noise: NOISES[0] };
        iteration.critical(upper).map_or(upper, |found| found.clamp(lower, upper))
    }
}

/// Both limits and the number of growing modes; `None` if the eigenvalues cannot be computed.
fn limits(a: &DMatrix<f64>) -> Option<(f64, f64, usize)> {
    let growing = modes::modes(a)?.into_iter().filter(|mode| mode.growth == modes::Growth::Grows);
    let moduli: Vec<f64> = growing.map(|mode| mode.modulus()).collect();
    let largest = moduli.iter().fold(1.0_f64, |largest, modulus| largest.max(*modulus));
    let product: f64 = moduli.iter().product();
    Some((1.0 - largest.powi(-2), 1.0 - product.powi(-2), moduli.len()))
}

/// Orthonormal rows that span those of `c`.
fn combinations(c: &DMatrix<f64>) -> DMatrix<f64> {
    let mut rows = c.clone();
    for mut row in rows.row_iter_mut() {
        let length = row.norm();
        row /= if length > UNSEEN { length } else { f64::INFINITY };
    }
    let parts = rows.svd(false, true);
    let kept: Vec<usize> =
        (0..parts.singular_values.len()).filter(|&at| parts.singular_values[at] > UNSEEN).collect();
    parts.v_t.expect("asked for").select_rows(&kept)
}

/// The homogeneous iteration for growing modes alone: `a`, n x n, and `c`, fewer orthonormal rows.
struct Iteration {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    noise: f64,
}

/// What one measurement does to a covariance.
struct Correction {
    /// `K`, n x ny.
    gains: DMatrix<f64>,
    /// `A X C' (C X C' + V)^-1 C X A'`: by how much it makes the next covariance smaller.
    effect: DMatrix<f64>,
}

impl Iteration {
    fn correction(&self, x: &DMatrix<f64>) -> Option<Correction> {
        let outputs = self.c.nrows();
        let seen = &self.c * x;
        let innovation =
            &seen * self.c.transpose() + DMatrix::identity(outputs, outputs) * (self.noise * x.trace());
        let cross = seen * self.a.transpose();
        let gains = Cholesky::new(innovation)?.solve(&cross);
        let effect = cross.tr_mul(&gains);
        Some(Correction { gains: -gains.transpose(), effect: (&effect + effect.transpose()) * 0.5 })
    }

    /// Some steps of the Riccati iteration, each averaged with where it starts: where modes rotate, it would for ever go around its
    /// fixed point.
    fn warmed(&self, mut x: DMatrix<f64>, q: f64) -> Option<DMatrix<f64>> {
        let unit = DMatrix::identity(x.nrows(), x.nrows());
        for _ in 0..WARM {
            let ahead = &self.a * &x * self.a.transpose();
            let next = ahead + &unit * (self.noise * x.trace()) - self.correction(&x)?.effect * q;
            let sum = &next / next.trace() + &x / x.trace();
            x = (&sum + sum.transpose()) / (2.0 * sum.trace());
        }
        Some(x)
    }

    /// The `q` for which the iteration with hardly any noise neither grows nor shrinks, from `q` above it; `None` if Newton's
    /// method does not settle with any noise.
    fn critical(&mut self, mut q: f64) -> Option<f64> {
        let size = self.a.nrows();
        let mut x = self.warmed(DMatrix::identity(size, size), q)?;
        let mut found = None;
        for noise in NOISES {
            self.noise = noise;
            // Much noise may leave no solution at any `q`, and very little none beyond rounding.
            let Some(settled) = self.settled(x.clone(), q) else { continue };
            (x, q) = settled;
            found = Some(q);
        }
        found
    }

    /// The covariance that neither grows nor shrinks, and the `q` for it.
    fn settled(&self, mut x: DMatrix<f64>, mut q: f64) -> Option<(DMatrix<f64>, f64)> {
        let size = self.a.nrows();
        for _ in 0..MOST {
            let correction = self.correction(&x)?;
            let equations = self.step_less_identity(&correction.gains, q);
            let direction = unpacked(&equations.lu().solve(&packed(&correction.effect))?, size);
            let change = direction.trace().recip();
            let next = direction * change;
            // Only a definite solution belongs to the growth.
            if q + change > 0.0 && q + change < 1.0 && Cholesky::new(next.clone()).is_some() {
                q += change;
                x = next;
                if change.abs() < SETTLED {
                    return Some((x, q));
                }
            } else {
                x = self.warmed(x, q)?;
            }
        }
        None
    }

    /// `X -> (1-q) A X A' + q (A + K C) X (A + K C)' + noise - X` for the upper triangle of a symmetric `X`.
    fn step_less_identity(&self, gains: &DMatrix<f64>, q: f64) -> DMatrix<f64> {
        let size = self.a.nrows();
        let corrected = &self.a + gains * &self.c;
        let noise = (DMatrix::identity(size, size) + gains * gains.transpose() * q) * self.noise;
        let places: Vec<(usize, usize)> = (0..size).flat_map(|j| (0..=j).map(move |i| (i, j))).collect();
        let product = |factor: &DMatrix<f64>, (row, column): (usize, usize), (i, j): (usize, usize)| {
            let once = factor[(row, i)] * factor[(column, j)];
            if i == j { once } else { once + factor[(row, j)] * factor[(column, i)] }
        };
        DMatrix::from_fn(places.len(), places.len(), |to, from| {
            let (to, from) = (places[to], places[from]);
            let moved = product(&self.a, to, from) * (1.0 - q) + product(&corrected, to, from) * q;
            let drive = if from.0 == from.1 { noise[to] } else { 0.0 };
            moved + drive - if to == from { 1.0 } else { 0.0 }
        })
    }
}

/// The upper triangle, column by column.
fn packed(x: &DMatrix<f64>) -> DVector<f64> {
    DVector::from_iterator(
        x.nrows() * (x.nrows() + 1) / 2,
        (0..x.ncols()).flat_map(|j| (0..=j).map(move |i| x[(i, j)])),
    )
}

fn unpacked(triangle: &DVector<f64>, size: usize) -> DMatrix<f64> {
    DMatrix::from_fn(size, size, |i, j| triangle[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn iterated(a: &DMatrix<f64>, c: &DMatrix<f64>) -> f64 {
        let mut iteration = Iteration { a: a.clone(), c: combinations(c), noise: NOISES[0] };
        iteration.critical(limits(a).unwrap().1).expect("settles")
    }

    #[test]
    fn newtons_method_meets_the_formula_for_one_output() {
        for (rows, outputs) in [
            (vec![1.5, 0.0, 0.0, 1.2], vec![1.0, 1.0]),
            (vec![0.9, -0.8, 0.8, 0.9], vec![1.0, 0.0]),
            (vec![0.0, 1.2, -1.2, 0.0], vec![1.0, 0.0]),
            (vec![1.2, 1.0, 0.0, 1.1], vec![1.0, 0.0]),
            (vec![1.1, 1.0, 0.0, 1.1], vec![1.0, 0.0]),
            (vec![1.4, 0.3, 0.0, 0.0, 1.3, 0.2, 0.0, 0.0, 1.2], vec![1.0, 0.5, 0.5]),
        ] {
            let size = outputs.len();
            let a = DMatrix::from_row_slice(size, size, &rows);
            let found = iterated(&a, &DMatrix::from_row_slice(1, size, &outputs));
            let expected = 1.0 - a.determinant().powi(-2);
            assert!((found - expected).abs() < 1e-7, "{found} instead of {expected} for {a}");
        }
    }

    #[test]
    fn outputs_in_other_combinations_and_units_make_no_difference() {
        let a = DMatrix::from_row_slice(3, 3, &[1.4, 0.3, 0.0, 0.0, 1.3, 0.2, 0.0, 0.0, 1.2]);
        let c = DMatrix::from_row_slice(2, 3, &[1.0, 0.0, 0.5, 0.0, 0.3, 1.0]);
        let other = DMatrix::from_row_slice(3, 2, &[1e6, 2e6, 0.3, -0.1, 2e-5, 1e-5]) * &c;
        assert!((iterated(&a, &c) - iterated(&a, &other)).abs() < 1e-9);
    }
}
