//! Header and checksum around a payload; what payloads mean is in `payload`, where a frame is cut in `raw`.

use super::{
    DecodeError, EncodeError, VERSION,
    raw::{CHECKSUM_LEN, RawFrame},
};
use crate::{Scalar, Tick, checksum::checksum};
use nalgebra::SVector;
use serde::{Deserialize, Serialize};

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

    /// The kind with this number.
    #[inline]
    pub(super) fn numbered(found: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == found)
    }

    /// What a frame says it is, for whoever hands frames on; `None` if it is too short for a frame, or says something unknown.
    /// Nothing else of it is looked at: whoever decodes the frame checks all of it.
    #[inline]
    pub fn of(frame: &[u8]) -> Option<Self> {
        RawFrame::of(frame)?.kind()
    }
}

/// Writes a frame front to back into a caller's buffer.
pub(super) struct Writer<'b> {
    buffer: &'b mut [u8],
    written: usize,
}

impl<'b> Writer<'b> {
    pub(super) fn new<T: Scalar>(buffer: &'b mut [u8], kind: Kind, tick: Tick) -> Result<Self, EncodeError> {
        let mut writer = Self { buffer, written: 0 };
        writer.put_bytes(&[VERSION, kind as u8, T::BYTES])?;
        writer.put_bytes(&tick.0.to_le_bytes())?;
        Ok(writer)
    }

    #[inline(always)]
    pub(super) fn put_bytes(&mut self, bytes: &[u8]) -> Result<(), EncodeError> {
        let end = self.written + bytes.len();
        let room = self.buffer.get_mut(self.written..end).ok_or(EncodeError::BufferTooSmall)?;
        room.copy_from_slice(bytes);
        self.written = end;
        Ok(())
    }

    /// A byte for each of some entries.
    #[inline(always)]
    pub(super) fn put_each<E>(
        &mut self,
        entries: &[E],
        byte: impl Fn(&E) -> Result<u8, EncodeError>,
    ) -> Result<(), EncodeError> {
        let end = self.written + entries.len();
        let room = self.buffer.get_mut(self.written..end).ok_or(EncodeError::BufferTooSmall)?;
        for (room, entry) in room.iter_mut().zip(entries) {
            *room = byte(entry)?;
        }
        self.written = end;
        Ok(())
    }

    /// Numbers of the loop's scalar.
    #[inline(always)]
    pub(super) fn put_scalars<'n, T: Scalar>(
        &mut self,
        numbers: impl Iterator<Item = &'n T>,
    ) -> Result<(), EncodeError> {
        for number in numbers {
            let room = self.buffer.get_mut(self.written..).ok_or(EncodeError::BufferTooSmall)?;
            number.write(room).ok_or(EncodeError::BufferTooSmall)?;
            self.written += usize::from(T::BYTES);
        }
        Ok(())
    }

    /// All numbers of some vectors.
    #[inline(always)]
    pub(super) fn put_vectors<T: Scalar, const D: usize>(
        &mut self,
        vectors: &[SVector<T, D>],
    ) -> Result<(), EncodeError> {
        let end = self.written + vectors.len() * D * usize::from(T::BYTES);
        let room = self.buffer.get_mut(self.written..end).ok_or(EncodeError::BufferTooSmall)?;
        let mut room = room.chunks_exact_mut(T::BYTES.into());
        for vector in vectors {
            for (number, room) in vector.as_slice().iter().zip(&mut room) {
                number.write(room).ok_or(EncodeError::BufferTooSmall)?;
            }
        }
        self.written = end;
        Ok(())
    }

    /// A payload of fixed length.
    pub(super) fn put<V: Serialize>(&mut self, value: &V) -> Result<(), EncodeError> {
        let free = self.buffer.get_mut(self.written..).ok_or(EncodeError::BufferTooSmall)?;
        let used = postcard::to_slice(value, free).map_err(|_| EncodeError::BufferTooSmall)?.len();
        self.written += used;
        Ok(())
    }

    #[inline]
    pub(super) fn put_count(&mut self, count: usize) -> Result<(), EncodeError> {
        self.put_bytes(&[u8::try_from(count).map_err(|_| EncodeError::TooMany)?])
    }

    // As `Reader::open`.
    #[inline(never)]
    pub(super) fn seal(self) -> Result<&'b [u8], EncodeError> {
        let end = self.written + CHECKSUM_LEN;
        let frame = self.buffer.get_mut(..end).ok_or(EncodeError::BufferTooSmall)?;
        let (content, end) = frame.split_at_mut(self.written);
        end.copy_from_slice(&checksum(content).to_le_bytes());
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
        let raw = RawFrame::of(frame).ok_or(DecodeError::TooShort)?;
        if !raw.is_whole() {
            return Err(DecodeError::Checksum);
        }
        if !raw.is_of_this_version() {
            return Err(DecodeError::Version(raw.version()));
        }
        if raw.kind_number() != kind as u8 {
            return Err(DecodeError::Kind(raw.kind_number()));
        }
        if raw.scalar_bytes() != T::BYTES {
            return Err(DecodeError::Scalar(raw.scalar_bytes()));
        }
        Ok((raw.tick(), Self { rest: raw.payload() }))
    }

    /// Takes a payload of `len` bytes, all of whose fields have values that they may have.
    pub(super) fn take<V: Deserialize<'f>>(&mut self, len: usize) -> Result<V, DecodeError> {
        let (own, rest) = self.rest.split_at_checked(len).ok_or(DecodeError::Length)?;
        // A number of a list that takes more than its byte takes those of others, and does not get through either.
        let (value, left) = postcard::take_from_bytes(own).map_err(|_| DecodeError::Value)?;
        self.rest = rest;
        if left.is_empty() { Ok(value) } else { Err(DecodeError::Value) }
    }

    #[inline(always)]
    pub(super) fn take_byte(&mut self) -> Result<u8, DecodeError> {
        let (byte, rest) = self.rest.split_first().ok_or(DecodeError::Length)?;
        self.rest = rest;
        Ok(*byte)
    }

    /// Takes a number of two bytes.
    pub(super) fn take_u16(&mut self) -> Result<u16, DecodeError> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or(DecodeError::Length)?;
        self.rest = rest;
        Ok(u16::from_le_bytes(*bytes))
    }

    /// Takes finite numbers, as many as there are in `numbers`.
    #[inline(always)]
    pub(super) fn take_scalars<'n, T: Scalar>(
        &mut self,
        numbers: impl Iterator<Item = &'n mut T>,
    ) -> Result<(), DecodeError> {
        for number in numbers {
            let (value, rest) = T::read(self.rest).ok_or(DecodeError::Length)?;
            self.rest = rest;
            if !value.is_finite() {
                return Err(DecodeError::NotFinite);
            }
            *number = value;
        }
        Ok(())
    }

    /// Takes finite numbers for all entries of some vectors.
    #[inline(always)]
    pub(super) fn take_vectors<T: Scalar, const D: usize>(
        &mut self,
        vectors: &mut [SVector<T, D>],
    ) -> Result<(), DecodeError> {
        let taken = self.rest.split_at_checked(vectors.len() * D * usize::from(T::BYTES));
        let (bytes, rest) = taken.ok_or(DecodeError::Length)?;
        self.rest = rest;
        let mut bytes = bytes.chunks_exact(T::BYTES.into());
        for vector in vectors {
            for (number, bytes) in vector.as_mut_slice().iter_mut().zip(&mut bytes) {
                let (value, _) = T::read(bytes).ok_or(DecodeError::Length)?;
                if !value.is_finite() {
                    return Err(DecodeError::NotFinite);
                }
                *number = value;
            }
        }
        Ok(())
    }

    /// Takes a one-byte dimension that must be `expected`.
    #[inline]
    pub(super) fn take_dimension(&mut self, expected: usize) -> Result<(), DecodeError> {
        let found = self.take_byte()?;
        if usize::from(found) == expected { Ok(()) } else { Err(DecodeError::Dimension(found)) }
    }

    /// Takes all that is left.
    #[inline]
    pub(super) fn rest(self) -> &'f [u8] {
        self.rest
    }

    /// Succeeds when nothing is left.
    #[inline]
    pub(super) fn finish(self) -> Result<(), DecodeError> {
        if self.rest.is_empty() { Ok(()) } else { Err(DecodeError::Length) }
    }
}
