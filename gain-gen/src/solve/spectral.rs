//! Spectral radius of a linear map that is only known by its action.
//!
//! Arnoldi's method: the closed loop's second moments can rotate (complex pairs of eigenvalues close in modulus to
//! the largest), which plain power iteration mistakes for no convergence.

use crate::design::modes;
use nalgebra::DMatrix;

/// Largest Krylov space built; the maps here have some thousand unknowns and settle within a hundred.
const LARGEST_SPACE: usize = 320;
/// Steps between looks at the eigenvalues.
const LOOK_EVERY: usize = 4;
/// Relative change between looks that counts as none; it must stay so for [`LOOKS`] looks.
const SETTLED: f64 = 1e-13;
const LOOKS: usize = 3;
/// A new direction shorter than this, relative to the map's image, is rounding: the space is invariant.
const BREAKDOWN: f64 = 1e-14;

/// Spectral radius of `apply` on the space reached from `start`.
///
/// For a map that leaves a cone of costs invariant and a `start` inside the cone, that is the spectral radius.
pub(super) fn spectral_radius(start: &[f64], mut apply: impl FnMut(&[f64], &mut [f64])) -> f64 {
    let size = start.len();
    let most = LARGEST_SPACE.min(size);
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(most + 1);
    let mut projected = DMatrix::<f64>::zeros(most + 1, most);
    let length = norm(start);
    if length == 0.0 {
        return 0.0;
    }
    basis.push(start.iter().map(|value| value / length).collect());
    let mut radius = 0.0;
    let mut settled = 0;
    for column in 0..most {
        let mut image = vec![0.0; size];
        apply(&basis[column], &mut image);
        let reached = norm(&image);
        // Twice is enough: the second pass removes what cancellation left of the first.
        for _ in 0..2 {
            for (row, direction) in basis.iter().enumerate() {
                let along: f64 = direction.iter().zip(&image).map(|(a, b)| a * b).sum();
                projected[(row, column)] += along;
                image.iter_mut().zip(direction).for_each(|(value, part)| *value -= along * part);
            }
        }
        let rest = norm(&image);
        let invariant = rest <= BREAKDOWN * reached;
        if invariant || column + 1 == most || (column + 1) % LOOK_EVERY == 0 {
            // A look at which the eigenvalues do not settle is passed over; the next has one row more.
            if let Some(looked) = modulus(&projected.view((0, 0), (column + 1, column + 1)).into_owned()) {
                settled = if (looked - radius).abs() <= SETTLED * looked { settled + 1 } else { 0 };
                radius = looked;
            }
            if invariant || settled >= LOOKS {
                return radius;
            }
        }
        projected[(column + 1, column)] = rest;
        basis.push(image.into_iter().map(|value| value / rest).collect());
    }
    radius
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// Largest modulus of the eigenvalues of a square matrix; `None` if the iteration for them does not converge.
pub(crate) fn modulus(matrix: &DMatrix<f64>) -> Option<f64> {
    Some(modes::eigenvalues(matrix)?.iter().map(|value| value.norm()).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn radius_of(matrix: &DMatrix<f64>) -> f64 {
        let start = vec![1.0; matrix.ncols()];
        spectral_radius(&start, |from, to| {
            let image = matrix * nalgebra::DVector::from_column_slice(from);
            to.copy_from_slice(image.as_slice());
        })
    }

    #[test]
    fn a_rotating_pair_is_found_by_its_modulus() {
        let (modulus, angle) = (0.97_f64, 1.0_f64);
        let mut matrix = DMatrix::from_diagonal_element(6, 6, 0.5);
        matrix[(0, 0)] = modulus * angle.cos();
        matrix[(1, 1)] = modulus * angle.cos();
        matrix[(0, 1)] = modulus * angle.sin();
        matrix[(1, 0)] = -modulus * angle.sin();
        assert!((radius_of(&matrix) - modulus).abs() < 1e-12);
    }

    #[test]
    fn a_large_map_with_many_close_eigenvalues_is_resolved() {
        let size = 500;
        let matrix =
            DMatrix::from_fn(
                size,
                size,
                |i, j| if i == j { 0.99 * (i + 1) as f64 / size as f64 } else { 0.0 },
            );
        assert!((radius_of(&matrix) - 0.99).abs() < 1e-9);
    }

    #[test]
    fn a_nilpotent_map_has_radius_zero() {
        let matrix = DMatrix::from_fn(4, 4, |i, j| if j == i + 1 { 1.0 } else { 0.0 });
        // Four equal eigenvalues in one block: rounding eps moves them by eps^(1/4).
        assert!(radius_of(&matrix) < 1e-3);
    }
}
