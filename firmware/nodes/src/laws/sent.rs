//! Gains that come over the link as a blob, in parts.

use super::Laws;
use crate::design::{ACTUATOR, DESIGN, INPUTS, SEQUENCE_LENGTH, STATES, Scalar};
use crate::dimensions::DESIGN_ID;
use slqg::{
    Scalar as _,
    bank::{self, Bank},
    blob::{self, BlobError, Reception, Shape},
    controller::Law,
    wire::{GainsAnswer, GainsPart, Verdict},
};

/// Most bytes of a blob in one frame.
pub const LARGEST_PART: usize = 32;
/// The laws that the node takes.
const SHAPE: Shape =
    Shape { length: SEQUENCE_LENGTH, states: STATES, inputs: INPUTS, default_input: ACTUATOR.default_input };

/// Numbers of memory for the laws that arrive.
pub const BANK_MEMORY: usize = bank::memory_len(&SHAPE);

/// A blob on its way, and the law that was the last one to arrive.
pub struct Sent<'m> {
    /// `None` where new gains would leave tables of the design behind.
    bank: Option<Bank<'m, Scalar, STATES, INPUTS>>,
    reception: Reception<{ blob::encoded_len(&SHAPE, Scalar::BYTES) }>,
}

impl<'m> Sent<'m> {
    /// Nothing has arrived yet.
    #[inline(never)]
    pub fn new(memory: &'m mut [Scalar; BANK_MEMORY]) -> Self {
        Self {
            // Preview gains and trigger belong to the gains, and are not in a blob.
            bank: match (&DESIGN.preview, &DESIGN.trigger) {
                (None, None) => Bank::new(SHAPE.length, SHAPE.default_input, memory),
                _ => None,
            },
            reception: Reception::default(),
        }
    }
}

impl Laws for Sent<'_> {
    fn law(&self) -> Option<Law<'_, Scalar, STATES, INPUTS>> {
        self.bank.as_ref()?.law()
    }

    fn check_memory(&mut self, numbers: usize) -> bool {
        self.bank.as_mut().is_none_or(|bank| bank.check_memory(numbers))
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
