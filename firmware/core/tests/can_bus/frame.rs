//! A classic CAN frame, as a driver would have it.

use embedded_can::{Frame, Id};

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
