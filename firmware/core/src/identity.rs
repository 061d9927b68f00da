//! [`DesignId`]: which plant gains and frames belong to.

use crate::checksum::checksum;

/// Which plant gains and frames belong to: a checksum of its numbers, see `docs/blob-format.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DesignId(pub u32);

impl DesignId {
    /// CRC-32/ISCSI of a design's canonical text.
    pub fn of(canonical: &[u8]) -> Self {
        Self(checksum(canonical))
    }
}

impl core::fmt::Display for DesignId {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:#010x}", self.0)
    }
}
