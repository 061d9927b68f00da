//! Why bytes are no gains, and why gains are no bytes.

use super::{DesignId, VERSION};
use crate::gains::InvalidGains;

/// Why bytes are not the gains that were expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BlobError {
    /// Fewer bytes than header and checksum take.
    TooShort,
    /// The checksum does not fit: damaged, cut off, or no blob at all.
    Checksum,
    /// It does not begin with [`super::MAGIC`].
    Magic,
    /// Written in another version of this format.
    Version(u8),
    /// Numbers of another scalar type, or of none; holds the bytes per scalar found.
    Scalar(u8),
    /// A default input that does not exist; holds the code found.
    DefaultInput(u8),
    /// The tables are shorter or longer than the dimensions say.
    Length,
    /// Gains of another design; holds its id.
    Design(DesignId),
    /// Gains for another number of states; holds the number found.
    States(u16),
    /// Gains for another number of inputs; holds the number found.
    Inputs(u16),
    /// Gains for sequences of another length, or for another default input.
    Sequence,
    /// The caller's storage is shorter than the tables.
    StorageTooSmall {
        /// Scalars that the tables take.
        needed: usize,
    },
    /// The numbers are no gains.
    Gains(InvalidGains),
}

impl core::fmt::Display for BlobError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooShort => f.write_str("shorter than header and checksum"),
            Self::Checksum => f.write_str("checksum does not fit"),
            Self::Magic => f.write_str("not gains: does not begin with \"slqg\""),
            Self::Version(found) => write!(f, "blob version {found}, this loader reads {VERSION}"),
            Self::Scalar(found) => write!(f, "{found} bytes per scalar, not what this loader computes in"),
            Self::DefaultInput(found) => write!(f, "no default input has the code {found}"),
            Self::Length => f.write_str("tables shorter or longer than the dimensions say"),
            Self::Design(found) => write!(f, "gains of design {found}, not of the one expected"),
            Self::States(found) => write!(f, "gains for {found} states, not this loader's number"),
            Self::Inputs(found) => write!(f, "gains for {found} inputs, not this loader's number"),
            Self::Sequence => f.write_str("gains for sequences of another length or another default input"),
            Self::StorageTooSmall { needed } => write!(f, "the tables take storage for {needed} numbers"),
            Self::Gains(reason) => reason.fmt(f),
        }
    }
}

impl core::error::Error for BlobError {}

/// Why gains cannot be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EncodeError {
    /// A dimension is larger than the format has room for.
    TooLarge,
    /// The tables are no gains of this shape.
    Gains(InvalidGains),
    /// The caller's buffer is shorter than [`super::encoded_len`].
    BufferTooSmall,
}

impl core::fmt::Display for EncodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooLarge => {
                f.write_str("more than 255 inputs per sequence, or more than 65535 states or inputs")
            }
            Self::Gains(reason) => reason.fmt(f),
            Self::BufferTooSmall => f.write_str("the buffer is shorter than the blob"),
        }
    }
}

impl core::error::Error for EncodeError {}

impl From<InvalidGains> for EncodeError {
    fn from(reason: InvalidGains) -> Self {
        Self::Gains(reason)
    }
}
