//! Why a sequence or a frame changed nothing.

use crate::wire;

/// Why a sequence did not enter the buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RejectedSequence {
    /// It is not newer than the buffered one: past-packet rejection, thesis 3.1.
    Past,
    /// Its last input was meant for a cycle that is over.
    RunOut,
    /// It was made in a cycle that has not begun: the two ends' ticks disagree.
    Future,
    /// It holds a number that is not finite.
    NotFinite,
    /// It holds no input.
    NoInputs,
    /// It holds more inputs than the actuator has room for.
    TooLong,
    /// The actuator's memory has changed by itself: it takes nothing any more.
    Memory,
}

impl core::fmt::Display for RejectedSequence {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Past => "a sequence not newer than the one in the buffer",
            Self::RunOut => "a sequence whose last input was meant for a cycle that is over",
            Self::Future => {
                "a sequence made in a cycle that has not begun: the clocks of the two ends disagree"
            }
            Self::NotFinite => "a sequence with a number that is not finite",
            Self::NoInputs => "a sequence of no input",
            Self::TooLong => "a sequence of more inputs than the actuator has memory for",
            Self::Memory => "a sequence for an actuator whose memory has changed by itself",
        })
    }
}

impl core::error::Error for RejectedSequence {}

/// Why a frame changed nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RejectedFrame {
    /// The bytes are not a control frame for this actuator.
    Decode(wire::DecodeError),
    /// The sequence in it is of no use.
    Sequence(RejectedSequence),
}

impl core::fmt::Display for RejectedFrame {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Decode(why) => why.fmt(f),
            Self::Sequence(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for RejectedFrame {}
