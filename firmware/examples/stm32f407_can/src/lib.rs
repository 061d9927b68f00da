//! The two ends of the loop on a real CAN bus: an STM32F407, for example on the STM32F4 Discovery board, and a CAN
//! transceiver.
//!
//! | file | what lives there |
//! |---|---|
//! | `bus` | identifiers, bit timing and filters |
//! | `part` | clocks, pins, cycle timer, watchdog |
//! | `output` | the plant's input as a voltage |
//! | `program` | the main loop, and what the node sees of the part |
//! | `failure` | what is left when the program fails |
//!
//! What frames are on the bus is `slqg_nodes::can`'s, drivers are `stm32f4xx-hal`'s and `bxcan`'s. The design is one with
//! `wire.format = "can-classic"` and one input; `docs/can.md` says how to build and wire it.
//!
//! **It has not run on the part.** Every check of the project builds it; no emulator here has the part's CAN controller.
//! Before it drives a plant: see that the bit rate is right, that the output goes to zero when the bus is cut, and that the
//! watchdog bites.
#![no_std]
#![deny(unsafe_code)]

mod bus;
mod failure;
mod output;
mod part;
pub mod program;
