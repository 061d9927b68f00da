//! The check of compact frames, after AUTOSAR's E2E profile 1: a CRC-8 that also covers what is not sent.
//!
//! Not sent are the number of the form, the id of the design, the kind of frame and the upper half of the tick. A frame of
//! another form, plant or kind, or of another round of the lower half, fails like a damaged one. The lower half of the tick is the alive counter.
//!
//! The polynomial is that of SAE J1850, 0x1D, which profile 1 has. The other one of AUTOSAR, 0x2F of profile 2, is divisible by
//! `x + 1`, as is that of CAN's own CRC: half of what the bus does not see would be right for it too.

use crate::{Tick, identity::DesignId, wire::envelope::Kind};
use crc::{CRC_8_SAE_J1850, Crc};

/// A static, so that its table of 256 bytes is there once.
static CRC_8: Crc<u8> = Crc::<u8>::new(&CRC_8_SAE_J1850);

/// The number of the form. The first one had no check.
pub const FORM: u8 = 2;

/// The check of one loop's frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Check {
    design: DesignId,
}

impl Check {
    /// The check of the loop with the plant of `design`.
    pub const fn new(design: DesignId) -> Self {
        Self { design }
    }

    /// CRC-8/SAE-J1850 over [`FORM`] (1 byte), the id of the design (4), the number of the kind (1), the upper half of the
    /// tick (2), and then `data`: all that is sent but the check itself, which follows it.
    ///
    /// What is not sent goes in with its highest byte first, in the order of the polynomial: ids or ticks that differ within
    /// eight bits in a row never have the same check, nor do ticks that are any power of two apart.
    pub fn of(&self, kind: Kind, tick: Tick, data: &[u8]) -> u8 {
        let mut digest = CRC_8.digest();
        digest.update(&[FORM]);
        digest.update(&self.design.0.to_be_bytes());
        digest.update(&[kind as u8]);
        digest.update(&((tick.0 >> 16) as u16).to_be_bytes());
        digest.update(data);
        digest.finalize()
    }
}
