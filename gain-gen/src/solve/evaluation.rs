//! Solution of `x = T x + c` for a linear map `T` that is only known by its action: the cost of fixed gains.
//!
//! GMRES with restarts: as many applications as the map has distinct slow modes, where plain iteration takes as many as
//! its slowest mode needs to decay. Where a map is known that is like `T` and easily solved for, a few applications do.

use super::krylov::{Krylov, norm};
use nalgebra::DVector;

/// Applications before a restart.
const SPACE: usize = 60;
/// Restarts before what has been reached must do.
const RESTARTS: usize = 12;
/// Applications between looks at the residual.
const LOOK_EVERY: usize = 10;

/// The correction `d` with `d = T d + residual`, to `tolerance` times the length of `scale`; `None` if GMRES stalls far
/// from that.
pub(crate) fn solve_correction(
    residual: &[f64],
    scale: f64,
    tolerance: f64,
    mut apply: impl FnMut(&[f64], &mut [f64]),
) -> Option<Vec<f64>> {
    let mut before = residual.to_vec();
    let in_place = |vector: &mut [f64]| {
        before.copy_from_slice(vector);
        apply(&before, vector);
    };
    solve_like(residual, scale, tolerance, |_| (), in_place)
}

/// The same for a map that works in place, with the help of `solved`, which makes of `r` about the `d` with `d = T d + r`.
pub(super) fn solve_like(
    residual: &[f64],
    scale: f64,
    tolerance: f64,
    solved: impl Fn(&mut [f64]),
    mut apply: impl FnMut(&mut [f64]),
) -> Option<Vec<f64>> {
    let target = tolerance * scale;
    let mut correction = vec![0.0; residual.len()];
    let mut rest = residual.to_vec();
    let mut reached = norm(&rest);
    for _ in 0..RESTARTS {
        if reached <= target {
            break;
        }
        let mut space = Krylov::new(&rest, SPACE.min(residual.len()))?;
        let mut best = (Vec::new(), f64::INFINITY);
        while space.can_grow() {
            // I - T, after what is like its inverse.
            space.grow(|vector| {
                solved(vector);
                let before = vector.to_vec();
                apply(vector);
                vector.iter_mut().zip(before).for_each(|(value, before)| *value = before - *value);
            });
            if space.dimension() % LOOK_EVERY == 0 || !space.can_grow() {
                best = least_squares(&space, reached);
                if best.1 <= target {
                    break;
                }
            }
        }
        let mut step = space.combine(&best.0);
        solved(&mut step);
        correction.iter_mut().zip(step).for_each(|(value, step)| *value += step);
        // The true residual, not the one the recursion believes in.
        rest.copy_from_slice(&correction);
        apply(&mut rest);
        for (index, rest) in rest.iter_mut().enumerate() {
            *rest += residual[index] - correction[index];
        }
        let now = norm(&rest);
        // A space that took off less than half is not worth another.
        if now > 0.5 * reached {
            reached = now.min(reached);
            break;
        }
        reached = now;
    }
    (reached <= norm(residual) * 1e-3 || reached <= target).then_some(correction)
}

/// Coordinates that leave the smallest residual of a right-hand side of the given length, and its length.
fn least_squares(space: &Krylov, length: f64) -> (Vec<f64>, f64) {
    let projected = space.projected_with_rest();
    let mut right = DVector::zeros(projected.nrows());
    right[0] = length;
    let factors = projected.clone().qr();
    let rotated = factors.q().tr_mul(&right);
    let Some(coordinates) = factors.r().solve_upper_triangular(&rotated) else {
        return (Vec::new(), f64::INFINITY);
    };
    let left = (right - projected * &coordinates).norm();
    (coordinates.as_slice().to_vec(), left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn a_map_just_inside_the_unit_circle_is_solved_in_a_few_applications() {
        let size = 40;
        let map = DMatrix::from_fn(size, size, |i, j| match (i, j) {
            (0, 0) => 0.999_99,
            _ if i == j => 0.5 - i as f64 * 0.01,
            _ => 0.001,
        });
        let right: Vec<f64> = (0..size).map(|i| 1.0 + i as f64).collect();
        let mut applications = 0;
        let found = solve_correction(&right, 1e3, 1e-13, |from, to| {
            applications += 1;
            to.copy_from_slice((&map * DVector::from_column_slice(from)).as_slice());
        });
        let found = DVector::from_vec(found.expect("a solution"));
        let residual = &found - &map * &found - DVector::from_vec(right);
        assert!(residual.norm() < 1e-12 * found.norm());
        assert!(applications < 130, "{applications}");
    }
}
