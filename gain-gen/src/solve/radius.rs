//! Spectral radius of a matrix, by squaring it over and over in twice the precision.
//!
//! `|M^(2^k)|^(1 / 2^k)` tends to the radius whatever the eigenvalues: rotating pairs, equal ones in a block, nilpotent
//! parts that a computation of eigenvalues spreads over a disk. A delay line of a hundred cycles has radius 0 here.

use crate::extended::{Extended, product, rounded};
use nalgebra::DMatrix;

/// Squarings: `2^60` in the exponent leave nothing of what is not exponential growth.
const SQUARINGS: usize = 60;
/// Squarings in twice the precision of matrices above [`SMALL`]: an error in what they leave counts `2^-12`.
const FIRST: usize = 12;
/// Largest matrix that is squared in twice the precision throughout.
const SMALL: usize = 40;

/// Spectral radius of a square matrix; infinite if it is not finite.
pub(super) fn radius(matrix: &DMatrix<Extended>) -> f64 {
    let wide = if matrix.nrows() <= SMALL { SQUARINGS } else { FIRST };
    let mut growth = Growth { logarithm: 0.0, weight: 1.0 };
    let mut power = matrix.clone();
    for _ in 0..wide {
        let size = power.iter().map(|entry| entry.magnitude()).fold(0.0, f64::max);
        let Some(scale) = growth.takes(size) else { return if size == 0.0 { 0.0 } else { f64::INFINITY } };
        let unit = Extended::from(scale);
        power.apply(|entry| *entry *= unit);
        power = product(&power, &power);
    }
    squared(growth, rounded(&power), SQUARINGS - wide)
}

/// The same to the digits that squaring in `f64` leaves: what decays fast, and what is only to be judged.
pub(crate) fn rough_radius(matrix: &DMatrix<f64>) -> f64 {
    squared(Growth { logarithm: 0.0, weight: 1.0 }, matrix.clone(), SQUARINGS)
}

/// The radius from the growth of the powers up to this one, and of so many more.
fn squared(mut growth: Growth, mut power: DMatrix<f64>, times: usize) -> f64 {
    for _ in 0..times {
        let size = power.amax();
        let Some(scale) = growth.takes(size) else { return if size == 0.0 { 0.0 } else { f64::INFINITY } };
        power *= scale;
        power = &power * &power;
    }
    growth.logarithm.exp()
}

/// `log |M^(2^k)| / 2^k`, summed up.
struct Growth {
    logarithm: f64,
    weight: f64,
}

impl Growth {
    /// Takes the size of the next power, and says what to multiply it by: a power of two, so that nothing is rounded.
    fn takes(&mut self, size: f64) -> Option<f64> {
        if size == 0.0 || !size.is_finite() {
            return None;
        }
        let exponent = size.log2().round();
        self.logarithm += exponent * std::f64::consts::LN_2 * self.weight;
        self.weight *= 0.5;
        Some((-exponent).exp2())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extended::widened;

    fn radius_of(matrix: &DMatrix<f64>) -> f64 {
        radius(&widened(matrix))
    }

    #[test]
    fn a_delay_line_has_radius_zero() {
        let shift = DMatrix::from_fn(100, 100, |i, j| if j == i + 1 { 1.0 } else { 0.0 });
        assert_eq!(radius_of(&shift), 0.0);
    }

    #[test]
    fn an_eigenvalue_in_a_block_is_found_to_the_last_digits() {
        for size in [2, 4, 6] {
            let block = DMatrix::from_fn(size, size, |i, j| match j as isize - i as isize {
                0 => 0.999_999,
                1 => 1.0,
                _ => 0.0,
            });
            // Similar, and dense.
            let mix =
                DMatrix::from_fn(size, size, |i, j| if i == j { 1.0 } else { 0.3 / (1.0 + (i + j) as f64) });
            let inverse = mix.clone().try_inverse().expect("not singular");
            assert!((radius_of(&block) - 0.999_999).abs() < 1e-13, "{size}");
            // The similar one is rounded, which moves such an eigenvalue by a root of the precision.
            let moved = 4.0 * f64::EPSILON.powf(1.0 / size as f64);
            assert!((radius_of(&(&mix * &block * &inverse)) - 0.999_999).abs() < moved, "{size}");
        }
    }

    #[test]
    fn a_rotating_pair_has_its_modulus() {
        let (modulus, angle) = (0.999_99_f64, 0.7_f64);
        let turn =
            DMatrix::from_row_slice(2, 2, &[angle.cos(), angle.sin(), -angle.sin(), angle.cos()]) * modulus;
        assert!((radius_of(&turn) - modulus).abs() < 1e-13);
    }
}
