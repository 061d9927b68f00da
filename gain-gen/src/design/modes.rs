//! Modes of a discrete plant: which of them grow, and whether inputs reach and outputs see them (Popov-Belevitch-Hautus).
//!
//! All of it is decided in balanced units ([`crate::balance`]), and block by block: states that drive each other only one
//! way have eigenvalues of their own, and those of a delay line or of an integrator are then exact. What is left to
//! rounding is decided by a distance: how little the entries would have to change for a value to be an eigenvalue, or for
//! a mode to be out of reach.

use super::eigenvalues::eigenvalues;
use crate::balance::{in_units, state_units, state_units_with_free_inputs};
use nalgebra::{Complex, DMatrix};

/// Distance of a computed eigenvalue from the unit circle up to which rounding may have moved it: that of a sixfold one
/// moves by the sixth root of the precision.
const NEAR: f64 = 1e-2;
/// Relative change of the entries, by the size of the matrix, that counts as rounding.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Steps of the iteration for a smallest singular value.
const INVERSE_STEPS: usize = 4;

/// What becomes of a mode that is left alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Growth {
    /// It decays.
    Decays,
    /// Its eigenvalue is on the unit circle, up to rounding of the plant's entries.
    OnTheLimit,
    /// It grows.
    Grows,
}

/// An eigenvalue of a plant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mode {
    /// Of modulus exactly 1 if it is on the limit.
    pub(crate) value: Complex<f64>,
    pub(crate) growth: Growth,
}

impl Mode {
    /// Growth per step; exactly 1 on the limit.
    pub(crate) fn modulus(&self) -> f64 {
        if self.growth == Growth::OnTheLimit { 1.0 } else { self.value.norm() }
    }
}

/// The modes of the square matrix `a`; `None` if the iteration for their eigenvalues does not converge.
pub(crate) fn modes(a: &DMatrix<f64>) -> Option<Vec<Mode>> {
    let mut found = Vec::with_capacity(a.nrows());
    for block in blocks(a) {
        let values = computed_eigenvalues(&block)?;
        found.extend(values.into_iter().map(|value| classified(&block, value)));
    }
    Some(found)
}

/// The eigenvalues that do not decay. `None` as [`modes`].
pub(crate) fn unstable_eigenvalues(a: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let persistent = modes(a)?.into_iter().filter(|mode| mode.growth != Growth::Decays);
    Some(persistent.map(|mode| mode.value).collect())
}

/// The diagonal blocks of the block triangular form that exchanging states gives: groups of states that all drive each
/// other, in balanced units.
fn blocks(a: &DMatrix<f64>) -> Vec<DMatrix<f64>> {
    let size = a.nrows();
    let mut reaches = DMatrix::from_fn(size, size, |i, j| i == j || a[(i, j)] != 0.0);
    for through in 0..size {
        for from in 0..size {
            if reaches[(from, through)] {
                for to in 0..size {
                    reaches[(from, to)] |= reaches[(through, to)];
                }
            }
        }
    }
    let mut taken = vec![false; size];
    let mut found = Vec::new();
    for first in 0..size {
        if taken[first] {
            continue;
        }
        let group: Vec<usize> =
            (first..size).filter(|&other| reaches[(first, other)] && reaches[(other, first)]).collect();
        group.iter().for_each(|&state| taken[state] = true);
        let block = DMatrix::from_fn(group.len(), group.len(), |i, j| a[(group[i], group[j])]);
        let none = DMatrix::zeros(group.len(), 0);
        let units = state_units(&block, &none, &none.transpose());
        found.push(in_units(&block, &units));
    }
    found
}

/// The eigenvalues of a square matrix as the QR iteration has them, in no particular coordinates.
pub(crate) fn computed_eigenvalues(a: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    if a.nrows() == 1 {
        return Some(vec![Complex::from(a[0])]);
    }
    // Scaled to entries of at most 1: neither overflow nor underflow on the way.
    let scale = if a.amax() > 0.0 { a.amax() } else { 1.0 };
    let of = |a: DMatrix<f64>| {
        let mut found = eigenvalues(&(a / scale))?;
        found.iter_mut().for_each(|lambda| *lambda *= scale);
        found.iter().all(|lambda| lambda.re.is_finite() && lambda.im.is_finite()).then_some(found)
    };
    // The shifted QR iteration can stand still on orthogonal matrices such as a cyclic shift; a reflection
    // keeps the eigenvalues and breaks the pattern.
    of(a.clone()).or_else(|| {
        let normal = DMatrix::from_fn(a.nrows(), 1, |i, _| 1.0 / (i as f64 + 1.3));
        let strength = 2.0 / normal.norm_squared();
        let reflection = DMatrix::identity(a.nrows(), a.nrows()) - &normal * normal.transpose() * strength;
        of(&reflection * a * &reflection)
    })
}

/// The eigenvalue with what becomes of its mode.
fn classified(block: &DMatrix<f64>, value: Complex<f64>) -> Mode {
    let modulus = value.norm();
    if (modulus - 1.0).abs() <= NEAR {
        // Equal eigenvalues are computed apart from each other; they are real more often than anything else.
        let real = Complex::from(value.re.signum());
        let candidates = [((value - real).norm() <= NEAR).then_some(real), Some(value / modulus)];
        let on_circle = candidates.into_iter().flatten().find(|&candidate| is_eigenvalue(block, candidate));
        if let Some(value) = on_circle {
            return Mode { value, growth: Growth::OnTheLimit };
        }
    }
    Mode { value, growth: if modulus > 1.0 { Growth::Grows } else { Growth::Decays } }
}

/// Whether entries of `block` that differ by no more than rounding would have this eigenvalue.
fn is_eigenvalue(block: &DMatrix<f64>, value: Complex<f64>) -> bool {
    let pencil = shifted(block, value);
    smallest_singular_value(&pencil) <= ROUNDING * block.nrows() as f64 * block.norm().max(1.0)
}

/// `lambda I - A`.
fn shifted(a: &DMatrix<f64>, lambda: Complex<f64>) -> DMatrix<Complex<f64>> {
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| {
        let shift = if i == j { lambda } else { Complex::from(0.0) };
        shift - Complex::from(a[(i, j)])
    })
}

/// Smallest singular value of a matrix with at least as many columns as rows, from above, to a few per cent.
fn smallest_singular_value(matrix: &DMatrix<Complex<f64>>) -> f64 {
    let triangle = matrix.adjoint().qr().r();
    let size = triangle.nrows();
    let mut direction = nalgebra::DVector::from_fn(size, |i, _| Complex::new(1.0, 0.3 / (1.0 + i as f64)));
    let mut least = f64::INFINITY;
    for _ in 0..INVERSE_STEPS {
        let length = direction.norm();
        if !(length > 0.0 && length.is_finite()) {
            return 0.0;
        }
        direction /= Complex::from(length);
        // (R^H R)^-1; a pivot of zero is a singular value of zero.
        let Some(half) = triangle.ad_solve_upper_triangular(&direction) else { return 0.0 };
        let Some(next) = triangle.solve_upper_triangular(&half) else { return 0.0 };
        least = least.min(half.norm().recip());
        direction = next;
    }
    least
}

/// The first of the eigenvalues `unstable` of `a` (nx x nx) whose mode no column of `b` (nx x any) reaches.
/// `None`: (a, b) is stabilisable. With `a` and `c` transposed it answers detectability of (a, c).
pub(crate) fn unreached(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    unstable: &[Complex<f64>],
) -> Option<Complex<f64>> {
    if unstable.is_empty() {
        return None;
    }
    let units = state_units_with_free_inputs(a, b);
    let a = in_units(a, &units);
    let mut b = DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] / units[i]);
    // Columns of equal size: the unit of an input must not decide the rank.
    for mut column in b.column_iter_mut() {
        let length = column.amax();
        if length > 0.0 {
            column /= length;
        }
    }
    let (size, inputs) = b.shape();
    let b = b.map(Complex::from);
    // A mode and its conjugate are reached alike.
    unstable.iter().copied().filter(|lambda| lambda.im >= 0.0).find(|&lambda| {
        let mut pencil = DMatrix::from_element(size, size + inputs, Complex::from(0.0));
        pencil.columns_mut(0, size).copy_from(&shifted(&a, lambda));
        pencil.columns_mut(size, inputs).copy_from(&b);
        smallest_singular_value(&pencil) <= ROUNDING * size as f64 * a.norm().max(1.0)
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

    fn values_of_modes(a: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
        Some(modes(a)?.into_iter().map(|mode| mode.value).collect())
    }

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
    fn a_slow_state_and_a_weak_coupling_do_not_hide_an_integrator() {
        let charge = matrix([[1.0, 5.6e-10], [0.0, 0.9]]);
        assert_eq!(lost(&charge, &matrix([[0.0], [0.1]])), None);
        assert!(
            lost(&charge.transpose(), &matrix([[0.0], [0.1]])).is_some(),
            "seen through the fast state alone"
        );
    }

    #[test]
    fn what_rounding_cannot_tell_from_the_unit_circle_is_on_the_limit() {
        let growth =
            |a: &DMatrix<f64>| -> Vec<Growth> { modes(a).unwrap().iter().map(|mode| mode.growth).collect() };
        assert_eq!(growth(&matrix([[1.0, 0.1], [0.0, 0.7]])), [Growth::OnTheLimit, Growth::Decays]);
        assert_eq!(
            growth(&matrix([[1.0 - 1e-12, 0.1], [0.0, 1.0 + 1e-12]])),
            [Growth::Decays, Growth::Grows]
        );
        // Four integrators in coordinates that mix them: one eigenvalue four times, computed 1e-4 apart.
        let chain = DMatrix::from_fn(4, 4, |i, j| if j == i || j == i + 1 { 1.0 } else { 0.0 });
        let mix =
            DMatrix::from_fn(4, 4, |i, j| 1.0 / (1.0 + (i + 2 * j) as f64) + if i == j { 2.0 } else { 0.0 });
        let mixed = &mix * chain * mix.clone().try_inverse().unwrap();
        assert_eq!(growth(&mixed), [Growth::OnTheLimit; 4]);
        let (sin, cos) = 0.3_f64.sin_cos();
        assert_eq!(growth(&matrix([[cos, sin], [-sin, cos]])), [Growth::OnTheLimit; 2]);
    }

    #[test]
    fn eigenvalues_of_a_delay_line_are_zero() {
        let shift = DMatrix::from_fn(60, 60, |i, j| if j == i + 1 { 1.0 } else { 0.0 });
        assert!(values_of_modes(&shift).unwrap().iter().all(|lambda| lambda.norm() == 0.0));
    }

    #[test]
    fn eigenvalues_of_very_large_and_very_small_matrices_are_found() {
        for unit in [1e-300, 1.0, 1e300] {
            let mut found = values_of_modes(&(matrix([[1.0, 0.9], [0.9, 1.0]]) * unit)).unwrap();
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
            let found = values_of_modes(&shift).unwrap();
            assert_eq!(found.len(), size);
            for lambda in found {
                assert!((lambda.powu(size as u32) - Complex::from(1.0)).norm() < 1e-12, "{size}: {lambda}");
            }
        }
    }
}
