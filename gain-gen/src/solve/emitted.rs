//! The law as it is emitted, every number rounded to the device's scalar, in the exact plant's loop.

use super::{LoopProblem, Solution, Unacknowledged, closed_loop::mean_square_rate, in_flight::rate_of};
use crate::design::{Design, DeviceScalar};
use nalgebra::DMatrix;
use slqg::arrival::table_len;

/// Numbers of the dense second moments up to which they are gone through: they see the rounding of `r`, too.
const DENSE: usize = 4_000;

/// Mean-square rate with the numbers that are emitted: of the law for a loop without acknowledgements if that was `found`, otherwise
/// of the solution's, and where that does not stabilise its rate.
pub(crate) fn emitted_rate(
    design: &Design,
    problem: &LoopProblem,
    solution: &Solution,
    found: Option<&Unacknowledged>,
) -> f64 {
    match found {
        Some(found) => found.emitted_rate,
        None if solution.is_stabilising() => solution.emitted_rate(problem, design.controller.scalar),
        None => solution.mean_square_rate,
    }
}

impl Solution {
    /// `L(i)` as the device computes with it, for every age `i = 0..=N`: the numbers that are emitted, arithmetic exact.
    pub fn emitted_gains(&self, scalar: DeviceScalar) -> Vec<DMatrix<f64>> {
        match (&self.coupled_gains, scalar) {
            (Some(gains), DeviceScalar::F64) => gains.clone(),
            (Some(gains), DeviceScalar::F32) => {
                gains.iter().map(|gain| gain.map(|value| f64::from(value as f32))).collect()
            }
            (None, _) => self.law.rounded_to(scalar).mode_gains(),
        }
    }

    /// Mean-square rate of the loop with the numbers that are emitted, for the problem it solves. Of sequences too long for the dense second moments,
    /// `Lx` and `M` are rounded and `r` is exact.
    pub fn emitted_rate(&self, problem: &LoopProblem, scalar: DeviceScalar) -> f64 {
        let size = problem.a.nrows() + problem.b.ncols() * (table_len(problem.length) + 1);
        match scalar {
            DeviceScalar::F64 => self.mean_square_rate,
            DeviceScalar::F32
                if self.coupled_gains.is_some() || (problem.length + 1) * size * size <= DENSE =>
            {
                mean_square_rate(problem, &self.emitted_gains(scalar))
            }
            DeviceScalar::F32 => {
                rate_of(&self.start, &self.law.rounded_to(scalar), &self.cost_to_go, self.slowest.as_ref())
            }
        }
    }
}
