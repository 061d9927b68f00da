//! Symmetric weights and covariances: shape, symmetry and definiteness, checked independently of units.

use super::DesignError;
use super::document::Field;
use nalgebra::{DMatrix, SymmetricEigen};

/// What is asked of a symmetric matrix.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Definiteness {
    Positive,
    Semidefinite,
}

/// Difference between mirrored entries that counts as rounding, in the units that the diagonal gives them.
const ASYMMETRY: f64 = 1e-9;
/// How far below zero an eigenvalue of the matrix scaled to unit diagonal may be by rounding.
const NEGATIVE: f64 = 1e-9;
/// Smallest eigenvalue of the matrix scaled to unit diagonal that counts as positive.
const POSITIVE: f64 = 1e-12;

/// Reads a symmetric `size` x `size` matrix and makes it exactly symmetric.
///
/// `against` says what the size must fit (`the plant has 3 states`), `advice` ends the message if the matrix is not as definite as asked.
/// Errors: another shape, not symmetric, not positive (semi)definite.
pub(super) fn symmetric(
    field: &Field<'_>,
    size: usize,
    against: &str,
    definiteness: Definiteness,
    advice: &str,
) -> Result<DMatrix<f64>, DesignError> {
    let kind = match definiteness {
        Definiteness::Positive => "positive definite",
        Definiteness::Semidefinite => "positive semidefinite",
    };
    let wanted = format!("give a {size}x{size} symmetric {kind} matrix");
    let matrix = field.matrix()?;
    let (rows, columns) = matrix.shape();
    if (rows, columns) != (size, size) {
        return Err(field.reject_with(format!("found a {rows}x{columns} matrix, but {against}"), wanted));
    }
    let unit = |i: usize| matrix[(i, i)].abs().sqrt();
    for (i, j) in (0..size).flat_map(|i| (0..i).map(move |j| (i, j))) {
        if (matrix[(i, j)] - matrix[(j, i)]).abs() > ASYMMETRY * (unit(i) * unit(j)) {
            let found = format!(
                "found {} in row {}, column {}, but {} in the mirrored place",
                matrix[(j, i)],
                j + 1,
                i + 1,
                matrix[(i, j)]
            );
            return Err(field.reject_with(found, wanted));
        }
    }
    let matrix = &matrix * 0.5 + matrix.transpose() * 0.5;
    let smallest = smallest_scaled_eigenvalue(&matrix);
    let definite = match definiteness {
        Definiteness::Positive => smallest > POSITIVE,
        Definiteness::Semidefinite => smallest >= -NEGATIVE,
    };
    if definite {
        return Ok(matrix);
    }
    let eigenvalue = SymmetricEigen::new(matrix).eigenvalues.min();
    let found = format!("found a matrix that is not {kind} (smallest eigenvalue {eigenvalue:.3e})");
    let separator = if advice.is_empty() { "" } else { "; " };
    Err(field.reject_with(found, format!("{wanted}{separator}{advice}")))
}

/// Smallest eigenvalue after scaling to unit diagonal, so that the units of the entries do not matter.
/// -1 if single entries already show an indefinite matrix.
fn smallest_scaled_eigenvalue(matrix: &DMatrix<f64>) -> f64 {
    let size = matrix.nrows();
    for i in 0..size {
        let diagonal = matrix[(i, i)];
        if diagonal < 0.0 || (diagonal == 0.0 && matrix.row(i).amax() > 0.0) {
            return -1.0;
        }
    }
    // A zero row stays zero: it contributes the eigenvalue 0.
    let scale = |i: usize| if matrix[(i, i)] > 0.0 { matrix[(i, i)].sqrt().recip() } else { 0.0 };
    let scaled = DMatrix::from_fn(size, size, |i, j| matrix[(i, j)] * scale(i) * scale(j));
    // A correlation beyond 1 is indefinite too, and would let the products above overflow.
    if scaled.amax() > 1.0 + NEGATIVE {
        return -1.0;
    }
    SymmetricEigen::new(scaled).eigenvalues.min()
}
