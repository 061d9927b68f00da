//! `RawFrame`: bytes that are taken apart, but not yet believed.
//!
//! The one place where a frame is cut into header, payload and checksum.

use super::{VERSION, envelope::Kind};
use crate::{Tick, checksum::checksum};

/// Bytes of the checksum, at the end of a frame.
pub(super) const CHECKSUM_LEN: usize = 4;
/// Bytes before the payload.
pub(super) const HEADER_LEN: usize = 7;

/// Bytes that are as long as a frame is at least. Nothing in them has been checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawFrame<'f> {
    bytes: &'f [u8],
    header: &'f [u8; HEADER_LEN],
    payload: &'f [u8],
    checksum: &'f [u8; CHECKSUM_LEN],
}

impl<'f> RawFrame<'f> {
    /// The parts of `bytes`; `None` if they are shorter than header and checksum.
    #[inline]
    pub fn of(bytes: &'f [u8]) -> Option<Self> {
        let (header, rest) = bytes.split_first_chunk()?;
        let (payload, checksum) = rest.split_last_chunk()?;
        Some(Self { bytes, header, payload, checksum })
    }

    /// All of it.
    #[inline]
    pub fn bytes(&self) -> &'f [u8] {
        self.bytes
    }

    /// The version it says it has.
    #[inline]
    pub fn version(&self) -> u8 {
        self.header[0]
    }

    /// Whether it is of the version that is spoken here.
    #[inline]
    pub fn is_of_this_version(&self) -> bool {
        self.version() == VERSION
    }

    /// The number of the kind it says it is.
    #[inline]
    pub fn kind_number(&self) -> u8 {
        self.header[1]
    }

    /// The kind it says it is; `None` if there is no such kind.
    #[inline]
    pub fn kind(&self) -> Option<Kind> {
        Kind::numbered(self.kind_number())
    }

    /// Bytes of each of its numbers, as it says.
    #[inline]
    pub fn scalar_bytes(&self) -> u8 {
        self.header[2]
    }

    /// The cycle it says it is about.
    #[inline]
    pub fn tick(&self) -> Tick {
        let [_, _, _, tick @ ..] = *self.header;
        Tick(u32::from_le_bytes(tick))
    }

    /// What is between header and checksum.
    #[inline]
    pub fn payload(&self) -> &'f [u8] {
        self.payload
    }

    /// Whether the checksum fits.
    #[inline]
    pub fn is_whole(&self) -> bool {
        let content = self.bytes.get(..HEADER_LEN + self.payload.len()).unwrap_or_default();
        checksum(content) == u32::from_le_bytes(*self.checksum)
    }
}
