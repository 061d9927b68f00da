//! From a design file (plant, cost, measured link) to optimal gains, a stability verdict and generated source.

mod balance;
pub mod build;
pub mod certificate;
mod channels;
pub mod console;
pub mod design;
pub mod discretise;
pub mod effort;
pub mod emit;
pub mod estimation;
mod extended;
mod figure;
pub mod joining;
mod json;
pub mod keys;
pub mod lengths;
pub mod margins;
mod paragraph;
mod problem;
pub mod report;
mod saturation;
pub mod solve;
pub mod stability;
pub mod sweep;
mod units;
pub mod warnings;
