//! The check of (3.36) in floating point, with nothing left to rounding.
//!
//! Every difference is computed by plain dense products, and with it a bound of its error: `k` operations on an entry
//! err by at most `k u / (1 - k u)` times the same expression with absolute values throughout (Higham, Accuracy and
//! Stability of Numerical Algorithms, chapter 3), in any order of summation and with or without fused operations. A
//! symmetric error below `E` entrywise is, for any positive `w`, at most the diagonal matrix of `(E w)_i / w_i`; that
//! is taken off before Cholesky's factorisation, together with what the factorisation itself may err by (Rump,
//! Verification of positive definiteness, BIT 46, 2006). What then factors is positive definite in exact arithmetic.

use super::Rejected;
use crate::solve::{LoopProblem, age_transitions, modes};
use nalgebra::{Cholesky, DMatrix, DVector};

/// Unit roundoff of `f64`.
const UNIT: f64 = 0.5 * f64::EPSILON;
/// The error bounds are themselves computed with rounding, and `k u / (1 - k u)` is a little above `k u`.
const SAFETY: f64 = 2.0;

/// What has to be positive definite, mode by mode, in units in which each `X(j)` has a diagonal near 1.
pub(super) struct Differences {
    modes: Vec<Mode>,
}

struct Mode {
    /// `X(j)`, `n x n`.
    x: DMatrix<f64>,
    /// `sum_i p(j,i) (A(i)+B(i)L(j))^T X(i) (A(i)+B(i)L(j))`, `n x n`.
    expected: DMatrix<f64>,
    /// Diagonal that exceeds the error of `x - expected`, `n`.
    error: DVector<f64>,
}

impl Differences {
    /// Both sides of (3.36) for all modes, from the problem's plant and link, gains `L(j)` and matrices `X(j)`.
    ///
    /// # Errors
    /// Dimensions do not fit, a number is not finite, an `X(j)` is not symmetric or has no positive diagonal.
    pub(super) fn new(
        problem: &LoopProblem,
        gains: &[DMatrix<f64>],
        x: &[DMatrix<f64>],
    ) -> Result<Self, Rejected> {
        let plants = modes(problem);
        let transitions = age_transitions(&problem.link, problem.length);
        let (size, inputs) = plants[0].b.shape();
        let all = |matrices: &[DMatrix<f64>], shape| {
            matrices.len() == plants.len() && matrices.iter().all(|matrix| matrix.shape() == shape)
        };
        if !all(x, (size, size)) || !all(gains, (inputs, size)) {
            return Err(Rejected::Dimensions);
        }
        let is_finite = |matrix: &DMatrix<f64>| matrix.iter().all(|value| value.is_finite());
        let given = [&problem.a, &problem.b];
        if !given.into_iter().chain(gains).chain(x).all(is_finite) {
            return Err(Rejected::NotFinite);
        }
        if let Some(mode) = x.iter().position(|x| *x != x.transpose()) {
            return Err(Rejected::NotSymmetric { mode });
        }
        if let Some(mode) = x.iter().position(|x| x.diagonal().iter().any(|&value| value <= 0.0)) {
            return Err(Rejected::NotPositive { mode });
        }
        // Operations on an entry: two closed loops, two products, weighting and summing, symmetrising and subtracting.
        let operations = 2 * (inputs + 1) + 2 * size + 2 * plants.len() + 4;
        let unit = SAFETY * UNIT * operations as f64;
        let mode = |mode: usize| {
            let mut expected = DMatrix::zeros(size, size);
            // By powers of two, so that scaling is exact.
            let scale = x[mode].diagonal().map(|value| (-0.5 * value.log2()).round().exp2());
            let mut error = x[mode].abs() * &scale;
            for (next, plant) in plants.iter().enumerate() {
                let probability = transitions[(mode, next)];
                if probability == 0.0 {
                    continue;
                }
                let closed = &plant.a + &plant.b * &gains[mode];
                expected += closed.transpose() * (&x[next] * &closed) * probability;
                let absolute = plant.a.abs() + plant.b.abs() * gains[mode].abs();
                error += absolute.transpose() * (x[next].abs() * (absolute * &scale)) * probability;
            }
            let expected = (&expected + expected.transpose()) * 0.5;
            let in_units = |matrix: &DMatrix<f64>| {
                DMatrix::from_fn(size, size, |row, column| matrix[(row, column)] * scale[row] * scale[column])
            };
            Mode {
                x: in_units(&x[mode]),
                expected: in_units(&expected),
                // E w / w in units w: (E w)_i w_i.
                error: error.component_mul(&scale) * unit,
            }
        };
        Ok(Self { modes: (0..plants.len()).map(mode).collect() })
    }

    /// Whether `X(mode)` is positive definite for certain.
    pub(super) fn is_positive(&self, mode: usize) -> bool {
        is_positive_definite(self.modes[mode].x.clone())
    }

    /// Whether `factor X(mode)` exceeds the right side of (3.36) for certain, for a `factor` of at most 1.
    pub(super) fn is_decreasing(&self, mode: usize, factor: f64) -> bool {
        let Mode { x, expected, error } = &self.modes[mode];
        let mut difference = x * factor - expected;
        for (at, error) in error.iter().enumerate() {
            difference[(at, at)] -= error;
        }
        is_positive_definite(difference)
    }
}

/// Whether a symmetric matrix is positive definite for certain.
fn is_positive_definite(mut matrix: DMatrix<f64>) -> bool {
    let error = SAFETY * UNIT * (matrix.nrows() + 2) as f64 * matrix.diagonal().abs().sum();
    for at in 0..matrix.nrows() {
        matrix[(at, at)] -= error;
    }
    Cholesky::new(matrix).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_short_of_positive_by_less_than_rounding_are_refused() {
        let size = 30;
        let ones = DMatrix::from_element(size, size, 1.0);
        let shifted = |shift: f64| &ones + DMatrix::<f64>::identity(size, size) * shift;
        assert!(is_positive_definite(shifted(1e-9)));
        for not in [0.0, 1e-15, -1e-15, -1e-9, f64::NAN] {
            assert!(!is_positive_definite(shifted(not)), "{not}");
        }
    }
}
