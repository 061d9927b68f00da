//! A classic CAN frame, as a driver would have it, and the identifiers of a loop.

use embedded_can::{ExtendedId, Frame, Id, StandardId};
use slqg::blob::DesignId;
use slqg::wire::Kind;
use slqg::wire::can::Identifiers;

/// The plant that frames are of.
pub(crate) const DESIGN: DesignId = DesignId(0x1122_3344);
/// The kinds of frame, in the order of [`id`].
pub(crate) const KINDS: [Kind; 3] = [Kind::Measurement, Kind::Control, Kind::Acknowledgement];

/// Whatever a bus may deliver: drivers differ in what they let through.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BusFrame {
    pub(crate) id: Id,
    pub(crate) is_remote: bool,
    pub(crate) data: Vec<u8>,
}

impl Frame for BusFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        (data.len() <= 8).then(|| Self { id: id.into(), is_remote: false, data: data.into() })
    }
    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        (dlc <= 8).then(|| Self { id: id.into(), is_remote: true, data: vec![0; dlc] })
    }
    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }
    fn is_remote_frame(&self) -> bool {
        self.is_remote
    }
    fn id(&self) -> Id {
        self.id
    }
    fn dlc(&self) -> usize {
        self.data.len()
    }
    fn data(&self) -> &[u8] {
        &self.data
    }
}

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
