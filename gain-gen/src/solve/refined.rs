//! The fixed point of the in-flight recursion to the last digits of `f64`, where rounding adds up to more.
//!
//! A loop that forgets by a millionth a cycle adds up the rounding of a million steps. So the cost-to-go is kept in twice the
//! precision, and the core takes its step in it; what that step changes, the residual, is then right, and the correction
//! that it asks for needs but a few digits: Newton's method, as in `network_free` but with the link.

use super::flat::Flat;
use super::iterate::change_of;
use crate::extended::Extended;
use slqg::synthesis::{Problem, Synthesis};

/// Corrections allowed.
const MOST: usize = 8;
/// Change of the gains, relative to the largest, that leaves every digit of `f64` as it is.
const SETTLED: f64 = 1e-16;
/// Corrections that may leave the gains as far off as they were.
const SETBACKS: usize = 2;

/// A cost-to-go and its gains, and how far they may still be off.
pub(super) struct Refined {
    /// `(P, S, Y, N_t)` as the core lays them out.
    pub(super) value: Vec<f64>,
    /// `[Lx M]` by rows.
    pub(super) gains: Vec<f64>,
    /// What the last correction moved in the gains, relative to the largest.
    pub(super) error: f64,
}

/// The fixed point near `value`. `correct` gives for gains and a residual the `d` with `d = T d + residual`, where `T` is the
/// step with these gains and without stage cost. `None` if the corrections do not get anywhere.
pub(super) fn refined(
    flat: &Flat,
    value: &[f64],
    mut correct: impl FnMut(&[f64], &[f64]) -> Option<Vec<f64>>,
) -> Option<Refined> {
    let wide = |numbers: &[f64]| -> Vec<Extended> { numbers.iter().map(|&number| number.into()).collect() };
    let given = flat.problem();
    let [a, b, q, r, survival] = [given.a, given.b, given.q, given.r, given.survival].map(wide);
    let problem = Problem { dimensions: given.dimensions, a: &a, b: &b, q: &q, r: &r, survival: &survival };
    let mut workspace = vec![Extended::ZERO; given.dimensions.workspace_len()];
    let mut synthesis = Synthesis::new(problem, &mut workspace).ok()?;

    let rounded =
        |numbers: &[Extended]| -> Vec<f64> { numbers.iter().map(|number| number.rounded()).collect() };
    let mut value = wide(value);
    let mut gains = Vec::new();
    let (mut error, mut setbacks) = (f64::INFINITY, 0);
    for _ in 0..MOST {
        synthesis.value_mut().copy_from_slice(&value);
        synthesis.optimal_step();
        let new = rounded(synthesis.gains());
        if !gains.is_empty() {
            let moved = change_of(&mut gains, new);
            setbacks += usize::from(moved > 0.5 * error);
            error = error.min(moved);
            if moved <= SETTLED || setbacks == SETBACKS {
                break;
            }
        } else {
            gains = new;
        }
        let residual: Vec<f64> = synthesis
            .value()
            .iter()
            .zip(&value)
            .map(|(after, before)| (*after - *before).rounded())
            .collect();
        let correction = correct(&gains, &residual)?;
        value.iter_mut().zip(correction).for_each(|(value, change)| *value += change.into());
    }
    error.is_finite().then(|| Refined { value: rounded(&value), gains, error: error.max(f64::EPSILON) })
}
