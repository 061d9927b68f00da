//! From a design file (plant, cost, measured link) to optimal gains, a stability verdict and generated source.

pub mod design;
pub mod discretise;
pub mod solve;
pub mod stability;
