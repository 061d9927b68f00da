//! [`Carrier`]: frames of the loop as a CAN bus carries them, for the bits that are on the simulated bus.
//!
//! The two ends exchange full frames, whose packing and unpacking are without loss ([`slqg::wire::can`]); outputs are
//! rounded before they are sent. A size class pads frames with inputs and outputs that the design does not have, so what is
//! on the bus is cut to the length that the design's frames have.

use embedded_can::{Frame, Id, StandardId};
use slqg::{
    Scalar, Tick,
    blob::DesignId,
    wire::{
        Kind,
        can::{Check, Compact, FD_CAPACITY, Grid, Identifiers, pad},
    },
};
use slqg_links::loop_bus::Role;

/// How frames are packed.
#[derive(Debug, Clone)]
pub struct Carrier<T, const NU: usize, const NY: usize> {
    /// The compact form; `None`: full frames in CAN FD.
    compact: Option<(Compact<T, NU, NY>, Check)>,
    /// Bytes on the bus by role.
    lengths: [usize; Role::COUNT],
}

impl<T: Scalar, const NU: usize, const NY: usize> Carrier<T, NU, NY> {
    /// Full frames in CAN FD, or compact ones on these grids of inputs and outputs. `design`: whose frames they are; `lengths`:
    /// bytes on the bus, by role.
    pub fn new(
        design: DesignId,
        grids: Option<(Grid<T, NU>, Grid<T, NY>)>,
        lengths: [usize; Role::COUNT],
    ) -> Self {
        // Which is which is decided beside the payload, so any identifiers do.
        let id = |value| Id::Standard(StandardId::new(value).unwrap_or(StandardId::ZERO));
        let identifiers = Identifiers { measurement: id(1), control: id(2), acknowledgement: id(3) };
        let compact =
            grids.and_then(|(inputs, outputs)| Compact::new(design, identifiers, inputs, outputs).ok());
        let compact = compact.map(|compact| (compact, Check::new(design)));
        Self { compact, lengths }
    }

    /// What is on the bus for the full frame `frame`.
    pub fn payload(&self, role: Role, frame: &[u8]) -> Vec<u8> {
        let len = self.lengths[role as usize];
        let Some((compact, check)) = &self.compact else {
            let mut buffer = [0; FD_CAPACITY];
            let mut payload = pad(frame, &mut buffer).map_or_else(|| frame.to_vec(), <[u8]>::to_vec);
            payload.resize(len, 0);
            return payload;
        };
        // A padded frame may have too many values for the compact form; its first bytes stand in for it.
        let mut payload = compact.pack::<Packed>(frame).map_or_else(|_| frame.to_vec(), |packed| packed.0);
        if payload.len() != len
            && let (Some(kind), &[_, _, _, a, b, c, d, ..]) = (Kind::of(frame), frame)
        {
            // Cut: the check goes where it is in a frame of the design's length.
            payload.resize(len.saturating_sub(1), 0);
            payload.push(check.of(kind, Tick(u32::from_le_bytes([a, b, c, d])), &payload));
        }
        payload
    }
}

/// The data of a classic frame.
struct Packed(Vec<u8>);

impl Frame for Packed {
    fn new(_: impl Into<Id>, data: &[u8]) -> Option<Self> {
        (data.len() <= 8).then(|| Self(data.to_vec()))
    }

    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        false
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> Id {
        Id::Standard(StandardId::ZERO)
    }

    fn dlc(&self) -> usize {
        self.0.len()
    }

    fn data(&self) -> &[u8] {
        &self.0
    }
}
