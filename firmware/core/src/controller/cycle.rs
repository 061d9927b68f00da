//! One control cycle: estimate, law, and the frame out, if it is worth one.

use super::{Controller, CycleError, Law, around, count};
use crate::{
    Scalar, Tick,
    actuator::Age,
    event::Candidate,
    gains::Gains,
    sequence::ControlSequence,
    wire::{self, EncodeError},
};
use nalgebra::SVector;

impl<
    T: Scalar,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
    const E: usize,
> Controller<'_, T, NX, NU, NY, N, H, E>
{
    /// Runs one cycle: estimates the state, decides the sequence, and writes it as a frame into `buffer`.
    ///
    /// Returns the frame to send, [`wire::control_len`] bytes; `None` if nothing is to be sent: the sequence is not worth a
    /// packet, or no finite one came out, which costs the loop no more than a lost packet. Either is counted. The
    /// actuator needs no word of it: it plays on and acknowledges what it plays. Thesis (3.30), THEORY 3, 7.
    ///
    /// # Errors
    /// If `buffer` is too small for the frame. The cycle is over even so, as if the packet was lost.
    pub fn cycle<'b>(&mut self, buffer: &'b mut [u8]) -> Result<Option<&'b [u8]>, EncodeError> {
        self.run(&self.design.law(), buffer)
    }

    /// As [`Controller::cycle`], under another law than the design's: that of a [`crate::bank::Bank`], which may change from
    /// cycle to cycle. Preview gains and trigger stay as they are.
    ///
    /// # Errors
    /// If the law is for sequences of another length or for another default input, or if `buffer` is too small.
    pub fn cycle_under<'b>(
        &mut self,
        law: &Law<'_, T, NX, NU>,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, CycleError> {
        self.design.check_law(law.gains.length(), law.gains.default_input()).map_err(CycleError::Law)?;
        self.run(law, buffer).map_err(CycleError::Encode)
    }

    fn run<'b>(
        &mut self,
        law: &Law<'_, T, NX, NU>,
        buffer: &'b mut [u8],
    ) -> Result<Option<&'b [u8]>, EncodeError> {
        let tick = self.filter.tick();
        if self.filter.is_acknowledged(tick - 1) == Some(false) {
            count(&mut self.counts.unacknowledged);
        }
        self.filter.filter(&around(&self.design, law, &self.in_flight));
        self.believe(law, tick - 1);
        let expected = self.in_flight.expected_inputs(&law.gains);
        let mut inputs = law.gains.sequence(self.filter.posterior_mean(), &expected);
        self.feedforward.add_to(&mut inputs);
        if let Some(grid) = &self.design.grid {
            // Before anything remembers them: the actuator gets no others.
            inputs.iter_mut().for_each(|input| *input = grid.round(input));
        }
        let sequence = ControlSequence { tick, inputs };
        let frame = if !sequence.is_finite() {
            count(&mut self.counts.not_finite);
            Ok(None)
        } else if !self.is_worth_sending(&law.gains, &sequence, &expected) {
            count(&mut self.counts.not_worth_sending);
            Ok(None)
        } else {
            wire::encode_control(&sequence, buffer).map(Some)
        };
        self.in_flight.push(matches!(frame, Ok(Some(_))).then_some(sequence));

        self.filter.advance(&around(&self.design, law, &self.in_flight));
        frame
    }

    /// Takes over what the estimator believes to have been played in cycle `last`, the one before the current.
    fn believe(&mut self, law: &Law<'_, T, NX, NU>, last: Tick) {
        let Some(modes) = self.filter.modes() else { return };
        let around = around(&self.design, law, &self.in_flight);
        let length = self.design.gains.length();
        let taken = if self.rounds_age { Some(modes.rounded(length)) } else { modes.known() };
        match taken {
            Some(age) => {
                // Of a sequence that is not remembered nothing can be expected.
                let input = around.input(last, age, modes.held()).unwrap_or_else(SVector::zeros);
                self.in_flight.acknowledge(age, input);
            }
            None => {
                let oldest = u8::try_from(length - 1).map_or(Age::Empty, Age::Steps);
                let oldest = around.input(last, oldest, modes.held()).unwrap_or_else(SVector::zeros);
                let modes = modes.clone();
                self.in_flight.believe(modes, oldest);
            }
        }
    }

    /// Without a trigger everything is.
    fn is_worth_sending(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        sequence: &ControlSequence<T, NU, N>,
        expected: &[SVector<T, NU>],
    ) -> bool {
        self.design.trigger.as_ref().is_none_or(|trigger| {
            let candidate = Candidate {
                posterior_mean: self.filter.posterior_mean(),
                expected,
                inputs: &sequence.inputs,
                displaced: &self.feedforward.displaced,
            };
            trigger.is_worth_sending(trigger.benefit(gains, &self.in_flight, candidate))
        })
    }
}
