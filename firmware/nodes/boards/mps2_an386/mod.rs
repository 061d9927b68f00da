//! Arm MPS2 with the AN386 image: Cortex-M4F, CMSDK peripherals. UART 0 is the line to the host, UART 1 takes the log.
#![allow(unsafe_code)]

use core::ptr::without_provenance_mut;

/// Cycles of the processor in a second.
pub(crate) const CORE_HZ: u32 = 25_000_000;
/// Numbers of the line's interrupts: received, transmitted.
pub(crate) const INTERRUPTS: &[u16] = &[0, 1];

const LINE: usize = 0x4000_4000;
const LOG: usize = 0x4000_5000;
const WATCHDOG: usize = 0x4000_8000;
// Registers of a UART, and their bits.
const DATA: usize = 0x0;
const STATE: usize = 0x4;
const CONTROL: usize = 0x8;
const PENDING: usize = 0xc;
const DIVIDER: usize = 0x10;
const TRANSMIT_FULL: u32 = 1 << 0;
const RECEIVE_FULL: u32 = 1 << 1;
const TRANSMIT: u32 = 1 << 0;
const RECEIVE: u32 = 1 << 1;
const TRANSMIT_INTERRUPT: u32 = 1 << 2;
const RECEIVE_INTERRUPT: u32 = 1 << 3;
/// 1.56 Mbit/s, the fastest it does.
const LINE_DIVIDER: u32 = 16;

fn read(address: usize) -> u32 {
    // SAFETY: the addresses of this file are registers of this board, which only this file uses.
    unsafe { without_provenance_mut::<u32>(address).read_volatile() }
}

fn write(address: usize, value: u32) {
    // SAFETY: as above; any value may be written to them.
    unsafe { without_provenance_mut::<u32>(address).write_volatile(value) }
}

/// Sets up both UARTs.
pub(crate) fn start() {
    write(LINE + DIVIDER, LINE_DIVIDER);
    write(LINE + CONTROL, TRANSMIT | RECEIVE | TRANSMIT_INTERRUPT | RECEIVE_INTERRUPT);
    write(LOG + DIVIDER, LINE_DIVIDER);
    write(LOG + CONTROL, TRANSMIT);
}

/// A byte that has come over the line.
pub(crate) fn receive() -> Option<u8> {
    (read(LINE + STATE) & RECEIVE_FULL != 0).then(|| read(LINE + DATA) as u8)
}

/// Puts a byte on the line; false while there is no room.
pub(crate) fn transmit(byte: u8) -> bool {
    put(LINE, byte)
}

/// Tells the line's interrupts that they have been seen.
pub(crate) fn clear_interrupts() {
    write(LINE + PENDING, TRANSMIT | RECEIVE);
}

/// Puts a byte into the log, once there is room.
pub(crate) fn log(byte: u8) {
    while !put(LOG, byte) {}
}

fn put(uart: usize, byte: u8) -> bool {
    let has_room = read(uart + STATE) & TRANSMIT_FULL == 0;
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
