//! The critical probability: how often measurements must come for the modified Riccati equation to have a solution.
//!
//! `q_crit` is the least `q` above which gains `K` exist such that `X -> (1-q) A X A' + q (A + K C) X (A + K C)'` shrinks
//! (Theorem 3.3 a), Sinopoli et al. 2004). In general
//!
//! ```text
//! 1 - 1 / max |lambda|^2  <=  q_crit  <=  1 - 1 / prod |lambda|^2         over the eigenvalues with |lambda| > 1
//! ```
//!
//! with equality on the right for a single output (Schenato et al. 2007), and so for a single unstable mode both. The rest
//! is found by bisection.
//!
//! **What decides.** Far from its start the Riccati iteration is the same without noise: `f(X) = A X A' - q A X C' (C X C')^-1
//! C X A'`, which is monotone, concave and homogeneous of degree 1, and has one rate of growth. With noise in
//! proportion to `tr X`, too little to matter, it stays so and every `X` on the way is definite. Then `f(X) <= b X` with
//! `b < 1` shows that the gains of `X` shrink it: bounded; `f(X) >= a X` with `a >= 1` shows that it grows. The iteration
//! brings both numbers together. No answer depends on how long a growing covariance takes to look large.

use super::coordinates::Coordinates;
use crate::design::{Plant, modes};
use nalgebra::{Cholesky, DMatrix, SymmetricEigen};

/// Moduli up to this above 1 do not count as unstable.
const MARGIN: f64 = 1e-9;
/// Width of the interval at which bisection ends.
const WIDTH: f64 = 1e-7;
/// Noise, as a part of the trace of the covariance.
const NOISE: f64 = 1e-10;
/// Difference of the two rates at which a growth too close to 1 counts as such.
const RESOLVED: f64 = 1e-9;
/// Steps between looks at the rates.
const STRIDE: usize = 8;
/// Steps allowed.
const MOST: usize = 20_000;

/// `q_crit` for a plant whose outputs see every mode that does not decay. 0 if no mode grows.
///
/// By formula where there is one; otherwise by bisection, from above: to within 1e-6, or 1e-3 where modes coincide (the
/// growth of a Jordan block answers to the cube root of the noise).
pub fn critical_probability(plant: &Plant) -> f64 {
    let (lower, upper) = limits(&plant.a);
    if plant.c.nrows() == 1 || upper - lower <= WIDTH { upper } else { bisect(plant, lower, upper) }
}

/// The same by bisection wherever there is an unstable mode, without the formulas: to check one against the other.
pub fn critical_probability_by_bisection(plant: &Plant) -> f64 {
    if limits(&plant.a).1 == 0.0 { 0.0 } else { bisect(plant, 0.0, 1.0) }
}

/// The two limits for any outputs; infinitely fast growth if the eigenvalues cannot be computed.
fn limits(a: &DMatrix<f64>) -> (f64, f64) {
    let Some(eigenvalues) = modes::eigenvalues(a) else { return (1.0, 1.0) };
    let unstable = eigenvalues.iter().map(|lambda| lambda.norm()).filter(|modulus| *modulus > 1.0 + MARGIN);
    let (largest, product) =
        unstable.fold((1.0_f64, 1.0), |(largest, product), next| (largest.max(next), product * next));
    (1.0 - largest.powi(-2), 1.0 - f64::powi(product, -2))
}

fn bisect(plant: &Plant, mut lower: f64, mut upper: f64) -> f64 {
    let growth = Growth(Coordinates::of(plant));
    while upper - lower > WIDTH {
        let middle = 0.5 * (lower + upper);
        if growth.is_bounded(middle) {
            upper = middle;
        } else {
            lower = middle;
        }
    }
    upper
}

/// The homogeneous iteration.
struct Growth(Coordinates);

impl Growth {
    /// `f(X)` with noise.
    fn step(&self, x: &DMatrix<f64>, q: f64) -> Option<DMatrix<f64>> {
        let noise = NOISE * x.trace();
        let ahead = &self.0.a * x;
        let seen = &self.0.c * x;
        let innovation =
            &seen * self.0.c.transpose() + DMatrix::identity(self.0.c.nrows(), self.0.c.nrows()) * noise;
        let cross = seen * self.0.a.transpose();
        let gain = Cholesky::new(innovation)?.solve(&cross);
        let next = ahead * self.0.a.transpose() - cross.tr_mul(&gain) * q;
        Some((&next + next.transpose()) * 0.5 + DMatrix::identity(x.nrows(), x.nrows()) * noise)
    }

    /// Whether the covariance stays bounded; false also where that cannot be told.
    fn is_bounded(&self, q: f64) -> bool {
        let mut x = DMatrix::identity(self.0.a.nrows(), self.0.a.nrows());
        for count in 1..=MOST {
            let Some(next) = self.step(&x, q) else { return false };
            if count % STRIDE == 0 {
                let Some((least, greatest)) = rates(&x, &next) else { return false };
                if greatest < 1.0 {
                    return true;
                }
                if least >= 1.0 || greatest - least < RESOLVED {
                    return false;
                }
            }
            // The mean of both: where modes rotate, the iteration alone would for ever go around its fixed point.
            let sum = &next / next.trace() + &x / x.trace();
            x = &sum / sum.trace();
        }
        false
    }
}

/// Least and greatest factor by which `next` exceeds the positive definite `x`, over all directions.
fn rates(x: &DMatrix<f64>, next: &DMatrix<f64>) -> Option<(f64, f64)> {
    let root = Cholesky::new(x.clone())?.l();
    let half = root.solve_lower_triangular(next)?;
    let ratio = root.solve_lower_triangular(&half.transpose())?;
    let factors = SymmetricEigen::new((&ratio + ratio.transpose()) * 0.5).eigenvalues;
    Some((factors.min(), factors.max()))
}
