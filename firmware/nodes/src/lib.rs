//! The two ends of the loop as programs for microcontrollers.
//!
//! | file | what lives there |
//! |---|---|
//! | `controller` | the controller node: frames from its host in, frames out |
//! | `actuator` | the actuator node likewise, and when it goes to its safe state |
//! | `laws/` | where gains come from beside the design: over the link, or solved for on the device |
//! | `clock` | which cycle a node is in, and who begins the next one |
//! | `reference` | samples of the reference that are known ahead |
//! | `can` | a node's line over a CAN bus, through the traits of `embedded-can` |
//! | `board` | what node and board need of each other |
//! | `guarded` | a node whose frames are sealed, with the feature `authentication` |
//! | `front` | what stands between a board's line and its node: a guard or nothing |
//! | `health` | what a node tells of itself |
//! | `boards/` | a folder for each board, and the peripherals that several have: UART, watchdog, memory |
//! | `program` | the main loop on a board: interrupts, queues, timer; and what is left when it fails |
//! | `bulk` | the same over files of a debugger, for long runs in an emulator |
//! | `memory` | how much stack and RAM the program has used |
//! | `log` | log messages over the board's second UART, in defmt's format |
//!
//! The control law, the estimator, the actuator and the frames are the crate `slqg`'s; nothing of them is here. Design and
//! board are chosen when the nodes are built, see `build.rs`. On the host, and for boards that other
//! crates have (`firmware/examples`), everything but the boards compiles.
#![no_std]
#![deny(unsafe_code)]

pub mod actuator;
pub mod board;
pub mod can;
pub mod clock;
pub mod controller;
#[cfg(board)]
pub mod front;
#[cfg(feature = "authentication")]
pub mod guarded;
mod health;
pub mod laws;
mod reference;

#[cfg(board)]
pub mod bulk;
#[cfg(board)]
mod log;
#[cfg(board)]
mod memory;
#[cfg(board)]
pub mod program;

#[cfg(board = "lm3s6965evb")]
#[path = "../boards/lm3s6965evb/mod.rs"]
mod hardware;
#[cfg(board = "mps2_an386")]
#[path = "../boards/mps2_an386/mod.rs"]
mod hardware;

/// The design that the nodes run, as `gain-gen` writes it.
#[allow(dead_code, unreachable_pub)]
pub mod design {
    include!(concat!(env!("OUT_DIR"), "/design.rs"));
}

/// What of the design a node must know beside it.
pub mod dimensions {
    include!(concat!(env!("OUT_DIR"), "/dimensions.rs"));
}
