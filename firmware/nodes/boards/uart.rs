//! Bytes through a UART that has one register for those of both ways, and another that tells whether there is room, or a byte:
//! so do those of both boards. Which registers these are, and how a UART is set up, is the board's to know.

use super::registers::Registers;

/// A UART.
pub(crate) struct Uart {
    /// Its registers.
    pub(crate) registers: Registers,
    /// Which are for what.
    pub(crate) layout: Layout,
}

/// What is where among a UART's registers.
pub(crate) struct Layout {
    /// Bytes, both ways.
    pub(crate) data: usize,
    /// The state.
    pub(crate) state: usize,
    /// Its bit that is set while there is no room.
    pub(crate) transmit_full: u32,
    /// Its bit that tells whether a byte has come.
    pub(crate) receive: u32,
    /// That bit when one has.
    pub(crate) received: u32,
}

impl Uart {
    /// A byte that has come.
    pub(crate) fn receive(&self) -> Option<u8> {
        let Self { registers, layout } = self;
        let has_come = registers.read(layout.state) & layout.receive == layout.received;
        has_come.then(|| registers.read(layout.data) as u8)
    }

    /// Sends a byte; false while there is no room.
    pub(crate) fn transmit(&self, byte: u8) -> bool {
        let Self { registers, layout } = self;
        let has_room = registers.read(layout.state) & layout.transmit_full == 0;
        if has_room {
            registers.write(layout.data, byte.into());
        }
        has_room
    }
}
