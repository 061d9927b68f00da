//! The closed loops that run on the reference board and, unchanged, on the host.
//!
//! | file | what lives there |
//! |---|---|
//! | `cases` | which designs are run |
//! | `closed_loop` | controller, actuator and plant model, passing frames for 200 cycles |
//! | `steps` | the same cycle step by step, each step timed |
//! | `time` | time added up |
//! | `scripted_link` | a link whose delays and losses are written down |
//! | `board` | what only the board has: arguments, exit status, panics and faults |
//!
//! Gains and plants come from `designs/`, turned into constants by the build script.
#![no_std]
#![deny(unsafe_code)]

#[cfg(target_os = "none")]
pub mod board;
mod cases;
mod closed_loop;
mod scripted_link;
mod steps;
mod time;

pub use cases::{CASES, Case};
pub use closed_loop::{CYCLES, Outcome};
pub use steps::{Cost, each_step_cost};
pub use time::Time;

use crc::{CRC_32_ISCSI, Crc};

/// One digest for the digests of all cases, in their order.
pub fn digest_of(outcomes: &[Outcome]) -> u32 {
    let checksum = Crc::<u32>::new(&CRC_32_ISCSI);
    let mut digest = checksum.digest();
    outcomes.iter().for_each(|outcome| digest.update(&outcome.digest.to_le_bytes()));
    digest.finalize()
}
