//! The three payloads. Bytes 7 and on of a frame:
//!
//! ```text
//! measurement       outputs (1 byte), then one scalar per output
//! control           inputs (1 byte), length (1 byte), then the scalars of each input, cycle by cycle
//! acknowledgement   age of the sequence played in the frame's cycle (1 byte), 255 for the default input; then those
//!                   of the cycles before it, newest first, to the end of the frame
//! ```

use super::envelope::{Kind, Reader, Writer};
use super::{DecodeError, EncodeError};
use crate::{Scalar, Tick, played::Age, sequence::ControlSequence};
use nalgebra::SVector;

/// Most cycles that one acknowledgement is about.
pub const MOST_AGES: usize = 8;

const DEFAULT_INPUT: u8 = u8::MAX;

/// What a sensor measured in one cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement<T, const NY: usize> {
    /// The cycle it was measured in.
    pub tick: Tick,
    /// The outputs, in output units.
    pub output: SVector<T, NY>,
}

/// What an actuator played in one cycle and in those before it.
///
/// The ages before the newest repeat what earlier acknowledgements said, and make good the loss of any of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Acknowledgement {
    /// The newest cycle it is about.
    pub tick: Tick,
    /// Ages of the sequences that were played, newest first: `ages[i]` in cycle `tick - i`. At least one; without any
    /// it cannot be written, and none is ever read.
    pub ages: heapless::Vec<Age, MOST_AGES>,
}

impl Acknowledgement {
    /// Says that `age` was played in cycle `tick`, and nothing of the cycles before.
    pub fn of(tick: Tick, age: Age) -> Self {
        Self { tick, ages: [age].into() }
    }
}

/// Writes a measurement frame into `buffer` and returns its bytes, [`super::measurement_len`] of them.
///
/// # Errors
/// If `buffer` is too small or there are more than 255 outputs.
pub fn encode_measurement<'b, T: Scalar, const NY: usize>(
    measurement: &Measurement<T, NY>,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], EncodeError> {
    let mut writer = Writer::new::<T>(buffer, Kind::Measurement, measurement.tick)?;
    writer.put_count(NY)?;
    writer.put_vectors(core::slice::from_ref(&measurement.output))?;
    writer.seal()
}

/// Reads a measurement frame; all its numbers are finite.
///
/// # Errors
/// Says why the bytes are not a measurement of `NY` outputs.
pub fn decode_measurement<T: Scalar, const NY: usize>(
    frame: &[u8],
) -> Result<Measurement<T, NY>, DecodeError> {
    let (tick, mut reader) = Reader::open::<T>(frame, Kind::Measurement)?;
    reader.take_dimension(NY)?;
    let mut output = SVector::<T, NY>::zeros();
    reader.take_vectors(core::slice::from_mut(&mut output))?;
    reader.finish()?;
    Ok(Measurement { tick, output })
}

/// Writes a control frame into `buffer` and returns its bytes, [`super::control_len`] of them.
///
/// # Errors
/// If `buffer` is too small or an input or the sequence has more than 255 entries.
pub fn encode_control<'b, T: Scalar, const NU: usize>(
    sequence: &ControlSequence<'_, T, NU>,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], EncodeError> {
    let mut writer = Writer::new::<T>(buffer, Kind::Control, sequence.tick)?;
    writer.put_count(NU)?;
    writer.put_count(sequence.inputs.len())?;
    writer.put_vectors(sequence.inputs)?;
    writer.seal()
}

/// Reads a control frame into `room`, which holds as many inputs as a sequence may have; all its numbers are finite.
///
/// # Errors
/// Says why the bytes are not a sequence that fits. What `room` holds then means nothing.
pub fn decode_control<'s, T: Scalar, const NU: usize>(
    frame: &[u8],
    room: &'s mut [SVector<T, NU>],
) -> Result<ControlSequence<'s, T, NU>, DecodeError> {
    let (tick, mut reader) = Reader::open::<T>(frame, Kind::Control)?;
    reader.take_dimension(NU)?;
    let length = reader.take_byte()?;
    let inputs = room.get_mut(..length.into()).ok_or(DecodeError::Capacity(length))?;
    reader.take_vectors(inputs)?;
    reader.finish()?;
    Ok(ControlSequence { tick, inputs })
}

/// Writes an acknowledgement frame into `buffer` and returns its bytes, [`super::acknowledgement_len`] of them and
/// at most [`super::LONGEST_ACKNOWLEDGEMENT`].
///
/// `T` is the scalar type of the loop the frame belongs to.
///
/// # Errors
/// If `buffer` is too small, there is no age, or one is 255, which stands for the default input on the wire.
pub fn encode_acknowledgement<'b, T: Scalar>(
    acknowledgement: &Acknowledgement,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], EncodeError> {
    if acknowledgement.ages.is_empty() {
        return Err(EncodeError::NoAges);
    }
    let mut writer = Writer::new::<T>(buffer, Kind::Acknowledgement, acknowledgement.tick)?;
    writer.put_each(&acknowledgement.ages, |age| byte_of(*age))?;
    writer.seal()
}

/// Reads an acknowledgement frame of 1 to [`MOST_AGES`] cycles; the frame's length tells how many.
///
/// # Errors
/// Says why the bytes are not an acknowledgement.
pub fn decode_acknowledgement<T: Scalar>(frame: &[u8]) -> Result<Acknowledgement, DecodeError> {
    let (tick, reader) = Reader::open::<T>(frame, Kind::Acknowledgement)?;
    let bytes = reader.rest();
    if bytes.is_empty() || bytes.len() > MOST_AGES {
        return Err(DecodeError::Ages(u8::try_from(bytes.len()).unwrap_or(u8::MAX)));
    }
    let mut ages = heapless::Vec::new();
    for byte in bytes {
        // There is room.
        let _ = ages.push(age_of(*byte));
    }
    Ok(Acknowledgement { tick, ages })
}

/// An age as it is on the wire.
#[inline]
pub(super) fn byte_of(age: Age) -> Result<u8, EncodeError> {
    match age {
        Age::Steps(DEFAULT_INPUT) => Err(EncodeError::TooMany),
        Age::Steps(steps) => Ok(steps),
        Age::Empty => Ok(DEFAULT_INPUT),
    }
}

/// The age that a byte on the wire tells.
#[inline]
pub(super) fn age_of(byte: u8) -> Age {
    match byte {
        DEFAULT_INPUT => Age::Empty,
        steps => Age::Steps(steps),
    }
}
