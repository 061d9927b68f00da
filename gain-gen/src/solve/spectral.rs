//! Spectral radius of a linear map that is only known by its action.
//!
//! Arnoldi's method: the closed loop's second moments can rotate (complex pairs of eigenvalues close in modulus to
//! the largest), which plain power iteration mistakes for no convergence.

use super::krylov::{Krylov, norm};
use crate::design::modes;
use nalgebra::{Complex, DMatrix, DVector};

/// Numbers all basis vectors may hold together: 160 MB.
const ROOM: usize = 20_000_000;
/// Basis vectors at least and at most; most maps here settle within a few dozen.
const SPACE: (usize, usize) = (48, 120);
/// Plain applications before the first basis is built, at least: what decays fast then needs no basis vector.
pub(super) const FILTER: usize = 48;
/// Applications before the first look at the eigenvalues of a space.
const FIRST_LOOK: usize = 4;
/// Part of the applications so far, one over this, after which the next look comes.
const LOOKS_APART: usize = 4;
/// Applications up to which each look is at all eigenvalues.
const SMALL: usize = 6;
/// Relative change to the next look at the eigenvalues that counts as none, in the first space and, since equal eigenvalues
/// in one block cannot be told more accurately than by a root of the rounding error, in the later ones.
const SETTLED: [f64; SPACES] = [1e-10, 1e-10, 1e-6];
/// Part of the radius by which an eigenvalue may differ from it and still be the radius itself.
const ATTAINED: f64 = 1e-8;
/// Part of the radius by which the map may lead out of the space along the direction that it stretches most.
const REST: f64 = 1e-10;
/// Looks in a row at which a largest real eigenvalue may not have changed.
const LOOKS: usize = 2;
/// Radius from which, up to its inverse, the distance from 1 counts.
pub(super) const NEAR_ONE: f64 = 0.999;
/// Factor that leads from an estimate of the radius beyond all eigenvalues.
pub(super) const BEYOND: f64 = 1.03;
/// Radius above which nothing near 1 need be looked for.
const CLEARLY_UNSTABLE: f64 = 1.05;
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
    mut apply: impl FnMut(&[f64], &mut [f64]),
) -> f64 {
    let mut before = start.to_vec();
    let in_place = |vector: &mut [f64]| {
        before.copy_from_slice(vector);
        apply(&before, vector);
    };
    dominant(start, FILTER, strides, in_place).radius
}

/// What a map stretches most.
pub(super) struct Dominant {
    /// By how much: the spectral radius.
    pub(super) radius: f64,
    /// Along which direction, of length 1, as far as it was found.
    pub(super) direction: Vec<f64>,
    /// Whether both have settled.
    pub(super) settled: bool,
}

impl Dominant {
    /// Whether the radius needs no second look: it has settled away from 1, or is far beyond it.
    pub(super) fn is_clear(&self) -> bool {
        let is_near = (NEAR_ONE..=NEAR_ONE.recip()).contains(&self.radius);
        (self.settled && !is_near) || self.radius > CLEARLY_UNSTABLE
    }
}

/// What a map, `apply`, which works in place, stretches most of all that is reached from `start` after `filter` plain
/// applications.
pub(super) fn dominant(
    start: &[f64],
    filter: usize,
    strides: [usize; SPACES],
    mut apply: impl FnMut(&mut [f64]),
) -> Dominant {
    let mut found = Dominant { radius: 0.0, direction: filtered(start, filter, &mut apply), settled: false };
    for (stride, tolerance) in strides.into_iter().zip(SETTLED) {
        found = in_one_space(&found.direction, tolerance, |vector| (0..stride).for_each(|_| apply(vector)));
        found.radius = found.radius.powf(1.0 / stride as f64);
        if found.settled {
            break;
        }
    }
    found
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
        space.grow(|vector| match solved(vector) {
            Some(solution) => vector.copy_from_slice(&solution),
            None => failed = true,
        });
        if failed {
            return None;
        }
        let values = modes::computed_eigenvalues(&space.projected())?;
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

/// The radius as one space shows it, and the direction that it stretches most: to go on from, unless it has settled there.
fn in_one_space(start: &[f64], tolerance: f64, mut apply: impl FnMut(&mut [f64])) -> Dominant {
    let most = (ROOM / start.len().max(1)).clamp(SPACE.0, SPACE.1).min(start.len());
    let none = || Dominant { radius: 0.0, direction: start.to_vec(), settled: true };
    let Some(mut space) = Krylov::new(start, most) else { return none() };
    let (mut radius, mut last) = (0.0, 0.0);
    // Eigenvalues of a small matrix cost more than an application: look ever less often.
    let mut look = FIRST_LOOK;
    while space.can_grow() {
        space.grow(&mut apply);
        if space.dimension() < look && space.can_grow() {
            continue;
        }
        look += look.div_ceil(LOOKS_APART);
        let projected = space.projected();
        let leads_out = |direction: &[f64]| (space.rest() * direction[direction.len() - 1]).abs();
        // All eigenvalues of a larger one are computed where the one near the last radius has settled.
        let mut values = None;
        let mut found;
        let mut may_have_settled = true;
        if space.dimension() <= SMALL {
            // A look at which the eigenvalues do not settle is passed over; the next has a larger matrix.
            values = modes::computed_eigenvalues(&projected);
            let Some(values) = &values else { continue };
            found = largest(values);
        } else {
            let direction = DVector::from_vec(stretched(&projected, radius));
            found = direction.dot(&(&projected * &direction)).abs();
            may_have_settled = leads_out(direction.as_slice()) <= REST * found;
        }
        // The changes to come are foreseen to shrink as the last one did.
        let change = (found - radius).abs();
        let shrinks = if last > 0.0 { change / last } else { 1.0 };
        let foreseen = if shrinks < 1.0 { change * shrinks / (1.0 - shrinks) } else { change };
        if may_have_settled && foreseen <= tolerance * found {
            let Some(values) = values.or_else(|| modes::computed_eigenvalues(&projected)) else { continue };
            found = largest(&values);
            // Where another value is as large and none of them real, the radius is not among them yet.
            let is_attained = |value: &Complex<f64>| {
                value.re >= found * (1.0 - ATTAINED) && value.im.abs() <= ATTAINED * found
            };
            let is_as_before = (found - radius).abs() <= change.max(tolerance * found);
            if is_as_before && values.iter().any(is_attained) {
                let direction = stretched(&projected, found);
                if leads_out(&direction) <= REST * found {
                    return Dominant { radius: found, direction: space.combine(&direction), settled: true };
                }
            }
        }
        (radius, last) = (found, (found - radius).abs());
    }
    let projected = space.projected();
    radius = modes::computed_eigenvalues(&projected).map_or(radius, |values| largest(&values));
    // A space that is invariant has the radius exactly.
    let direction = space.combine(&stretched(&projected, radius));
    let exhausted = space.dimension() == most && most < start.len();
    Dominant { radius, direction, settled: !exhausted }
}

/// Largest modulus.
fn largest(values: &[Complex<f64>]) -> f64 {
    values.iter().map(|value| value.norm()).fold(0.0, f64::max)
}

/// `start` after some applications, scaled to unit length in between; zero if nothing is left of it.
fn filtered(start: &[f64], applications: usize, apply: &mut impl FnMut(&mut [f64])) -> Vec<f64> {
    let mut vector = start.to_vec();
    for _ in 0..applications {
        let length = norm(&vector);
        if length < f64::MIN_POSITIVE {
            break;
        }
        vector.iter_mut().for_each(|value| *value /= length);
        apply(&mut vector);
    }
    vector
}

/// Coordinates of the direction that `projected` stretches by `radius`, by inverse iteration.
fn stretched(projected: &DMatrix<f64>, radius: f64) -> Vec<f64> {
    let size = projected.nrows();
    // Just beside the eigenvalue, so that the matrix can be factored.
    let shifted = projected - DMatrix::identity(size, size) * (radius * (1.0 + 1e-10));
    let factors = shifted.lu();
    let mut direction = DVector::from_element(size, 1.0);
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
            let image = matrix * DVector::from_column_slice(from);
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
