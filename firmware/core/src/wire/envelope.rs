//! Header and checksum around a payload; what payloads mean is in `payload`.

use super::{DecodeError, EncodeError, VERSION};
use crate::{Scalar, Tick, checksum::CHECKSUM};
use serde::{Deserialize, Serialize};

pub(super) const CHECKSUM_LEN: usize = 4;
pub(super) const HEADER_LEN: usize = 7;

/// What a frame is; the second byte on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// What a sensor measured in one cycle.
    Measurement = 1,
    /// The inputs for one cycle and those after it.
    Control = 2,
    /// Where the input of one cycle came from, and of some before it.
    Acknowledgement = 3,
    /// A cycle begins.
    Clock = 4,
    /// What left the actuator in one cycle.
    Applied = 5,
    /// The controller has run a cycle.
    Ran = 6,
    /// A piece of a blob of gains.
    GainsPart = 7,
    /// How far a blob of gains has come.
    GainsAnswer = 8,
    /// Samples of the reference.
    Reference = 9,
    /// Asks a node how it is.
    Question = 10,
    /// How a node is.
    Status = 11,
    /// What a controller did that tunes itself.
    Tuned = 12,
}

impl Kind {
    const ALL: [Self; 12] = [
        Self::Measurement,
        Self::Control,
        Self::Acknowledgement,
        Self::Clock,
        Self::Applied,
        Self::Ran,
        Self::GainsPart,
        Self::GainsAnswer,
        Self::Reference,
        Self::Question,
        Self::Status,
        Self::Tuned,
    ];

    /// What a frame says it is, for whoever hands frames on; `None` if it is too short to say, or says something unknown.
    /// Nothing else of it is looked at: whoever decodes the frame checks all of it.
    pub fn of(frame: &[u8]) -> Option<Self> {
        let found = *frame.get(1)?;
        Self::ALL.into_iter().find(|kind| *kind as u8 == found)
    }
}

#[derive(Serialize, Deserialize)]
struct Header {
    version: u8,
    kind: u8,
    scalar_bytes: u8,
    tick: Tick,
}

/// Whether the last bytes of `frame` are the checksum of those before.
pub(super) fn checksum_fits(frame: &[u8]) -> bool {
    frame
        .split_last_chunk::<CHECKSUM_LEN>()
        .is_some_and(|(content, checksum)| CHECKSUM.checksum(content) == u32::from_le_bytes(*checksum))
}

/// Writes a frame front to back into a caller's buffer.
pub(super) struct Writer<'b> {
    buffer: &'b mut [u8],
    written: usize,
}

impl<'b> Writer<'b> {
    pub(super) fn new<T: Scalar>(buffer: &'b mut [u8], kind: Kind, tick: Tick) -> Result<Self, EncodeError> {
        let mut writer = Self { buffer, written: 0 };
        writer.put(&Header { version: VERSION, kind: kind as u8, scalar_bytes: T::BYTES, tick })?;
        Ok(writer)
    }

    pub(super) fn put<V: Serialize>(&mut self, value: &V) -> Result<(), EncodeError> {
        let free = self.buffer.get_mut(self.written..).ok_or(EncodeError::BufferTooSmall)?;
        let used = postcard::to_slice(value, free).map_err(|_| EncodeError::BufferTooSmall)?.len();
        self.written += used;
        Ok(())
    }

    pub(super) fn put_count(&mut self, count: usize) -> Result<(), EncodeError> {
        self.put(&u8::try_from(count).map_err(|_| EncodeError::TooMany)?)
    }

    // As `Reader::open`.
    #[inline(never)]
    pub(super) fn seal(self) -> Result<&'b [u8], EncodeError> {
        let end = self.written + CHECKSUM_LEN;
        let frame = self.buffer.get_mut(..end).ok_or(EncodeError::BufferTooSmall)?;
        let (content, checksum) = frame.split_at_mut(self.written);
        checksum.copy_from_slice(&CHECKSUM.checksum(content).to_le_bytes());
        Ok(frame)
    }
}

/// Reads the payload of a frame whose checksum and header are right.
pub(super) struct Reader<'f> {
    rest: &'f [u8],
}

impl<'f> Reader<'f> {
    // Once in flash, for all the kinds of frames that a node reads.
    #[inline(never)]
    pub(super) fn open<T: Scalar>(frame: &'f [u8], kind: Kind) -> Result<(Tick, Self), DecodeError> {
        if frame.len() < HEADER_LEN + CHECKSUM_LEN {
            return Err(DecodeError::TooShort);
        }
        let (content, _) = frame.split_last_chunk::<CHECKSUM_LEN>().ok_or(DecodeError::TooShort)?;
        if !checksum_fits(frame) {
            return Err(DecodeError::Checksum);
        }
        let mut reader = Self { rest: content };
        let header: Header = reader.take()?;
        if header.version != VERSION {
            return Err(DecodeError::Version(header.version));
        }
        if header.kind != kind as u8 {
            return Err(DecodeError::Kind(header.kind));
        }
        if header.scalar_bytes != T::BYTES {
            return Err(DecodeError::Scalar(header.scalar_bytes));
        }
        Ok((header.tick, reader))
    }

    pub(super) fn take<V: Deserialize<'f>>(&mut self) -> Result<V, DecodeError> {
        let (value, rest) = postcard::take_from_bytes(self.rest).map_err(|_| DecodeError::Length)?;
        self.rest = rest;
        Ok(value)
    }

    /// Takes a finite number.
    pub(super) fn take_scalar<T: Scalar>(&mut self) -> Result<T, DecodeError> {
        let value: T = self.take()?;
        if value.is_finite() { Ok(value) } else { Err(DecodeError::NotFinite) }
    }

    /// Takes a one-byte dimension that must be `expected`.
    pub(super) fn take_dimension(&mut self, expected: usize) -> Result<(), DecodeError> {
        let found: u8 = self.take()?;
        if usize::from(found) == expected { Ok(()) } else { Err(DecodeError::Dimension(found)) }
    }

    /// Takes all that is left.
    pub(super) fn rest(self) -> &'f [u8] {
        self.rest
    }

    /// Succeeds when nothing is left.
    pub(super) fn finish(self) -> Result<(), DecodeError> {
        if self.rest.is_empty() { Ok(()) } else { Err(DecodeError::Length) }
    }
}
