#![no_std]
#![forbid(unsafe_code)]
//! Placeholder.
mod actuator;
pub use actuator::DefaultInput;
