//! Arm MPS2 with the AN386 image: Cortex-M4F, CMSDK peripherals. UART 0 is the line to the host, UART 1 takes the log.
#![allow(unsafe_code)]

#[path = "../registers.rs"]
mod registers;
#[path = "../sp805.rs"]
mod sp805;
#[path = "../uart.rs"]
mod uart;

use registers::Registers;
use sp805::Watchdog;
use uart::{Layout, Uart};

/// Cycles of the processor in a second.
pub(crate) const CORE_HZ: u32 = 25_000_000;
/// Numbers of the line's interrupts: received, transmitted.
pub(crate) const INTERRUPTS: &[u16] = &[0, 1];

/// The line to the host.
// SAFETY: UART 0 of this board, which nothing else uses.
pub(crate) const LINE: Uart = Uart { registers: unsafe { Registers::at(0x4000_4000) }, layout: CMSDK };
/// The log.
// SAFETY: UART 1 likewise.
pub(crate) const LOG: Uart = Uart { registers: unsafe { Registers::at(0x4000_5000) }, layout: CMSDK };
/// The watchdog.
// SAFETY: the watchdog likewise.
pub(crate) const WATCHDOG: Watchdog = Watchdog(unsafe { Registers::at(0x4000_8000) });
/// Stands for memory that outlives power, of which the board has none: RAM behind that of the program, which the emulator fills.
#[cfg(feature = "authentication")]
// SAFETY: memory that the linker's map leaves out.
pub(crate) const KEPT: Registers = unsafe { Registers::at(0x2001_0000) };

const CMSDK: Layout =
    Layout { data: 0x0, state: 0x4, transmit_full: 1 << 0, receive: RECEIVE_FULL, received: RECEIVE_FULL };
const RECEIVE_FULL: u32 = 1 << 1;
// Registers of a UART, and their bits.
const CONTROL: usize = 0x8;
const PENDING: usize = 0xc;
const DIVIDER: usize = 0x10;
const TRANSMIT: u32 = 1 << 0;
const RECEIVE: u32 = 1 << 1;
const TRANSMIT_INTERRUPT: u32 = 1 << 2;
const RECEIVE_INTERRUPT: u32 = 1 << 3;
/// 1.56 Mbit/s, the fastest it does.
const LINE_DIVIDER: u32 = 16;

/// Sets up both UARTs.
pub(crate) fn start() {
    let (line, log) = (LINE.registers, LOG.registers);
    line.write(DIVIDER, LINE_DIVIDER);
    line.write(CONTROL, TRANSMIT | RECEIVE | TRANSMIT_INTERRUPT | RECEIVE_INTERRUPT);
    log.write(DIVIDER, LINE_DIVIDER);
    log.write(CONTROL, TRANSMIT);
}

/// Tells the line's interrupts that they have been seen.
pub(crate) fn clear_interrupts() {
    LINE.registers.write(PENDING, TRANSMIT | RECEIVE);
}
