//! Registers of a peripheral: the one place where a board's addresses become accesses. Where a peripheral is and what its
//! registers mean is the board's to know.
#![allow(unsafe_code)]

use core::ptr::without_provenance_mut;

/// Bytes of the address space that a peripheral has to itself.
const SPAN: usize = 0x1000;

/// The registers of a peripheral, of 32 bits each.
#[derive(Clone, Copy)]
pub(crate) struct Registers(usize);

impl Registers {
    /// Those from `base` on.
    ///
    /// # Safety
    /// The 4 KiB from `base` on, a multiple of 4 KiB, belong to a peripheral of this board. Its registers may be read, and any
    /// value may be written to them, without changing memory that Rust knows of.
    pub(crate) const unsafe fn at(base: usize) -> Self {
        Self(base)
    }

    /// Reads the register `offset` bytes after the first one.
    pub(crate) fn read(self, offset: usize) -> u32 {
        // SAFETY: within the peripheral, which `at` was promised to be one.
        unsafe { self.address(offset).read_volatile() }
    }

    /// Writes to it.
    pub(crate) fn write(self, offset: usize, value: u32) {
        // SAFETY: as above; any value may be written.
        unsafe { self.address(offset).write_volatile(value) }
    }

    /// Whatever the offset, within the peripheral and aligned.
    fn address(self, offset: usize) -> *mut u32 {
        without_provenance_mut(self.0 + (offset % SPAN & !3))
    }
}
