//! Spectral radius of a linear map that is only known by its action.
//!
//! Arnoldi's method: the closed loop's second moments can rotate (complex pairs of eigenvalues close in modulus to
//! the largest), which plain power iteration mistakes for no convergence.

use super::krylov::{Krylov, norm};
use crate::design::modes;
use nalgebra::{Complex, DMatrix};

/// Numbers all basis vectors may hold together: 160 MB.
const ROOM: usize = 20_000_000;
/// Basis vectors at least and at most; most maps here settle within a few dozen.
const SPACE: (usize, usize) = (48, 120);
/// Plain applications before the first basis is built, at least: what decays fast then needs no basis vector.
pub(super) const FILTER: usize = 48;
/// Relative change to the next look at the eigenvalues that counts as none, in the first space and, since equal eigenvalues
/// in one block cannot be told more accurately than by a root of the rounding error, in the later ones.
const SETTLED: [f64; SPACES] = [1e-10, 1e-10, 1e-6];
/// Part of the radius by which an eigenvalue may differ from it and still be the radius itself.
const ATTAINED: f64 = 1e-8;
/// Part of the radius by which the map may lead out of the space along the direction that it stretches most.
const REST: f64 = 1e-10;
/// Looks in a row at which a largest real eigenvalue may not have changed.
const LOOKS: usize = 2;
/// Radius from which the distance from 1 counts.
pub(super) const NEAR_ONE: f64 = 0.999;
/// Factor that leads from an estimate of the radius beyond all eigenvalues.
pub(super) const BEYOND: f64 = 1.03;
/// Radius above which nothing near 1 need be looked for.
pub(super) const CLEARLY_UNSTABLE: f64 = 1.05;
/// Accuracy of solutions from which a largest real eigenvalue is found.
pub(super) const RESOLVENT: f64 = 1e-12;
/// Solutions taken for it, at most.
const SOLUTIONS: usize = 40;
/// Part of a number that its imaginary part may be by rounding.
const REAL: f64 = 1e-6;
/// Change of an eigenvalue, relative to its distance from 1, that counts as none.
const RESOLVED: f64 = 1e-7;
/// Spaces built, each from the direction that dominates the one before.
pub(super) const SPACES: usize = 3;

/// Spectral radius of `apply` on the space reached from `start`.
///
/// For a map that leaves a cone of costs invariant and a `start` inside the cone, that is the spectral radius, and an
/// eigenvalue itself. `strides` says how many applications each space takes as one: packets in flight shift through a
/// sequence before they are gone, which looks like an eigenvalue to a space that sees every shift.
pub(crate) fn spectral_radius(
    start: &[f64],
    strides: [usize; SPACES],
    apply: impl FnMut(&[f64], &mut [f64]),
) -> f64 {
    settled_radius(start, FILTER, strides, apply).0
}

/// The same after `filter` plain applications, and whether it has settled.
pub(super) fn settled_radius(
    start: &[f64],
    filter: usize,
    strides: [usize; SPACES],
    mut apply: impl FnMut(&[f64], &mut [f64]),
) -> (f64, bool) {
    let mut start = filtered(start, filter, &mut apply);
    let mut between = vec![0.0; start.len()];
    let mut radius = 0.0;
    for (stride, tolerance) in strides.into_iter().zip(SETTLED) {
        let strided = |from: &[f64], to: &mut [f64]| {
            apply(from, to);
            for _ in 1..stride {
                between.copy_from_slice(to);
                apply(&between, to);
            }
        };
        let (found, dominant) = in_one_space(&start, tolerance, strided);
        radius = found.powf(1.0 / stride as f64);
        match dominant {
            Some(direction) => start = direction,
            None => return (radius, true),
        }
    }
    (radius, false)
}

/// The largest real eigenvalue near 1 of a map of which `solved` gives the solution `x` of `x = T x + r`: one of
/// `1 - 1 / theta` over the eigenvalues of the map from `r` to `x`. `None` if none settles.
///
/// What is asked of a cone-preserving map whose eigenvalues crowd at the unit circle with all phases: its radius is an
/// eigenvalue, and among all of them the one that stands out here.
pub(super) fn largest_real_near_one(
    start: &[f64],
    mut solved: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Option<f64> {
    let mut space = Krylov::new(start, SOLUTIONS.min(start.len()))?;
    let mut last = f64::NAN;
    let mut settled = 0;
    while space.can_grow() {
        let mut failed = false;
        space.grow(|from, to| match solved(from) {
            Some(solution) => to.copy_from_slice(&solution),
            None => failed = true,
        });
        if failed {
            return None;
        }
        let values = modes::computed_eigenvalues(&space.projected().into_owned())?;
        let real = values.iter().filter(|theta| theta.im.abs() <= REAL * theta.norm() && theta.norm() > 0.0);
        let found = real.map(|theta| 1.0 - theta.re.recip()).filter(|value| (value - 1.0).abs() < 1.0);
        let found = found.fold(f64::NAN, f64::max);
        settled = if (found - last).abs() <= RESOLVED * (1.0 - found).abs() { settled + 1 } else { 0 };
        last = found;
        if settled >= LOOKS {
            return Some(found);
        }
    }
    // An invariant space has it exactly.
    (!last.is_nan() && space.dimension() < SOLUTIONS).then_some(last)
}

/// The radius as one space shows it, and unless it has settled there the direction to go on from.
fn in_one_space(
    start: &[f64],
    tolerance: f64,
    mut apply: impl FnMut(&[f64], &mut [f64]),
) -> (f64, Option<Vec<f64>>) {
    let most = (ROOM / start.len().max(1)).clamp(SPACE.0, SPACE.1).min(start.len());
    let Some(mut space) = Krylov::new(start, most) else { return (0.0, None) };
    let (mut radius, mut last) = (0.0, 0.0);
    // Eigenvalues of a small matrix cost more than an application: look ever less often.
    let mut look = 4;
    while space.can_grow() {
        space.grow(&mut apply);
        if space.dimension() < look && space.can_grow() {
            continue;
        }
        look += look.div_ceil(3);
        // A look at which the eigenvalues do not settle is passed over; the next has a larger matrix.
        let Some(values) = modes::computed_eigenvalues(&space.projected().into_owned()) else { continue };
        let found = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
        // The changes to come are foreseen to shrink as the last one did.
        let change = (found - radius).abs();
        let shrinks = if last > 0.0 { change / last } else { 1.0 };
        let foreseen = if shrinks < 1.0 { change * shrinks / (1.0 - shrinks) } else { change };
        (radius, last) = (found, change);
        // Where another value is as large and none of them real, the radius is not among them yet.
        let is_attained =
            |value: &Complex<f64>| value.re >= found * (1.0 - ATTAINED) && value.im.abs() <= ATTAINED * found;
        if foreseen <= tolerance * found && values.iter().any(is_attained) {
            let matrix = space.projected_with_rest().into_owned();
            let direction = dominant(&space.projected().into_owned(), found);
            let rest = matrix[(space.dimension(), space.dimension() - 1)] * direction[direction.len() - 1];
            if rest.abs() <= REST * found {
                return (radius, None);
            }
        }
    }
    // A space that is invariant has the radius exactly.
    let exhausted = space.dimension() == most && most < start.len();
    let direction = exhausted.then(|| space.combine(&dominant(&space.projected().into_owned(), radius)));
    (radius, direction)
}

/// `start` after some applications, scaled to unit length in between; zero if nothing is left of it.
fn filtered(start: &[f64], applications: usize, apply: &mut impl FnMut(&[f64], &mut [f64])) -> Vec<f64> {
    let mut vector = start.to_vec();
    let mut image = vec![0.0; start.len()];
    for _ in 0..applications {
        let length = norm(&vector);
        if length < f64::MIN_POSITIVE {
            break;
        }
        vector.iter_mut().for_each(|value| *value /= length);
        apply(&vector, &mut image);
        std::mem::swap(&mut vector, &mut image);
    }
    vector
}

/// Coordinates of the direction that `projected` stretches by `radius`, by inverse iteration.
pub(crate) fn dominant(projected: &DMatrix<f64>, radius: f64) -> Vec<f64> {
    let size = projected.nrows();
    // Just beside the eigenvalue, so that the matrix can be factored.
    let shifted = projected - DMatrix::identity(size, size) * (radius * (1.0 + 1e-10));
    let factors = shifted.lu();
    let mut direction = nalgebra::DVector::from_element(size, 1.0);
    for _ in 0..3 {
        let Some(next) = factors.solve(&direction) else { break };
        direction = next.normalize();
    }
    direction.as_slice().to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn radius_of(matrix: &DMatrix<f64>) -> f64 {
        let start = vec![1.0; matrix.ncols()];
        spectral_radius(&start, [1; SPACES], |from, to| {
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
