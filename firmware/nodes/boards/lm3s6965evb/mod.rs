//! Stellaris LM3S6965 evaluation board: Cortex-M3 without floating-point unit, PL011 UARTs. UART 0 is the line to the host,
//! UART 1 takes the log.
#![allow(unsafe_code)]

use core::ptr::without_provenance_mut;

/// Cycles of the processor in a second: the internal oscillator, as after reset.
pub(crate) const CORE_HZ: u32 = 12_000_000;
/// Number of the line's interrupt.
pub(crate) const INTERRUPTS: &[u16] = &[5];

const LINE: usize = 0x4000_c000;
const LOG: usize = 0x4000_d000;
const WATCHDOG: usize = 0x4000_0000;
const PORT_A: usize = 0x4000_4000;
/// Clock gates: watchdog, UARTs, ports.
const CLOCK_GATES: [(usize, u32); 3] = [(0x400f_e100, 1 << 3), (0x400f_e104, 0b11), (0x400f_e108, 0b1001)];
// Registers of a UART, and their bits.
const DATA: usize = 0x0;
const FLAGS: usize = 0x18;
const DIVIDER: usize = 0x24;
const DIVIDER_FRACTION: usize = 0x28;
const FORMAT: usize = 0x2c;
const CONTROL: usize = 0x30;
const INTERRUPT_MASK: usize = 0x38;
const INTERRUPT_CLEAR: usize = 0x44;
const RECEIVE_EMPTY: u32 = 1 << 4;
const TRANSMIT_FULL: u32 = 1 << 5;
const EIGHT_BITS: u32 = 0b11 << 5;
const RECEIVE_INTERRUPT: u32 = 1 << 4;
const TRANSMIT_INTERRUPT: u32 = 1 << 5;
/// UART, transmitter, receiver on.
const ON: u32 = 1 | 1 << 8 | 1 << 9;

fn read(address: usize) -> u32 {
    // SAFETY: the addresses of this file are registers of this board, which only this file uses.
    unsafe { without_provenance_mut::<u32>(address).read_volatile() }
}

fn write(address: usize, value: u32) {
    // SAFETY: as above; any value may be written to them.
    unsafe { without_provenance_mut::<u32>(address).write_volatile(value) }
}

/// Sets up clocks, pins and both UARTs.
pub(crate) fn start() {
    for (gate, bits) in CLOCK_GATES {
        write(gate, read(gate) | bits);
    }
    // Pins 0 and 1 of port A: alternate function, digital. Those of UART 1, on port D, stay as they are without a log cable.
    write(PORT_A + 0x420, 0b11);
    write(PORT_A + 0x51c, 0b11);
    for uart in [LINE, LOG] {
        // 12 MHz / 16 / 6.5 = 115 200 bit/s.
        write(uart + DIVIDER, 6);
        write(uart + DIVIDER_FRACTION, 33);
        write(uart + FORMAT, EIGHT_BITS);
        write(uart + CONTROL, ON);
    }
    write(LINE + INTERRUPT_MASK, RECEIVE_INTERRUPT | TRANSMIT_INTERRUPT);
}

/// A byte that has come over the line.
pub(crate) fn receive() -> Option<u8> {
    (read(LINE + FLAGS) & RECEIVE_EMPTY == 0).then(|| read(LINE + DATA) as u8)
}

/// Puts a byte on the line; false while there is no room.
pub(crate) fn transmit(byte: u8) -> bool {
    put(LINE, byte)
}

/// Tells the line's interrupts that they have been seen.
pub(crate) fn clear_interrupts() {
    write(LINE + INTERRUPT_CLEAR, RECEIVE_INTERRUPT | TRANSMIT_INTERRUPT);
}

/// Puts a byte into the log, once there is room.
pub(crate) fn log(byte: u8) {
    while !put(LOG, byte) {}
}

fn put(uart: usize, byte: u8) -> bool {
    let has_room = read(uart + FLAGS) & TRANSMIT_FULL == 0;
    if has_room {
        write(uart + DATA, byte.into());
    }
    has_room
}

/// Resets the board unless [`feed_watchdog`] is called in every `cycles` of the processor, and a second time as many.
pub(crate) fn start_watchdog(cycles: u32) {
    write(WATCHDOG, cycles);
    // Interrupt and reset.
    write(WATCHDOG + 0x8, 0b11);
}

/// Tells the watchdog that the program runs.
pub(crate) fn feed_watchdog() {
    write(WATCHDOG + 0xc, 1);
}
