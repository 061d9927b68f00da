//! Estimation of the plant's state from measurements that come late, out of order or not at all.
//!
//! [`Kalman`] is the optimal filter when every applied input is known (acknowledged). What the plant is like
//! is in [`Model`]; what its states mean, only the design knows.

mod kalman;
mod model;

pub use kalman::{Kalman, RejectedMeasurement};
pub use model::Model;
