//! What an actuator stands on from cycle to cycle, kept twice; and what it does once that has changed by itself.

use super::{Actuator, Applied, RejectedSequence, Settings};
use crate::{
    Scalar, Tick,
    health::{Cause, Health},
    integrity::Twice,
    played::Age,
    sequence::ControlSequence,
};
use nalgebra::SVector;

/// What decides about the next cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Standing<T, const NU: usize> {
    /// The cycle that is played next.
    pub(super) tick: Tick,
    /// Tick and length of the sequence in the buffer; `None` while there is none.
    pub(super) buffered: Option<(Tick, usize)>,
    pub(super) last_input: SVector<T, NU>,
    /// Cycles in a row with an empty buffer.
    pub(super) idle: u16,
    /// Cycles that were played, up to as many as an acknowledgement tells of.
    pub(super) played: u8,
}

impl<T: Scalar, const NU: usize> Standing<T, NU> {
    /// Before cycle `tick`, the first.
    pub(super) fn new(tick: Tick) -> Self {
        Self { tick, buffered: None, last_input: SVector::zeros(), idle: 0, played: 0 }
    }

    /// With this sequence of finite inputs in the buffer, if it is of use in the next cycle beside the one that is there.
    pub(super) fn with(&self, sequence: &ControlSequence<'_, T, NU>) -> Result<Self, RejectedSequence> {
        if sequence.inputs.is_empty() {
            return Err(RejectedSequence::NoInputs);
        }
        if sequence.tick.is_after(self.tick) {
            return Err(RejectedSequence::Future);
        }
        if sequence.input_at(self.tick).is_none() {
            return Err(RejectedSequence::RunOut);
        }
        if self.buffered.is_some_and(|(held, _)| !sequence.tick.is_after(held)) {
            return Err(RejectedSequence::Past);
        }
        Ok(Self { buffered: Some((sequence.tick, sequence.inputs.len())), ..*self })
    }
}

impl<T: Scalar, const NU: usize> Actuator<'_, T, NU> {
    /// How this end of the loop is, after the cycle that was played last: lost once it applies the safe input.
    pub fn health(&self) -> Health {
        let (false, Some(settings), Some(standing)) =
            (self.is_damaged, self.settings.get(), self.standing.get())
        else {
            return Health::Lost(Cause::Memory);
        };
        match settings.safe {
            Some(safe) if standing.idle > safe.after => Health::Lost(Cause::RunOut),
            _ if standing.idle > 0 => Health::Degraded(Cause::RunOut),
            _ => Health::Nominal,
        }
    }

    /// Takes up to `numbers` more of the settings through a checksum; at the end of each round that is compared with
    /// `expected`, [`Settings::checksum`] of the constant that the actuator was made with. If it is another one, the actuator is
    /// lost. Returns whether a round has ended.
    ///
    /// What has changed since the actuator was made is noticed in the cycle anyway, from the copy; this is for constants that
    /// were wrong when it was. Before the first cycle with `usize::MAX`, and then in idle time.
    pub fn check_memory(&mut self, expected: u32, numbers: usize) -> bool {
        let Self { settings, round, is_damaged, .. } = self;
        let found = settings.get().map(|settings| round.go_on(numbers, &|place| settings.part(place)));
        *is_damaged |= found.is_none_or(|found| found.is_some_and(|found| found != expected));
        found.flatten().is_some()
    }

    /// Something that looks after the memory has found it changed, such as an error-correcting memory: from now on the actuator is
    /// lost.
    pub fn report_memory_fault(&mut self) {
        self.is_damaged = true;
    }

    /// Plays a cycle of which only this is known for sure: the input that does no harm. What was in the buffer is forgotten.
    #[cold]
    #[inline(never)]
    pub(super) fn stand_safe(&mut self) -> Applied<T, NU> {
        self.is_damaged = true;
        let before = *self.standing.either();
        let safe = match (self.safe_input.get(), self.settings.get()) {
            (Some(input), _) => *input,
            (None, Some(settings)) => safe_input(settings),
            // Two faults at once.
            (None, None) => SVector::zeros(),
        };
        // As slowly as the plant takes it, where that is known.
        let input = match (self.standing.get(), self.settings.get()) {
            (Some(standing), Some(settings)) => settings.leaves_after(&standing.last_input, &safe),
            _ => safe,
        };
        self.standing =
            Twice::new(Standing { last_input: input, tick: before.tick + 1, ..Standing::new(before.tick) });
        Applied { tick: before.tick, input, age: Age::Empty }
    }
}

/// What is applied by an actuator that does not know what to do: its safe input or else zero, within the limits.
pub(super) fn safe_input<T: Scalar, const NU: usize>(settings: &Settings<T, NU>) -> SVector<T, NU> {
    settings.saturate(&settings.safe.map_or_else(SVector::zeros, |safe| safe.input))
}
