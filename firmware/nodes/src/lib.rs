//! The closed loop that runs on the reference board and, unchanged, on the host.
//!
//! | file | what lives there |
//! |---|---|
//! | `closed_loop` | controller, actuator and plant model, passing frames for 200 cycles |
//! | `scripted_link` | a link whose delays and losses are written down |
//! | `board` | what only the board has: arguments, exit status, panics and faults |
//!
//! Gains and plant come from `designs/pendulum.toml`, turned into constants by the build script.
#![no_std]
#![deny(unsafe_code)]

#[cfg(target_os = "none")]
pub mod board;
mod closed_loop;
mod scripted_link;

pub use closed_loop::{CYCLES, Outcome, run};

/// What gain-gen makes of `designs/pendulum.toml`.
pub mod pendulum {
    include!(concat!(env!("OUT_DIR"), "/pendulum.rs"));
}
