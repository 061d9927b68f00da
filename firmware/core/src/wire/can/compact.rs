//! The compact form: one classic CAN frame for each full frame, and back.
//!
//! ```text
//! bytes 0-1   low half of the tick, little-endian
//! bytes 2-    control, measurement: up to three counts, 16 bit, little-endian, two's complement
//!             acknowledgement: up to six ages, one byte each, 255 for the default input
//! ```
//!
//! The kind is in the CAN identifier, the number of counts or ages in the data length. What counts stand for is on the
//! [`Grid`] that both ends have; CAN has a checksum of its own.

use super::{Grid, InvalidCompact, PackError, UnpackError};
use crate::wire::envelope::Kind;
use crate::wire::{
    Acknowledgement, DecodeError, Measurement, decode_acknowledgement, decode_control, decode_measurement,
    encode_acknowledgement, encode_control, encode_measurement,
};
use crate::{Scalar, Tick, played::Age, sequence::ControlSequence};
use embedded_can::{Frame, Id};
use heapless::Vec;
use nalgebra::SVector;

/// Most values in one frame: outputs of a measurement, or inputs of a sequence times its length.
pub const MOST_VALUES: usize = 3;
/// Most cycles that a compact acknowledgement is about.
pub const MOST_CYCLES: usize = 6;

const TICK_LEN: usize = 2;
const COUNT_LEN: usize = 2;
const CAPACITY: usize = TICK_LEN + MOST_VALUES * COUNT_LEN;
const DEFAULT_INPUT: u8 = u8::MAX;

/// Bytes of data in a compact frame of `values` values; an acknowledgement of twice as many cycles has as many.
pub const fn compact_len(values: usize) -> usize {
    TICK_LEN + values * COUNT_LEN
}

/// Which frame is which: one CAN identifier for each kind, all of them different.
///
/// The lower identifier wins the bus. A late acknowledgement costs least.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identifiers {
    /// Of measurements.
    pub measurement: Id,
    /// Of control frames.
    pub control: Id,
    /// Of acknowledgements.
    pub acknowledgement: Id,
}

/// The tick nearest to `now` whose low half is `low`: from 32768 cycles before it to 32767 after.
pub const fn nearest_tick(low: u16, now: Tick) -> Tick {
    let offset = low.wrapping_sub(now.0 as u16) as i16;
    Tick(now.0.wrapping_add_signed(offset as i32))
}

/// A loop's compact form; does not change while it runs, and is the same at both ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compact<T, const NU: usize, const NY: usize> {
    identifiers: Identifiers,
    inputs: Grid<T, NU>,
    outputs: Grid<T, NY>,
}

impl<T: Scalar, const NU: usize, const NY: usize> Compact<T, NU, NY> {
    /// The compact form with these identifiers and grids.
    ///
    /// # Errors
    /// If two identifiers are the same or a grid is not [valid](Grid::is_valid).
    pub fn new(
        identifiers: Identifiers,
        inputs: Grid<T, NU>,
        outputs: Grid<T, NY>,
    ) -> Result<Self, InvalidCompact> {
        let Identifiers { measurement, control, acknowledgement } = identifiers;
        if measurement == control || control == acknowledgement || acknowledgement == measurement {
            return Err(InvalidCompact::Identifiers);
        }
        if !inputs.is_valid() || !outputs.is_valid() {
            return Err(InvalidCompact::Grid);
        }
        Ok(Self { identifiers, inputs, outputs })
    }

    /// The CAN frame for the full frame `frame`.
    ///
    /// Inputs of a controller that has the grid in its design are packed without loss. Outputs, and other inputs, are
    /// rounded and saturate, as by [`Grid::round`].
    ///
    /// # Errors
    /// Says why `frame` is no frame of this loop, or does not fit.
    pub fn pack<F: Frame>(&self, frame: &[u8]) -> Result<F, PackError> {
        let kind = Kind::of(frame);
        let (id, data) = if kind == Some(Kind::Measurement) {
            let Measurement { tick, output } = decode_measurement(frame).map_err(PackError::Decode)?;
            (self.identifiers.measurement, counted(tick, &self.outputs, &[output])?)
        } else if kind == Some(Kind::Control) {
            let mut room = [SVector::zeros(); MOST_VALUES];
            let sequence = decode_control(frame, &mut room).map_err(PackError::Decode)?;
            (self.identifiers.control, counted(sequence.tick, &self.inputs, sequence.inputs)?)
        } else {
            let acknowledgement = decode_acknowledgement::<T>(frame).map_err(PackError::Decode)?;
            (self.identifiers.acknowledgement, ages_of(&acknowledgement)?)
        };
        F::new(id, &data).ok_or(PackError::Refused)
    }

    /// The full frame that `frame` stands for, written into `buffer`.
    ///
    /// `now` is the receiver's own tick, [`crate::controller::Controller::tick`] or [`crate::actuator::Actuator::tick`]:
    /// the frame's is the nearest with the same low half. A frame that is older than 32768 cycles would pass for another
    /// cycle's, so no queue may keep one for that long.
    ///
    /// # Errors
    /// Says why `frame` is none of this loop, or does not fit `buffer`.
    pub fn unpack<'b, F: Frame>(
        &self,
        frame: &F,
        now: Tick,
        buffer: &'b mut [u8],
    ) -> Result<&'b [u8], UnpackError> {
        let Identifiers { measurement, control, acknowledgement } = self.identifiers;
        let id = frame.id();
        if ![measurement, control, acknowledgement].contains(&id) {
            return Err(UnpackError::Identifier);
        }
        if frame.is_remote_frame() {
            return Err(UnpackError::Remote);
        }
        let wrong_length = UnpackError::Length(frame.data().len());
        if frame.data().len() > CAPACITY {
            return Err(wrong_length);
        }
        let (low, rest) = frame.data().split_first_chunk::<TICK_LEN>().ok_or(wrong_length)?;
        let tick = nearest_tick(u16::from_le_bytes(*low), now);
        if id == measurement {
            let outputs = self.outputs.vectors(rest)?.ok_or(wrong_length)?;
            let [output] = outputs[..] else { return Err(wrong_length) };
            encode_measurement(&Measurement { tick, output }, buffer)
        } else if id == control {
            let inputs = self.inputs.vectors(rest)?.ok_or(wrong_length)?;
            encode_control(&ControlSequence { tick, inputs: &inputs }, buffer)
        } else if rest.is_empty() {
            return Err(wrong_length);
        } else {
            let ages =
                rest.iter().map(|&age| if age == DEFAULT_INPUT { Age::Empty } else { Age::Steps(age) });
            encode_acknowledgement::<T>(&Acknowledgement { tick, ages: ages.collect() }, buffer)
        }
        .map_err(UnpackError::Encode)
    }
}

/// The low half of `tick`, as it begins the data.
fn begun(tick: Tick) -> Vec<u8, CAPACITY> {
    (tick.0 as u16).to_le_bytes().into_iter().collect()
}

/// Data of a measurement or a control frame.
fn counted<T: Scalar, const D: usize>(
    tick: Tick,
    grid: &Grid<T, D>,
    vectors: &[SVector<T, D>],
) -> Result<Vec<u8, CAPACITY>, PackError> {
    let found = D * vectors.len();
    if !(1..=MOST_VALUES).contains(&found) {
        return Err(PackError::Values(found));
    }
    let mut data = begun(tick);
    for (&value, &step) in vectors.iter().flat_map(|vector| vector.iter().zip(grid.step.iter())) {
        let count = grid.count(value, step).ok_or(PackError::Decode(DecodeError::NotFinite))?;
        data.extend_from_slice(&count.to_le_bytes()).map_err(|_| PackError::Values(found))?;
    }
    Ok(data)
}

/// Data of an acknowledgement.
fn ages_of(acknowledgement: &Acknowledgement) -> Result<Vec<u8, CAPACITY>, PackError> {
    let mut data = begun(acknowledgement.tick);
    for age in &acknowledgement.ages {
        let byte = match *age {
            Age::Steps(steps) => steps,
            Age::Empty => DEFAULT_INPUT,
        };
        data.push(byte).map_err(|_| PackError::Cycles(acknowledgement.ages.len()))?;
    }
    Ok(data)
}

impl<T: Scalar, const D: usize> Grid<T, D> {
    /// The vectors, at least one, that `bytes` count; `Ok(None)` if the bytes are not those of whole vectors.
    fn vectors(&self, bytes: &[u8]) -> Result<Option<Vec<SVector<T, D>, MOST_VALUES>>, UnpackError> {
        if bytes.is_empty() || bytes.len().checked_rem(D * COUNT_LEN) != Some(0) {
            return Ok(None);
        }
        let mut vectors = Vec::new();
        for bytes in bytes.chunks_exact(D * COUNT_LEN) {
            let counts = bytes.chunks_exact(COUNT_LEN).map(|count| i16::from_le_bytes([count[0], count[1]]));
            let counts = SVector::<i16, D>::from_iterator(counts);
            let Some(vector) = self.values(&counts) else { return Err(UnpackError::Count) };
            if vectors.push(vector).is_err() {
                return Ok(None);
            }
        }
        Ok(Some(vectors))
    }
}
