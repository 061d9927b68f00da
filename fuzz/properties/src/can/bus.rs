//! A classic CAN frame, as a driver would have it, and the identifiers of a loop.

#[path = "../../../../firmware/core/tests/can_bus/frame.rs"]
mod frame;

use embedded_can::{ExtendedId, Id, StandardId};
use slqg::blob::DesignId;
use slqg::wire::Kind;
use slqg::wire::can::Identifiers;

pub(crate) use frame::BusFrame;

/// The plant that frames are of.
pub(crate) const DESIGN: DesignId = DesignId(0x1122_3344);
/// The kinds of frame, in the order of [`id`].
pub(crate) const KINDS: [Kind; 3] = [Kind::Measurement, Kind::Control, Kind::Acknowledgement];

/// The identifier of a kind of frame, and after these one that is nobody's.
pub(crate) fn id(which: usize) -> Id {
    match u16::try_from(which).ok().and_then(|which| StandardId::new(0x120 + which)) {
        Some(id) if which < KINDS.len() => Id::Standard(id),
        // The same number, but an extended one.
        _ => Id::Extended(ExtendedId::new(0x120).expect("29 bits")),
    }
}

pub(crate) fn identifiers() -> Identifiers {
    Identifiers { measurement: id(0), control: id(1), acknowledgement: id(2) }
}
