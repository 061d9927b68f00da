//! Payloads between a node and its host whose length is in them.

use super::super::envelope::{Kind, Reader, Writer};
use super::super::payload::{age_of, byte_of};
use super::super::{DecodeError, EncodeError};
use crate::{Scalar, Tick, played::Applied};
use nalgebra::SVector;

/// A piece of a blob, in order: [`crate::blob`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GainsPart<'f> {
    /// Number of the transfer, the same for all parts of a blob.
    pub transfer: u32,
    /// Where in the blob the bytes belong.
    pub offset: u16,
    /// Bytes of the whole blob.
    pub total: u16,
    /// The bytes.
    pub bytes: &'f [u8],
}

/// Samples of the reference, one a cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference<T: Scalar, const NZ: usize, const S: usize> {
    /// The cycle of the first one.
    pub tick: Tick,
    /// What the tracked outputs are to be, cycle by cycle.
    pub samples: heapless::Vec<SVector<T, NZ>, S>,
}

/// Writes what left the actuator in a cycle, [`crate::wire::applied_len`] bytes.
///
/// # Errors
/// If `buffer` is too small, or there are more than 255 inputs.
pub fn encode_applied<'b, T: Scalar, const NU: usize>(
    applied: &Applied<T, NU>,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], EncodeError> {
    let mut writer = Writer::new::<T>(buffer, Kind::Applied, applied.tick)?;
    writer.put_bytes(&[byte_of(applied.age)?])?;
    writer.put_count(NU)?;
    writer.put_scalars(applied.input.iter())?;
    writer.seal()
}

/// Reads what left the actuator in a cycle.
///
/// # Errors
/// Says why the bytes do not tell of `NU` inputs.
pub fn decode_applied<T: Scalar, const NU: usize>(frame: &[u8]) -> Result<Applied<T, NU>, DecodeError> {
    let (tick, mut reader) = Reader::open::<T>(frame, Kind::Applied)?;
    let age = age_of(reader.take_byte()?);
    reader.take_dimension(NU)?;
    let mut input = SVector::<T, NU>::zeros();
    reader.take_scalars(input.iter_mut())?;
    reader.finish()?;
    Ok(Applied { tick, input, age })
}

/// Writes a part of a blob, [`crate::wire::gains_part_len`] bytes; `T` is the scalar of the loop.
///
/// # Errors
/// If `buffer` is too small.
pub fn encode_gains_part<'b, T: Scalar>(
    part: &GainsPart<'_>,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], EncodeError> {
    let mut writer = Writer::new::<T>(buffer, Kind::GainsPart, Tick(part.transfer))?;
    writer.put_bytes(&part.offset.to_le_bytes())?;
    writer.put_bytes(&part.total.to_le_bytes())?;
    writer.put_bytes(part.bytes)?;
    writer.seal()
}

/// Reads a part of a blob. Whether it fits the parts before it is the receiver's to see.
///
/// # Errors
/// Says why the bytes are none.
pub fn decode_gains_part<T: Scalar>(frame: &[u8]) -> Result<GainsPart<'_>, DecodeError> {
    let (tick, mut reader) = Reader::open::<T>(frame, Kind::GainsPart)?;
    let (offset, total) = (reader.take_u16()?, reader.take_u16()?);
    Ok(GainsPart { transfer: tick.0, offset, total, bytes: reader.rest() })
}

/// Writes samples of the reference, [`crate::wire::reference_len`] bytes.
///
/// # Errors
/// If `buffer` is too small, or there are more than 255 of anything.
pub fn encode_reference<'b, T: Scalar, const NZ: usize, const S: usize>(
    reference: &Reference<T, NZ, S>,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], EncodeError> {
    let mut writer = Writer::new::<T>(buffer, Kind::Reference, reference.tick)?;
    writer.put_count(NZ)?;
    writer.put_count(reference.samples.len())?;
    for sample in &reference.samples {
        writer.put_scalars(sample.iter())?;
    }
    writer.seal()
}

/// Reads up to `S` samples of the reference; all their numbers are finite.
///
/// # Errors
/// Says why the bytes are no samples of `NZ` outputs.
pub fn decode_reference<T: Scalar, const NZ: usize, const S: usize>(
    frame: &[u8],
) -> Result<Reference<T, NZ, S>, DecodeError> {
    let (tick, mut reader) = Reader::open::<T>(frame, Kind::Reference)?;
    reader.take_dimension(NZ)?;
    let count = reader.take_byte()?;
    let mut reference = Reference { tick, samples: heapless::Vec::new() };
    for _ in 0..count {
        let mut sample = SVector::<T, NZ>::zeros();
        reader.take_scalars(sample.iter_mut())?;
        reference.samples.push(sample).map_err(|_| DecodeError::Capacity(count))?;
    }
    reader.finish()?;
    Ok(reference)
}
