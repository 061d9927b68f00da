//! Gains as bytes: a control law that a device loads at run time, from a file or a page of flash.
//!
//! Version 1, little-endian throughout; `docs/blob-format.md` is the normative page.
//!
//! ```text
//! bytes 0-3    "slqg"
//! byte 4       version, 1
//! byte 5       bytes per scalar: 4 (f32) or 8 (f64)
//! byte 6       default input: 0 zero, 1 hold
//! byte 7       inputs per sequence, N
//! bytes 8-9    states, nx
//! bytes 10-11  inputs, nu
//! bytes 12-15  id of the design
//! bytes 16-    Lx, M, r: scalars, by rows
//! last 4       CRC-32/ISCSI over everything before
//! ```
//!
//! Nothing is used before it is checked, and no bytes make [`load`] panic. Numbers are copied into the caller's
//! storage: bytes need no alignment and may be reused afterwards. The writer is here too, so that the layout is
//! told once.

mod error;
mod reception;

pub use crate::identity::DesignId;
pub use error::{BlobError, EncodeError};
pub use reception::Reception;

use crate::checksum::checksum;
use crate::gains::{Gains, Tables};
use crate::{Scalar, arrival, played::DefaultInput};

/// First bytes of every blob.
pub const MAGIC: [u8; 4] = *b"slqg";
/// Version of the layout, byte 4 of every blob.
pub const VERSION: u8 = 1;
/// Bytes around the tables: header and checksum.
pub const OVERHEAD: usize = HEADER_LEN + CHECKSUM_LEN;

const HEADER_LEN: usize = 16;
const CHECKSUM_LEN: usize = 4;
const ZERO: u8 = 0;
const HOLD: u8 = 1;

/// Dimensions of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Inputs per sequence, `N`: 1 to 255.
    pub length: usize,
    /// States, `nx`: up to 65535.
    pub states: usize,
    /// Inputs, `nu`: up to 65535.
    pub inputs: usize,
    /// What the actuator applies when its buffer has run out.
    pub default_input: DefaultInput,
}

impl Shape {
    /// Entries of `Lx`, `M` and `r`. Saturates, so that lengths no memory could hold stay longer than any.
    const fn table_lens(&self) -> [usize; 3] {
        let rows = self.length.saturating_mul(self.inputs);
        let expected = self.default_input.in_flight(self.length).saturating_mul(self.inputs);
        [rows.saturating_mul(self.states), rows.saturating_mul(expected), arrival::table_len(self.length)]
    }

    /// The numbers of `Lx`, `M` and `r`, which `numbers` holds one after the other, at least [`storage_len`] of them.
    pub(crate) fn split<'s, T>(&self, numbers: &'s [T]) -> [&'s [T]; 3] {
        let [lx, m, arrival] = self.table_lens();
        let (lx, rest) = numbers.split_at(lx);
        let (m, rest) = rest.split_at(m);
        [lx, m, &rest[..arrival]]
    }
}

/// Scalars that the tables of a law of this shape take: the storage [`load`] needs.
pub const fn storage_len(shape: &Shape) -> usize {
    let [lx, m, arrival] = shape.table_lens();
    lx.saturating_add(m).saturating_add(arrival)
}

/// Bytes of a blob of this shape in scalars of `scalar_bytes` each.
pub const fn encoded_len(shape: &Shape, scalar_bytes: u8) -> usize {
    storage_len(shape).saturating_mul(scalar_bytes as usize).saturating_add(OVERHEAD)
}

/// What a blob says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// The design that the gains belong to.
    pub design: DesignId,
    /// Bytes per scalar: 4 or 8.
    pub scalar_bytes: u8,
    /// Dimensions of the law.
    pub shape: Shape,
}

/// Reads what a blob says of itself, once its checksum, version and length are right.
///
/// # Errors
/// Says why the bytes are not a blob of version [`VERSION`]. Its numbers are not looked at.
pub fn header(bytes: &[u8]) -> Result<Header, BlobError> {
    open(bytes).map(|(header, _)| header)
}

/// Header and tables of a blob.
fn open(bytes: &[u8]) -> Result<(Header, &[u8]), BlobError> {
    let (content, end) = bytes.split_last_chunk::<CHECKSUM_LEN>().ok_or(BlobError::TooShort)?;
    let (header, tables) = content.split_first_chunk::<HEADER_LEN>().ok_or(BlobError::TooShort)?;
    if checksum(content) != u32::from_le_bytes(*end) {
        return Err(BlobError::Checksum);
    }
    let [a, b, c, d, version, scalar_bytes, default_input, length, rest @ ..] = *header;
    let [x0, x1, u0, u1, design @ ..] = rest;
    if [a, b, c, d] != MAGIC {
        return Err(BlobError::Magic);
    }
    if version != VERSION {
        return Err(BlobError::Version(version));
    }
    if scalar_bytes != f32::BYTES && scalar_bytes != f64::BYTES {
        return Err(BlobError::Scalar(scalar_bytes));
    }
    let shape = Shape {
        length: length.into(),
        states: u16::from_le_bytes([x0, x1]).into(),
        inputs: u16::from_le_bytes([u0, u1]).into(),
        default_input: match default_input {
            ZERO => DefaultInput::Zero,
            HOLD => DefaultInput::Hold,
            found => return Err(BlobError::DefaultInput(found)),
        },
    };
    if bytes.len() != encoded_len(&shape, scalar_bytes) {
        return Err(BlobError::Length);
    }
    Ok((Header { design: DesignId(u32::from_le_bytes(design)), scalar_bytes, shape }, tables))
}

/// Checksum of the tables alone, of a blob that was loaded.
pub(crate) fn tables_checksum(bytes: &[u8]) -> u32 {
    let end = bytes.len().saturating_sub(CHECKSUM_LEN);
    checksum(bytes.get(HEADER_LEN..end).unwrap_or_default())
}

/// Loads gains for `NX` states and `NU` inputs into `storage`, [`storage_len`] scalars or more.
///
/// `expected`: the design that they must belong to, or `None` to take those of any. How long sequences are is not
/// fixed here: [`crate::controller::Controller::new`] checks length and default input against what it is made for.
///
/// # Errors
/// Says why the bytes are not such gains: the first thing wrong, in the order of `docs/blob-format.md`. `storage` is
/// written to only once nothing but the numbers themselves can be wrong.
pub fn load<'s, T: Scalar, const NX: usize, const NU: usize>(
    bytes: &[u8],
    storage: &'s mut [T],
    expected: Option<DesignId>,
) -> Result<Gains<'s, T, NX, NU>, BlobError> {
    let (Header { design, scalar_bytes, shape }, tables) = open(bytes)?;
    if scalar_bytes != T::BYTES {
        return Err(BlobError::Scalar(scalar_bytes));
    }
    if expected.is_some_and(|expected| expected != design) {
        return Err(BlobError::Design(design));
    }
    // What was read from two bytes fits two bytes.
    if shape.states != NX {
        return Err(BlobError::States(shape.states as u16));
    }
    if shape.inputs != NU {
        return Err(BlobError::Inputs(shape.inputs as u16));
    }
    let needed = storage_len(&shape);
    let storage = storage.get_mut(..needed).ok_or(BlobError::StorageTooSmall { needed })?;
    for (value, bytes) in storage.iter_mut().zip(tables.chunks_exact(T::BYTES.into())) {
        (*value, _) = T::read(bytes).ok_or(BlobError::Length)?;
    }
    // The tables are as long as the bytes they were read from: nothing saturated.
    let [lx, m, arrival] = shape.split(storage);
    Tables::check(lx, m, arrival)
        .and_then(|tables| Gains::check(shape.length, shape.default_input, tables))
        .map_err(BlobError::Gains)
}

/// Writes gains of `design` into `buffer` and returns their bytes, [`encoded_len`] of them.
///
/// # Errors
/// If [`load`] would refuse them, or `buffer` is too small.
pub fn encode<'b, T: Scalar>(
    design: DesignId,
    shape: &Shape,
    tables: &Tables<'_, T>,
    buffer: &'b mut [u8],
) -> Result<&'b [u8], EncodeError> {
    let length = u8::try_from(shape.length).map_err(|_| EncodeError::TooLarge)?;
    let states = u16::try_from(shape.states).map_err(|_| EncodeError::TooLarge)?;
    let inputs = u16::try_from(shape.inputs).map_err(|_| EncodeError::TooLarge)?;
    tables
        .check_lengths(shape.length, shape.default_input, shape.states, shape.inputs)
        .map_err(EncodeError::Gains)?;

    let blob = buffer.get_mut(..encoded_len(shape, T::BYTES)).ok_or(EncodeError::BufferTooSmall)?;
    let (content, end) = blob.split_last_chunk_mut::<CHECKSUM_LEN>().ok_or(EncodeError::BufferTooSmall)?;
    let (header, numbers) =
        content.split_first_chunk_mut::<HEADER_LEN>().ok_or(EncodeError::BufferTooSmall)?;
    let default_input = match shape.default_input {
        DefaultInput::Zero => ZERO,
        DefaultInput::Hold => HOLD,
    };
    header[..4].copy_from_slice(&MAGIC);
    header[4..8].copy_from_slice(&[VERSION, T::BYTES, default_input, length]);
    header[8..10].copy_from_slice(&states.to_le_bytes());
    header[10..12].copy_from_slice(&inputs.to_le_bytes());
    header[12..].copy_from_slice(&design.0.to_le_bytes());
    let values = [tables.lx.numbers(), tables.m.numbers(), tables.arrival.numbers()].into_iter().flatten();
    for (value, bytes) in values.zip(numbers.chunks_exact_mut(T::BYTES.into())) {
        value.write(bytes).ok_or(EncodeError::BufferTooSmall)?;
    }
    *end = checksum(content).to_le_bytes();
    Ok(blob)
}
