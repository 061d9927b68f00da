//! `Model`: the plant as the estimator sees it. Constant data; no algorithm lives here.

use nalgebra::{SMatrix, SVector};

/// Most states that a controller runs with. Its matrices lie on the stack: with 32 states an estimate takes 4 KB in `f32`, and
/// each remembered cycle at least one.
pub const MOST_STATES: usize = 32;

/// Discrete-time linear plant with Gaussian noise, thesis (3.1)-(3.3):
/// `x+ = A x + B u + w`, `y = C x + v`, `w ~ N(0, W)`, `v ~ N(0, V)`, `x_0 ~ N(initial_mean, initial_covariance)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Model<T, const NX: usize, const NU: usize, const NY: usize> {
    /// State transition over one cycle, `nx x nx`.
    pub a: SMatrix<T, NX, NX>,
    /// Input over one cycle, `nx x nu`.
    pub b: SMatrix<T, NX, NU>,
    /// Output, `ny x nx`.
    pub c: SMatrix<T, NY, NX>,
    /// Process noise covariance per cycle, `W`, `nx x nx`, positive semidefinite.
    pub process_noise: SMatrix<T, NX, NX>,
    /// Measurement noise covariance, `V`, `ny x ny`, positive definite.
    pub measurement_noise: SMatrix<T, NY, NY>,
    /// Expected state before anything was measured.
    pub initial_mean: SVector<T, NX>,
    /// Covariance of the state before anything was measured, positive semidefinite.
    pub initial_covariance: SMatrix<T, NX, NX>,
}
