//! Unstable modes of a discrete plant, and whether inputs reach and outputs see them (Popov-Belevitch-Hautus).

use nalgebra::{Complex, DMatrix, Schur};

/// Modes slower than this margin count as unstable: they have to be controlled and observed.
const MARGIN: f64 = 1e-9;
/// Singular values below this part of the largest one count as zero.
const RANK: f64 = 1e-9;
/// Sweeps of the QR iteration before another start is tried.
const SWEEPS: usize = 10_000;

/// All eigenvalues of the square matrix `a`; `None` if the iteration for them does not converge.
pub(crate) fn eigenvalues(a: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    // Scaled to entries of at most 1: neither overflow nor underflow on the way.
    let scale = if a.amax() > 0.0 { a.amax() } else { 1.0 };
    let of = |a: DMatrix<f64>| {
        let found =
            Schur::try_new(a / scale, f64::EPSILON, SWEEPS)?.complex_eigenvalues() * Complex::from(scale);
        found.iter().all(|lambda| lambda.re.is_finite() && lambda.im.is_finite()).then_some(found)
    };
    // The shifted QR iteration can stand still on orthogonal matrices such as a cyclic shift; a reflection
    // keeps the eigenvalues and breaks the pattern.
    let found = of(a.clone()).or_else(|| {
        let normal = DMatrix::from_fn(a.nrows(), 1, |i, _| 1.0 / (i as f64 + 1.3));
        let strength = 2.0 / normal.norm_squared();
        let reflection = DMatrix::identity(a.nrows(), a.nrows()) - &normal * normal.transpose() * strength;
        of(&reflection * a * &reflection)
    })?;
    Some(found.iter().copied().collect())
}

/// The eigenvalues that do not decay: magnitude at least 1, up to rounding. `None` as [`eigenvalues`].
pub(crate) fn unstable_eigenvalues(a: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    Some(eigenvalues(a)?.into_iter().filter(|lambda| lambda.norm() >= 1.0 - MARGIN).collect())
}

/// The first of the eigenvalues `unstable` of `a` (nx x nx) whose mode no column of `b` (nx x any) reaches.
/// `None`: (a, b) is stabilisable. With `a` and `c` transposed it answers detectability of (a, c).
pub(crate) fn unreached(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    unstable: &[Complex<f64>],
) -> Option<Complex<f64>> {
    let size = a.nrows();
    let width = size + b.ncols();
    let scale = a.amax();
    unstable.iter().copied().find(|&lambda| {
        let pencil = DMatrix::from_fn(size, width, |i, j| {
            if j < size {
                let shift = if i == j { lambda / scale } else { Complex::new(0.0, 0.0) };
                shift - Complex::from(a[(i, j)] / scale)
            } else {
                // Columns of equal size: the unit of an input must not decide the rank.
                let length = b.column(j - size).amax();
                Complex::from(if length > 0.0 { b[(i, j - size)] / length } else { 0.0 })
            }
        });
        let singular = pencil.singular_values();
        singular.len() < size || singular.min() <= RANK * singular.max()
    })
}

/// `1.5`, or `1.02 ± 0.3i` for the pair of `lambda` and its conjugate.
pub(crate) fn spoken(lambda: Complex<f64>) -> String {
    let rounded = |part: f64| (part * 1e6).round() / 1e6;
    let (re, im) = (rounded(lambda.re), rounded(lambda.im.abs()));
    if im == 0.0 { format!("{re}") } else { format!("{re} ± {im}i") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lost(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Option<Complex<f64>> {
        unreached(a, b, &unstable_eigenvalues(a).unwrap())
    }

    fn matrix<const R: usize, const C: usize>(rows: [[f64; C]; R]) -> DMatrix<f64> {
        DMatrix::from_fn(R, C, |i, j| rows[i][j])
    }

    #[test]
    fn double_integrator_is_stabilisable_and_detectable_from_position_only() {
        let a = matrix([[1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(lost(&a, &matrix([[0.0], [1.0]])), None);
        assert!(lost(&a, &matrix([[1.0], [0.0]])).is_some());
        assert_eq!(lost(&a.transpose(), &matrix([[1.0], [0.0]])), None);
        assert!(lost(&a.transpose(), &matrix([[0.0], [1.0]])).is_some());
    }

    #[test]
    fn a_mode_without_input_matters_only_if_it_does_not_decay() {
        let b = matrix([[1.0], [0.0]]);
        assert_eq!(lost(&matrix([[1.2, 0.3], [0.0, 0.999]]), &b), None);
        let marginal = lost(&matrix([[0.2, 0.3], [0.0, 1.0]]), &b).unwrap();
        assert!((marginal - Complex::from(1.0)).norm() < 1e-12);
    }

    #[test]
    fn two_equal_unstable_modes_need_two_inputs() {
        let a = DMatrix::identity(2, 2) * 1.1;
        assert!(lost(&a, &matrix([[1.0], [2.0]])).is_some());
        assert_eq!(lost(&a, &matrix([[1.0, 0.0], [2.0, 1.0]])), None);
    }

    #[test]
    fn the_unit_of_an_input_does_not_decide() {
        let a = matrix([[1.0, 1e-4], [0.0, 1.0]]);
        for unit in [1e-12, 1.0, 1e12] {
            assert_eq!(lost(&a, &(matrix([[5e-9], [1e-4]]) * unit)), None, "{unit}");
        }
        assert!(lost(&a, &matrix([[0.0], [0.0]])).is_some());
    }

    #[test]
    fn an_oscillation_is_named_by_its_pair() {
        let a = matrix([[0.6, 0.9, 0.0], [-0.9, 0.6, 0.0], [0.0, 0.0, 0.5]]);
        let lambda = lost(&a, &matrix([[0.0], [0.0], [1.0]])).unwrap();
        assert_eq!(spoken(lambda), "0.6 ± 0.9i");
    }

    #[test]
    fn eigenvalues_of_very_large_and_very_small_matrices_are_found() {
        for unit in [1e-300, 1.0, 1e300] {
            let mut found = eigenvalues(&(matrix([[1.0, 0.9], [0.9, 1.0]]) * unit)).unwrap();
            found.sort_by(|x, y| x.re.total_cmp(&y.re));
            for (lambda, expected) in found.iter().zip([0.1, 1.9]) {
                assert!((lambda / unit - Complex::from(expected)).norm() < 1e-14, "{unit}: {lambda}");
            }
        }
    }

    #[test]
    fn eigenvalues_of_a_cyclic_shift_are_the_roots_of_one() {
        for size in 1..=9 {
            let shift = DMatrix::from_fn(size, size, |i, j| if j == (i + 1) % size { 1.0 } else { 0.0 });
            let found = eigenvalues(&shift).unwrap();
            assert_eq!(found.len(), size);
            for lambda in found {
                assert!((lambda.powu(size as u32) - Complex::from(1.0)).norm() < 1e-12, "{size}: {lambda}");
            }
        }
    }
}
