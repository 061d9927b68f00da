//! The compact form: one classic CAN frame for each full frame, and back.
//!
//! ```text
//! bytes 0-1   lower half of the tick, little-endian
//! bytes 2-    control, measurement: one or two counts of 16 bits, or three of 13, little-endian, two's complement
//!             acknowledgement: up to five ages, one byte each, 255 for the default input
//! last byte   check, see [`Check`]
//! ```
//!
//! The kind is in the CAN identifier, the number of counts or ages in the data length. What counts stand for is on the
//! [`Grid`] that both ends have, their bits are in `counts`.

use super::{
    Check, Grid, InvalidCompact, PackError, UnpackError,
    counts::{self, counts_len, has_room},
};
use crate::wire::envelope::Kind;
use crate::wire::{
    Acknowledgement, Measurement, decode_acknowledgement, decode_control, decode_measurement,
    encode_acknowledgement, encode_control, encode_measurement,
};
use crate::{Scalar, Tick, identity::DesignId, played::Age, sequence::ControlSequence};
use embedded_can::{Frame, Id};
use heapless::Vec;
use nalgebra::SVector;

/// Most values in one frame: outputs of a measurement, or inputs of a sequence times its length.
pub const MOST_VALUES: usize = 3;
/// Most cycles that a compact acknowledgement is about.
pub const MOST_CYCLES: usize = 5;

/// Bytes of the tick and the check.
const OVERHEAD: usize = 2 + 1;
const CAPACITY: usize = OVERHEAD + MOST_CYCLES;
const DEFAULT_INPUT: u8 = u8::MAX;

/// The bytes of one classic frame.
pub(super) type Data = Vec<u8, CAPACITY>;

/// Bytes of data in a compact frame of `values` values.
pub const fn compact_len(values: usize) -> usize {
    OVERHEAD + counts_len(values)
}

/// Bytes of data in a compact acknowledgement of `cycles` cycles.
pub const fn compact_acknowledgement_len(cycles: usize) -> usize {
    OVERHEAD + cycles
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

/// The tick nearest to `now` whose lower half is `low`: from 32768 cycles before it to 32767 after.
pub const fn nearest_tick(low: u16, now: Tick) -> Tick {
    let offset = low.wrapping_sub(now.0 as u16) as i16;
    Tick(now.0.wrapping_add_signed(offset as i32))
}

/// A loop's compact form; does not change while it runs, and is the same at both ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compact<T, const NU: usize, const NY: usize> {
    check: Check,
    identifiers: Identifiers,
    inputs: Grid<T, NU>,
    outputs: Grid<T, NY>,
}

impl<T: Scalar, const NU: usize, const NY: usize> Compact<T, NU, NY> {
    /// The compact form of the loop with the plant of `design`.
    ///
    /// # Errors
    /// If two identifiers are the same, a grid is not [valid](Grid::is_valid), or a measurement or a single input has no room
    /// for its grid's [largest count](super::largest_count).
    pub fn new(
        design: DesignId,
        identifiers: Identifiers,
        inputs: Grid<T, NU>,
        outputs: Grid<T, NY>,
    ) -> Result<Self, InvalidCompact> {
        let Identifiers { measurement, control, acknowledgement } = identifiers;
        if measurement == control || control == acknowledgement || acknowledgement == measurement {
            return Err(InvalidCompact::Identifiers);
        }
        // More values than any frame has are refused where they are packed.
        let (inputs_fit, outputs_fit) =
            (NU > MOST_VALUES || has_room(&inputs, NU), NY > MOST_VALUES || has_room(&outputs, NY));
        if !inputs.is_valid() || !outputs.is_valid() || !inputs_fit || !outputs_fit {
            return Err(InvalidCompact::Grid);
        }
        Ok(Self { check: Check::new(design), identifiers, inputs, outputs })
    }

    /// The CAN frame for the full frame `frame`.
    ///
    /// Inputs of a controller that has the grid in its design are packed without loss. Outputs, and other inputs, are
    /// rounded and saturate, as by [`Grid::round`].
    ///
    /// # Errors
    /// Says why `frame` is no frame of this loop, or does not fit.
    pub fn pack<F: Frame>(&self, frame: &[u8]) -> Result<F, PackError> {
        let (id, kind, tick, mut data) = match Kind::of(frame) {
            Some(Kind::Measurement) => {
                let Measurement { tick, output } = decode_measurement(frame).map_err(PackError::Decode)?;
                let mut data = begun(tick);
                counts::put(&mut data, &self.outputs, &[output])?;
                (self.identifiers.measurement, Kind::Measurement, tick, data)
            }
            Some(Kind::Control) => {
                let mut room = [SVector::zeros(); MOST_VALUES];
                let sequence = decode_control(frame, &mut room).map_err(PackError::Decode)?;
                let mut data = begun(sequence.tick);
                counts::put(&mut data, &self.inputs, sequence.inputs)?;
                (self.identifiers.control, Kind::Control, sequence.tick, data)
            }
            _ => {
                let told = decode_acknowledgement::<T>(frame).map_err(PackError::Decode)?;
                (self.identifiers.acknowledgement, Kind::Acknowledgement, told.tick, ages_of(&told)?)
            }
        };
        // There is room: counts take no more than ages may.
        data.push(self.check.of(kind, tick, &data)).map_err(|_| PackError::Refused)?;
        F::new(id, &data).ok_or(PackError::Refused)
    }

    /// The full frame that `frame` stands for, written into `buffer`.
    ///
    /// `now` is the receiver's own tick, [`crate::controller::Controller::tick`] or [`crate::actuator::Actuator::tick`]:
    /// the frame's is the nearest with the same lower half. A frame that is further than 32768 cycles away fails its check, but
    /// for one in 256.
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
        let kind = if id == measurement {
            Kind::Measurement
        } else if id == control {
            Kind::Control
        } else if id == acknowledgement {
            Kind::Acknowledgement
        } else {
            return Err(UnpackError::Identifier);
        };
        if frame.is_remote_frame() {
            return Err(UnpackError::Remote);
        }
        let wrong_length = UnpackError::Length(frame.data().len());
        if !self.has_length(kind, frame.data().len()) {
            return Err(wrong_length);
        }
        let (&check, checked) = frame.data().split_last().ok_or(wrong_length)?;
        let (low, rest) = checked.split_first_chunk().ok_or(wrong_length)?;
        let tick = nearest_tick(u16::from_le_bytes(*low), now);
        if self.check.of(kind, tick, checked) != check {
            return Err(UnpackError::Check);
        }
        match kind {
            Kind::Measurement => {
                let outputs = counts::vectors(&self.outputs, rest)?.ok_or(wrong_length)?;
                let [output] = outputs[..] else { return Err(wrong_length) };
                encode_measurement(&Measurement { tick, output }, buffer)
            }
            Kind::Control => {
                let inputs = counts::vectors(&self.inputs, rest)?.ok_or(wrong_length)?;
                encode_control(&ControlSequence { tick, inputs: &inputs }, buffer)
            }
            _ => {
                let ages =
                    rest.iter().map(|&age| if age == DEFAULT_INPUT { Age::Empty } else { Age::Steps(age) });
                encode_acknowledgement::<T>(&Acknowledgement { tick, ages: ages.collect() }, buffer)
            }
        }
        .map_err(UnpackError::Encode)
    }

    /// Whether frames of this kind can have so many bytes of data.
    fn has_length(&self, kind: Kind, len: usize) -> bool {
        let counts = |values: usize| values <= MOST_VALUES && len == compact_len(values);
        match kind {
            Kind::Measurement => NY > 0 && counts(NY),
            Kind::Control => (1..=MOST_VALUES).any(|values| {
                values.checked_rem(NU) == Some(0) && counts(values) && has_room(&self.inputs, values)
            }),
            _ => (1..=MOST_CYCLES).any(|cycles| len == compact_acknowledgement_len(cycles)),
        }
    }
}

/// The lower half of `tick`, as it begins the data.
fn begun(tick: Tick) -> Data {
    (tick.0 as u16).to_le_bytes().into_iter().collect()
}

/// Data of an acknowledgement.
fn ages_of(acknowledgement: &Acknowledgement) -> Result<Data, PackError> {
    let too_many = PackError::Cycles(acknowledgement.ages.len());
    if acknowledgement.ages.len() > MOST_CYCLES {
        return Err(too_many);
    }
    let mut data = begun(acknowledgement.tick);
    for age in &acknowledgement.ages {
        let byte = match *age {
            Age::Steps(steps) => steps,
            Age::Empty => DEFAULT_INPUT,
        };
        data.push(byte).map_err(|_| too_many)?;
    }
    Ok(data)
}
