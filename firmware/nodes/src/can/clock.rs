//! The clock in one classic CAN frame, and back.
//!
//! ```text
//! bytes 0-3   tick, little-endian
//! bytes 4-7   u32, little-endian: bits 0-30 period in microseconds, bit 31 set if the cycle begins now
//! ```
//!
//! The whole tick: a node that has just started knows no cycle that a half could be near.

use embedded_can::{Frame, Id};
use slqg::{
    Tick,
    wire::{Clock, can::UnpackError},
};

const BEGINS: u32 = 1 << 31;
const LONGEST_PERIOD: u32 = BEGINS - 1;

/// The CAN frame; `None` if the driver's type takes none of eight bytes. A period of more than 2^31 - 1 microseconds, 35
/// minutes, becomes that.
pub(super) fn pack<F: Frame>(id: Id, tick: Tick, clock: Clock) -> Option<F> {
    let begins = if clock.begins { BEGINS } else { 0 };
    let rest = begins | clock.period_us.min(LONGEST_PERIOD);
    let mut data = [0; 8];
    data[..4].copy_from_slice(&tick.0.to_le_bytes());
    data[4..].copy_from_slice(&rest.to_le_bytes());
    F::new(id, &data)
}

/// What a CAN frame with the identifier of the clock says.
pub(super) fn unpack<F: Frame>(frame: &F) -> Result<(Tick, Clock), UnpackError> {
    if frame.is_remote_frame() {
        return Err(UnpackError::Remote);
    }
    let &[a, b, c, d, e, f, g, h] = frame.data() else {
        return Err(UnpackError::Length(frame.data().len()));
    };
    let rest = u32::from_le_bytes([e, f, g, h]);
    let clock = Clock { begins: rest & BEGINS != 0, period_us: rest & LONGEST_PERIOD };
    Ok((Tick(u32::from_le_bytes([a, b, c, d])), clock))
}
