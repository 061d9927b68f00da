//! Gains that come over the link as a blob, in parts.

use super::Laws;
use crate::design::{ACTUATOR, DESIGN, INPUTS, SEQUENCE_LENGTH, STATES, Scalar};
use crate::dimensions::DESIGN_ID;
use slqg::{
    Scalar as _,
    bank::Bank,
    blob::{self, BlobError, Reception, Shape},
    controller::Law,
    wire::{GainsAnswer, GainsPart, Verdict},
};

/// Most bytes of a blob in one frame.
pub const LARGEST_PART: usize = 32;
/// The laws that the node takes.
const SHAPE: Shape =
    Shape { length: SEQUENCE_LENGTH, states: STATES, inputs: INPUTS, default_input: ACTUATOR.default_input };

/// A blob on its way, and the law that was the last one to arrive.
pub struct Sent {
    /// `None` where new gains would leave tables of the design behind.
    bank: Option<Bank<Scalar, STATES, INPUTS, { blob::storage_len(&SHAPE) }>>,
    reception: Reception<{ blob::encoded_len(&SHAPE, Scalar::BYTES) }>,
}

impl Default for Sent {
    fn default() -> Self {
        Self {
            // Preview gains and trigger belong to the gains, and are not in a blob.
            bank: match (&DESIGN.preview, &DESIGN.trigger) {
                (None, None) => Bank::new(SHAPE.length, SHAPE.default_input),
                _ => None,
            },
            reception: Reception::default(),
        }
    }
}

impl Laws for Sent {
    fn law(&self) -> Option<Law<'_, Scalar, STATES, INPUTS>> {
        self.bank.as_ref()?.law()
    }

    /// The gains of a blob that is whole and fits are in force from the next cycle on.
    fn take(&mut self, part: &GainsPart<'_>) -> GainsAnswer {
        match (&mut self.bank, self.reception.take(part)) {
            (_, Err(answer)) => answer,
            (bank, Ok(blob)) => {
                let loaded = bank.as_mut().map_or(Err(BlobError::Sequence), |bank| {
                    bank.load(blob, DESIGN_ID, DESIGN.arrives_at_once)
                });
                self.reception.answer(loaded.map_or_else(Verdict::from, |()| Verdict::InForce))
            }
        }
    }
}
