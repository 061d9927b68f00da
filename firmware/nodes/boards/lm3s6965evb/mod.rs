//! Stellaris LM3S6965 evaluation board: Cortex-M3 without floating-point unit, PL011 UARTs. UART 0 is the line to the host,
//! UART 1 takes the log.
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

/// Cycles of the processor in a second: the internal oscillator, as after reset.
pub(crate) const CORE_HZ: u32 = 12_000_000;
/// Number of the line's interrupt.
pub(crate) const INTERRUPTS: &[u16] = &[5];

/// The line to the host.
// SAFETY: UART 0 of this board, which nothing else uses.
pub(crate) const LINE: Uart = Uart { registers: unsafe { Registers::at(0x4000_c000) }, layout: PL011 };
/// The log.
// SAFETY: UART 1 likewise.
pub(crate) const LOG: Uart = Uart { registers: unsafe { Registers::at(0x4000_d000) }, layout: PL011 };
/// The watchdog.
// SAFETY: the watchdog likewise.
pub(crate) const WATCHDOG: Watchdog = Watchdog(unsafe { Registers::at(0x4000_0000) });
/// Stands for memory that outlives power, of which the board has none: the last page of the RAM, which the emulator fills.
#[cfg(feature = "authentication")]
// SAFETY: memory that the linker's map leaves out.
pub(crate) const KEPT: Registers = unsafe { Registers::at(0x2000_f000) };
// SAFETY: port A likewise.
const PORT_A: Registers = unsafe { Registers::at(0x4000_4000) };
// SAFETY: the system control likewise.
const SYSTEM: Registers = unsafe { Registers::at(0x400f_e000) };

const PL011: Layout =
    Layout { data: 0x0, state: 0x18, transmit_full: 1 << 5, receive: RECEIVE_EMPTY, received: 0 };
const RECEIVE_EMPTY: u32 = 1 << 4;
/// Clock gates: watchdog, UARTs, ports.
const CLOCK_GATES: [(usize, u32); 3] = [(0x100, 1 << 3), (0x104, 0b11), (0x108, 0b1001)];
// Registers of a UART, and their bits.
const DIVIDER: usize = 0x24;
const DIVIDER_FRACTION: usize = 0x28;
const FORMAT: usize = 0x2c;
const CONTROL: usize = 0x30;
const INTERRUPT_MASK: usize = 0x38;
const INTERRUPT_CLEAR: usize = 0x44;
const EIGHT_BITS: u32 = 0b11 << 5;
const RECEIVE_INTERRUPT: u32 = 1 << 4;
const TRANSMIT_INTERRUPT: u32 = 1 << 5;
/// UART, transmitter, receiver on.
const ON: u32 = 1 | 1 << 8 | 1 << 9;

/// Sets up clocks, pins and both UARTs.
pub(crate) fn start() {
    for (gate, bits) in CLOCK_GATES {
        SYSTEM.write(gate, SYSTEM.read(gate) | bits);
    }
    // Pins 0 and 1 of port A: alternate function, digital. Those of UART 1, on port D, stay as they are without a log cable.
    PORT_A.write(0x420, 0b11);
    PORT_A.write(0x51c, 0b11);
    for Uart { registers, .. } in [LINE, LOG] {
        // 12 MHz / 16 / 6.5 = 115 200 bit/s.
        registers.write(DIVIDER, 6);
        registers.write(DIVIDER_FRACTION, 33);
        registers.write(FORMAT, EIGHT_BITS);
        registers.write(CONTROL, ON);
    }
    LINE.registers.write(INTERRUPT_MASK, RECEIVE_INTERRUPT | TRANSMIT_INTERRUPT);
}

/// Tells the line's interrupts that they have been seen.
pub(crate) fn clear_interrupts() {
    LINE.registers.write(INTERRUPT_CLEAR, RECEIVE_INTERRUPT | TRANSMIT_INTERRUPT);
}
