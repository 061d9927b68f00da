//! Frames as bytes: measurement, control, acknowledgement; and those between a node and its host, `service`.
//!
//! Version 1, little-endian throughout; `docs/wire-format.md` is the normative page.
//!
//! ```text
//! byte 0      version, 1
//! byte 1      kind, see [`Kind`]
//! byte 2      bytes per scalar: 4 (f32) or 8 (f64)
//! bytes 3-6   tick the frame is about
//! bytes 7-    payload
//! last 4      CRC-32/ISCSI over everything before
//! ```
//!
//! Nothing decoded is used before it is checked: checksum first, then version, kind, scalar, dimensions,
//! length, and that every number is finite. Decoding never panics, whatever the bytes are. How frames are
//! carried over UDP is not known here; carriers that ask for more have rooms of their own: a line of bytes without frames
//! [`serial`], one whose frames are too short for these, or of fixed lengths, [`can`].
//!
//! ```
//! use slqg::nalgebra::Vector1;
//! use slqg::wire::{DecodeError, Measurement, decode_measurement, encode_measurement, measurement_len};
//! use slqg::Tick;
//!
//! let measurement = Measurement { tick: Tick(7), output: Vector1::new(1.5_f32) };
//! let mut buffer = [0; measurement_len(1, 4)];
//! let frame = encode_measurement(&measurement, &mut buffer).expect("there is room");
//! assert_eq!(frame[..8], [1, 1, 4, 7, 0, 0, 0, 1]);
//! assert_eq!(decode_measurement(frame), Ok(measurement));
//! assert_eq!(decode_measurement::<f32, 1>(&frame[1..]), Err(DecodeError::Checksum));
//! ```

pub mod can;
mod envelope;
mod length;
mod payload;
mod raw;
pub mod serial;
mod service;

pub use envelope::Kind;
pub use length::frame_len;
pub use payload::{
    Acknowledgement, MOST_AGES, Measurement, decode_acknowledgement, decode_control, decode_measurement,
    encode_acknowledgement, encode_control, encode_measurement,
};
pub use raw::RawFrame;
pub use service::{
    Clock, GainsAnswer, GainsPart, Question, Ran, Reference, Role, Service, Status, Tuned, TuningStep,
    Verdict, decode_applied, decode_gains_part, decode_reference, decode_service, encode_applied,
    encode_gains_part, encode_reference, encode_service,
};

/// Version of the frame layout, the first byte of every frame.
pub const VERSION: u8 = 1;

/// Bytes around a payload: header and checksum.
pub const OVERHEAD: usize = raw::HEADER_LEN + raw::CHECKSUM_LEN;

/// Bytes of the longest acknowledgement frame, that of [`MOST_AGES`] cycles.
pub const LONGEST_ACKNOWLEDGEMENT: usize = acknowledgement_len(MOST_AGES);

/// Bytes of a frame about what was applied, of `inputs` scalars of `scalar_bytes` each.
pub const fn applied_len(inputs: usize, scalar_bytes: u8) -> usize {
    OVERHEAD + 2 + inputs * scalar_bytes as usize
}

/// Bytes of a frame of `samples` reference samples of `outputs` scalars of `scalar_bytes` each.
pub const fn reference_len(outputs: usize, samples: usize, scalar_bytes: u8) -> usize {
    OVERHEAD + 2 + outputs * samples * scalar_bytes as usize
}

/// Bytes of a frame with `bytes` bytes of a blob.
pub const fn gains_part_len(bytes: usize) -> usize {
    OVERHEAD + 4 + bytes
}

/// Bytes of the longest other frame between a node and its host: its status.
pub const LONGEST_SERVICE: usize = OVERHEAD + service::LONGEST;

/// Bytes of a measurement frame of `outputs` scalars of `scalar_bytes` each.
pub const fn measurement_len(outputs: usize, scalar_bytes: u8) -> usize {
    OVERHEAD + 1 + outputs * scalar_bytes as usize
}

/// Bytes of a control frame of `length` inputs of `inputs` scalars of `scalar_bytes` each.
pub const fn control_len(inputs: usize, length: usize, scalar_bytes: u8) -> usize {
    OVERHEAD + 2 + inputs * length * scalar_bytes as usize
}

/// Bytes of an acknowledgement frame about `ages` cycles.
pub const fn acknowledgement_len(ages: usize) -> usize {
    OVERHEAD + ages
}

/// Why bytes are not the frame that was expected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DecodeError {
    /// Fewer bytes than header and checksum take.
    TooShort,
    /// The checksum does not fit: damaged on the way.
    Checksum,
    /// Made by another version of this format.
    Version(u8),
    /// Another kind of frame.
    Kind(u8),
    /// Numbers of another scalar type; holds the bytes per scalar found.
    Scalar(u8),
    /// Vectors of another dimension than the receiver's; holds the dimension found.
    Dimension(u8),
    /// More inputs than the receiver has room for; holds the number found.
    Capacity(u8),
    /// An acknowledgement of no cycle or of more than [`MOST_AGES`]; holds the number found, 255 for any beyond.
    Ages(u8),
    /// The payload is shorter or longer than it says.
    Length,
    /// A field with a value that it cannot have: a flag that is neither 0 nor 1, a word of a list that nobody knows.
    Value,
    /// A number that is not finite.
    NotFinite,
}

impl core::fmt::Display for DecodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooShort => f.write_str("frame shorter than header and checksum"),
            Self::Checksum => f.write_str("checksum does not fit"),
            Self::Version(found) => write!(f, "frame version {found}, this receiver speaks {VERSION}"),
            Self::Kind(found) => write!(f, "unexpected frame kind {found}"),
            Self::Scalar(found) => write!(f, "{found} bytes per scalar, not what this receiver computes in"),
            Self::Dimension(found) => write!(f, "vectors of dimension {found}, not this receiver's"),
            Self::Capacity(found) => write!(f, "{found} inputs, more than this receiver's capacity"),
            Self::Ages(found) => write!(f, "an acknowledgement of {found} cycles, not of 1 to {MOST_AGES}"),
            Self::Length => f.write_str("payload shorter or longer than it says"),
            Self::Value => f.write_str("a field with a value that it cannot have"),
            Self::NotFinite => f.write_str("a number that is not finite"),
        }
    }
}

impl core::error::Error for DecodeError {}

/// Why a frame could not be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EncodeError {
    /// The caller's buffer is shorter than the frame.
    BufferTooSmall,
    /// A dimension or a count does not fit the one byte it has on the wire.
    TooMany,
    /// An acknowledgement of no cycle.
    NoAges,
}

impl core::fmt::Display for EncodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::BufferTooSmall => "the buffer is shorter than the frame",
            Self::TooMany => "more than 255 values of a kind",
            Self::NoAges => "an acknowledgement of no cycle",
        })
    }
}

impl core::error::Error for EncodeError {}
