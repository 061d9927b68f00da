//! Why frames do not go into classic CAN frames, or come out of them.

use super::{MOST_CYCLES, MOST_VALUES, largest_count};
use crate::wire::{DecodeError, EncodeError};

/// Why a compact form cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum InvalidCompact {
    /// Two kinds of frame share an identifier.
    Identifiers,
    /// A step is not positive, a value on the grid is not finite, or a frame has no room for the grid's largest count, see
    /// [`super::largest_count`].
    Grid,
}

impl core::fmt::Display for InvalidCompact {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Identifiers => "two kinds of frame share a CAN identifier",
            Self::Grid => {
                "a step that is not positive, or so large that values are not finite; or counts beyond a frame's room"
            }
        })
    }
}

impl core::error::Error for InvalidCompact {}

/// Why a frame does not go into a classic CAN frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PackError {
    /// The bytes are no frame of this loop.
    Decode(DecodeError),
    /// A measurement or a sequence of no value, or of more than [`MOST_VALUES`]; holds the number found.
    Values(usize),
    /// So many values whose grid has larger counts than their frame has room for, see [`super::largest_count`].
    Counts(usize),
    /// An acknowledgement of more than [`MOST_CYCLES`]; holds the number found.
    Cycles(usize),
    /// A clock frame whose period, in microseconds, does not fit.
    Period(u32),
    /// The driver's type takes no frame of this identifier and length.
    Refused,
}

impl core::fmt::Display for PackError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Decode(reason) => reason.fmt(f),
            Self::Values(found) => {
                write!(f, "a frame of {found} values; a classic CAN frame carries 1 to {MOST_VALUES}")
            }
            Self::Counts(found) => write!(
                f,
                "a frame of {found} values, each up to {} counts; the grid has larger ones",
                largest_count(*found)
            ),
            Self::Cycles(found) => {
                write!(f, "an acknowledgement of {found} cycles; a classic CAN frame carries {MOST_CYCLES}")
            }
            Self::Period(found) => {
                write!(
                    f,
                    "a clock frame with a period of {found} us; on a classic CAN bus it may have 8388607"
                )
            }
            Self::Refused => f.write_str("the CAN driver's frame type takes no such frame"),
        }
    }
}

impl core::error::Error for PackError {}

/// Why a classic CAN frame is no frame of this loop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum UnpackError {
    /// Its identifier is none of this loop's.
    Identifier,
    /// A remote frame: it carries no data.
    Remote,
    /// So many bytes of data do not belong to a frame of this identifier.
    Length(usize),
    /// The check does not fit: damaged, or of another plant, kind or time.
    Check,
    /// A count beyond the grid's largest, as -32768 always is; or a bit that is set and stands for nothing.
    Count,
    /// The full frame could not be written.
    Encode(EncodeError),
}

impl core::fmt::Display for UnpackError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Identifier => f.write_str("a CAN identifier that is none of this loop's"),
            Self::Remote => f.write_str("a remote frame"),
            Self::Length(found) => write!(f, "{found} bytes of data, not what this identifier comes with"),
            Self::Check => f.write_str(
                "the check does not fit: a frame that is damaged, or of another plant, kind or time",
            ),
            Self::Count => f.write_str("a count beyond the grid's largest"),
            Self::Encode(reason) => reason.fmt(f),
        }
    }
}

impl core::error::Error for UnpackError {}
