//! Arm's watchdog SP805, which both boards have.

use super::registers::Registers;

const LOAD: usize = 0x0;
const CONTROL: usize = 0x8;
const INTERRUPT_CLEAR: usize = 0xc;
const INTERRUPT: u32 = 1 << 0;
const RESET: u32 = 1 << 1;

/// The watchdog.
pub(crate) struct Watchdog(pub(crate) Registers);

impl Watchdog {
    /// Resets the board unless [`Watchdog::feed`] is called in every `cycles` of the processor, and a second time as many.
    pub(crate) fn start(&self, cycles: u32) {
        self.0.write(LOAD, cycles);
        self.0.write(CONTROL, INTERRUPT | RESET);
    }

    /// Tells the watchdog that the program runs.
    pub(crate) fn feed(&self) {
        self.0.write(INTERRUPT_CLEAR, 1);
    }
}
