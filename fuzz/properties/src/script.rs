//! What a script reads from bytes: numbers, ticks, and frames whose checksum is right.
//!
//! Everything is taken from the front, byte by byte, so that scripts can be written by hand: [`crate::seeds`].

use arbitrary::{Result, Unstructured};
use crc::{CRC_32_ISCSI, Crc};
use slqg::nalgebra::SVector;
use slqg::{Scalar, Tick};

/// Bytes of a frame's checksum.
const CHECKSUM_LEN: usize = 4;
/// Most bytes of a payload that a script makes up.
const LONGEST_PAYLOAD: u8 = 64;
/// Numbers that are seldom right; a script asks for them by their place.
const ODD: [f64; 12] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f32::MAX as f64,
    f32::MIN as f64,
    f64::MIN_POSITIVE,
    f32::MIN_POSITIVE as f64,
    -0.0,
    1e-45,
    1e19,
];
/// The byte from which on a number is an odd one, and the one from which on it is told bit by bit.
const FIRST_ODD: u8 = 200;
const FIRST_OF_BITS: u8 = FIRST_ODD + ODD.len() as u8;

/// `bytes` with their last four replaced by the checksum of those before; as they are if there are none before.
///
/// The checksum is that of `docs/wire-format.md`, by another implementation than the core's table.
pub fn whole(bytes: &[u8]) -> Vec<u8> {
    let content = &bytes[..bytes.len().saturating_sub(CHECKSUM_LEN)];
    if content.is_empty() { bytes.to_vec() } else { with_checksum(content) }
}

/// `content` with its checksum behind it.
pub fn with_checksum(content: &[u8]) -> Vec<u8> {
    let checksum = Crc::<u32>::new(&CRC_32_ISCSI).checksum(content);
    [content, &checksum.to_le_bytes()].concat()
}

/// A byte; zero once all are read.
pub fn byte(script: &mut Unstructured<'_>) -> Result<u8> {
    script.arbitrary()
}

/// A number from 0 to `most`, of one byte.
pub fn up_to(script: &mut Unstructured<'_>, most: u8) -> Result<u8> {
    Ok(byte(script)? % (most.saturating_add(1)).max(1))
}

/// Any number of the scalar: mostly one between -10 and 10, sometimes an odd one.
pub fn number<T: Scalar>(script: &mut Unstructured<'_>) -> Result<T> {
    Ok(match byte(script)? {
        tenths @ ..FIRST_ODD => T::nearest((f64::from(tenths) - 100.0) / 10.0),
        odd @ FIRST_ODD..FIRST_OF_BITS => T::nearest(ODD[usize::from(odd - FIRST_ODD)]),
        FIRST_OF_BITS.. => {
            let bits: [u8; 8] = script.arbitrary()?;
            T::read(&bits).map_or(T::ZERO, |(number, _)| number)
        }
    })
}

/// A vector of such numbers.
pub fn vector<T: Scalar, const D: usize>(script: &mut Unstructured<'_>) -> Result<SVector<T, D>> {
    let mut vector = SVector::<T, D>::zeros();
    for entry in vector.iter_mut() {
        *entry = number(script)?;
    }
    Ok(vector)
}

/// A tick at most 128 cycles from `now`.
pub fn tick_near(script: &mut Unstructured<'_>, now: Tick) -> Result<Tick> {
    let cycles: i8 = script.arbitrary()?;
    Ok(Tick(now.0.wrapping_add_signed(cycles.into())))
}

/// Some bytes as they are.
pub fn any_bytes<'s>(script: &mut Unstructured<'s>) -> Result<&'s [u8]> {
    let len = up_to(script, LONGEST_PAYLOAD)?;
    script.bytes(usize::from(len).min(script.len()))
}

/// A frame of any kind with any payload; its checksum is right.
pub fn any_frame(script: &mut Unstructured<'_>, now: Tick) -> Result<Vec<u8>> {
    let head = [byte(script)?, byte(script)?, byte(script)?];
    let tick = tick_near(script, now)?;
    Ok(with_checksum(&[&head, &tick.0.to_le_bytes()[..], any_bytes(script)?].concat()))
}
