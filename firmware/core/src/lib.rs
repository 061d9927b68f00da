#![no_std]
#![forbid(unsafe_code)]
//! Sequence-based LQG control over links that lose and delay packets.
//!
//! The controller sends *sequences* of future inputs; the actuator buffers the newest sequence and plays it
//! out through losses. This crate is everything that runs on a device, and the simulator runs exactly this
//! code: no heap, no unsafe code, no panic on any bytes that come over the wire, the same bits in `f32` on a
//! workstation and on a Cortex-M.
//!
//! The rooms, from the outside in:
//!
//! | room | what lives there |
//! |---|---|
//! | [`wire`] | frames as bytes: measurement, control, acknowledgement |
//! | [`controller`] | one control cycle: frames in, control frame out |
//! | [`actuator`] | buffer, past-packet rejection, default input, saturation, acknowledgement |
//! | [`estimator`] | state and ages, from measurements and acknowledgements that come late, out of order or not at all |
//! | [`gains`] | the optimal gains as constant data, and the control law |
//! | [`blob`] | gains as bytes that are loaded at run time |
//! | [`bank`] | two sets of gains, one in force and one that may be written |
//! | [`in_flight`] | what was sent and may still be applied |
//! | [`tracking`] | feedforward from the reference samples that are known ahead |
//! | [`event`] | whether a sequence is worth sending |
//! | [`identity`] | which plant gains and frames belong to |
//! | [`checked`] | numbers that were found finite, or probabilities |
//! | [`integrity`] | memory that changes by itself: copies and checksums |
//! | [`health`] | how an end of the loop is |
//! | [`played`] | ages, the default input, how likely each is, and what was applied |
//! | [`sequence`], [`tick`], [`scalar`], [`number`] | a control sequence, the only clock there is, `f32` and `f64`, what gains may be computed in |
//! | [`arrival`] | what a delay distribution says about packets under way |
//! | [`synthesis`] | the recursion that computes the gains, for the generator and for the device itself |
//! | [`tuning`] | the device solves its own gains when the link has changed |
//! | `authentication` | frames that only holders of a key can make; a feature of that name |
//!
//! Immutable configuration ([`gains::Gains`], [`estimator::Model`], [`actuator::Settings`]) and mutable state
//! ([`controller::Controller`], [`estimator::ModeFilter`], [`actuator::Actuator`]) are separate types.
//! Values live at run time, shapes in types: `NX` states, `NU` inputs and `NY` outputs are const generics; how long sequences
//! are, how many cycles are remembered and how many estimates are kept are data, in memory that the caller lends
//! ([`controller::Memory`]).

pub mod actuator;
pub mod arrival;
#[cfg(feature = "authentication")]
pub mod authentication;
pub mod bank;
pub mod blob;
pub mod checked;
mod checksum;
pub mod controller;
pub mod estimator;
pub mod event;
pub mod gains;
pub mod health;
pub mod identity;
pub mod in_flight;
pub mod integrity;
pub mod number;
pub mod played;
pub mod scalar;
pub mod sequence;
pub mod synthesis;
pub mod tick;
pub mod tracking;
pub mod tuning;
pub mod wire;

pub use health::Health;
pub use number::Number;
pub use played::{Age, DefaultInput};
pub use scalar::Scalar;
pub use tick::Tick;

/// The linear algebra whose static types appear in this crate's interfaces.
pub use nalgebra;
