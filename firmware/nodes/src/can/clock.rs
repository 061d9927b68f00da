//! The clock in one classic CAN frame, and back.
//!
//! ```text
//! bytes 0-3   tick, little-endian
//! bytes 4-6   u24, little-endian: bits 0-22 period in microseconds, bit 23 set if the cycle begins now
//! byte 7      check, as of the loop's other frames
//! ```
//!
//! The whole tick: a node that has just started knows no cycle that a half could be near.

use embedded_can::{Frame, Id};
use slqg::{
    Tick,
    wire::{
        Clock, Kind,
        can::{Check, PackError, UnpackError},
    },
};

const BEGINS: u32 = 1 << 23;
/// The longest period in microseconds, 8.4 s.
pub(super) const LONGEST_PERIOD: u32 = BEGINS - 1;

/// The CAN frame. A longer period than [`LONGEST_PERIOD`] is refused: a node that was told a shorter one would begin cycles by
/// itself.
pub(super) fn pack<F: Frame>(id: Id, check: Check, tick: Tick, clock: Clock) -> Result<F, PackError> {
    if clock.period_us > LONGEST_PERIOD {
        return Err(PackError::Period(clock.period_us));
    }
    let begins = if clock.begins { BEGINS } else { 0 };
    let [a, b, c, d] = tick.0.to_le_bytes();
    let [e, f, g, _] = (begins | clock.period_us).to_le_bytes();
    let data = [a, b, c, d, e, f, g, check.of(Kind::Clock, tick, &[a, b, c, d, e, f, g])];
    F::new(id, &data).ok_or(PackError::Refused)
}

/// What a CAN frame with the identifier of the clock says.
pub(super) fn unpack<F: Frame>(frame: &F, check: Check) -> Result<(Tick, Clock), UnpackError> {
    if frame.is_remote_frame() {
        return Err(UnpackError::Remote);
    }
    let &[a, b, c, d, e, f, g, told] = frame.data() else {
        return Err(UnpackError::Length(frame.data().len()));
    };
    let tick = Tick(u32::from_le_bytes([a, b, c, d]));
    if check.of(Kind::Clock, tick, &[a, b, c, d, e, f, g]) != told {
        return Err(UnpackError::Check);
    }
    let rest = u32::from_le_bytes([e, f, g, 0]);
    Ok((tick, Clock { begins: rest & BEGINS != 0, period_us: rest & LONGEST_PERIOD }))
}
