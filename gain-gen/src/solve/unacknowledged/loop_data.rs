//! The loop's data in the coordinates it is solved in.

use crate::solve::LoopProblem;
use nalgebra::DMatrix;

/// Plant, noise, weights and links, without the filter.
#[derive(Clone)]
pub(super) struct LoopData {
    /// Plant, weights, link to the actuator, sequences.
    pub(super) problem: LoopProblem,
    /// `C`, `ny x nx`.
    pub(super) c: DMatrix<f64>,
    /// `W`, `nx x nx`.
    pub(super) process_noise: DMatrix<f64>,
    /// `V`, `ny x ny`.
    pub(super) measurement_noise: DMatrix<f64>,
    /// Probability that the controller knows the newest measurement, and with it all before.
    pub(super) hears: f64,
}
