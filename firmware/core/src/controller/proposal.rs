//! A cycle in two steps: the sequence that the law makes, and the end of the cycle with or without it.
//!
//! For whoever decides more than the core does: [`super::Controller::cycle`] is both steps and the frame.

use super::{Controller, Law, around, count};
use crate::{
    Scalar,
    estimator::{ModeFilter, Surroundings},
    event::Candidate,
    played::{Age, Played},
    sequence::ControlSequence,
};
use nalgebra::SVector;

/// What might be sent in a cycle, and what the law made it from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proposal<'c, T: Scalar, const NX: usize, const NU: usize> {
    /// The sequence, `N` inputs.
    pub sequence: ControlSequence<'c, T, NU>,
    /// Estimate of the state, given all that has arrived.
    pub posterior_mean: &'c SVector<T, NX>,
    /// `vbar`, `n_v` inputs.
    pub expected: &'c [SVector<T, NU>],
}

/// Why a sequence does not take the place of the proposed one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RejectedInputs {
    /// It has another length.
    Length,
    /// It holds a number that is not finite.
    NotFinite,
}

impl core::fmt::Display for RejectedInputs {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Length => "a sequence of another length than the law's",
            Self::NotFinite => "a sequence with a number that is not finite",
        })
    }
}

impl core::error::Error for RejectedInputs {}

impl<'m, T: Scalar, const NX: usize, const NU: usize, const NY: usize> Controller<'m, T, NX, NU, NY> {
    /// Opens the cycle: estimates the state and decides the sequence. Thesis (3.30), THEORY 3.
    ///
    /// Until [`Controller::commit`] it may be asked for again, and then takes account of what has arrived in between; what is
    /// committed is what was proposed last.
    pub fn propose(&mut self) -> Proposal<'_, T, NX, NU> {
        self.open(&self.design.law());
        self.proposal()
    }

    /// Puts `inputs` in the place of the proposed sequence, on the design's grid if it has one. Another
    /// [`Controller::propose`], or [`Controller::cycle`], puts that of the law there again.
    ///
    /// # Errors
    /// Says why they do not take its place.
    pub fn replace(
        &mut self,
        inputs: &[SVector<T, NU>],
    ) -> Result<ControlSequence<'_, T, NU>, RejectedInputs> {
        let sequence = ControlSequence { tick: self.tick(), inputs };
        if inputs.len() != self.in_flight.length() {
            return Err(RejectedInputs::Length);
        }
        if !sequence.is_finite() {
            return Err(RejectedInputs::NotFinite);
        }
        if !self.is_proposed {
            self.open(&self.design.law());
        }
        self.in_flight.candidate().copy_from_slice(inputs);
        self.round();
        Ok(self.in_flight.proposed())
    }

    /// Closes the cycle: its sequence is sent, or nothing is. One that was not proposed is, before.
    ///
    /// A sequence that is not finite is counted, and taken for not sent: no actuator takes it.
    pub fn commit(&mut self, is_sent: bool) {
        let law = self.design.law();
        if !self.is_proposed {
            self.open(&law);
        }
        let is_finite = self.in_flight.proposed().is_finite();
        if !is_finite {
            count(&mut self.counts.not_finite);
        }
        self.last.not_finite = !is_finite;
        self.close(&law, is_sent && is_finite);
    }

    pub(super) fn proposal(&self) -> Proposal<'_, T, NX, NU> {
        Proposal {
            sequence: self.in_flight.proposed(),
            posterior_mean: self.filter.posterior_mean(),
            expected: self.expected.get(..self.design.gains.in_flight()).unwrap_or_default(),
        }
    }

    /// Everything up to the sequence.
    pub(super) fn open(&mut self, law: &Law<'_, T, NX, NU>) {
        let tick = self.filter.tick();
        if !self.is_proposed && self.filter.is_acknowledged(tick - 1) == Some(false) {
            count(&mut self.counts.unacknowledged);
        }
        self.filter.filter(&around(&self.design, law, &self.in_flight));
        let expected = if self.design.merging.is_linear() {
            self.in_flight.fill_mean(&law.gains, self.expected)
        } else {
            let around = around(&self.design, law, &self.in_flight);
            let played = played(&self.filter, &around, self.rounds_age);
            self.in_flight.fill_expected(&law.gains, &played, self.expected)
        };
        let sequence = self.in_flight.candidate();
        law.gains.fill_sequence(self.filter.posterior_mean(), expected, sequence);
        if self.is_fed_forward {
            sequence.iter_mut().zip(&*self.feedforward).for_each(|(input, forward)| *input += forward);
        }
        self.round();
        self.is_proposed = true;
    }

    /// Before anything remembers them: the actuator gets no others.
    fn round(&mut self) {
        if let Some(grid) = &self.design.grid {
            self.in_flight.candidate().iter_mut().for_each(|input| *input = grid.round(input));
        }
    }

    pub(super) fn close(&mut self, law: &Law<'_, T, NX, NU>, is_sent: bool) {
        let mean = self.design.merging.is_linear().then(|| self.push_mean(law, is_sent));
        if mean.is_none() {
            self.in_flight.push(is_sent);
        }
        self.filter.advance(&around(&self.design, law, &self.in_flight));
        if let Some(mean) = mean {
            self.filter.tell_mean(&mean);
        }
        let begun_anew = self.filter.begun_anew();
        self.last.begun_anew = begun_anew != self.counts.begun_anew;
        self.counts.begun_anew = begun_anew;
        self.is_proposed = false;
    }

    /// The mean of what is applied in this cycle, where no acknowledgement ever comes.
    #[inline(never)]
    fn push_mean(&mut self, law: &Law<'_, T, NX, NU>, is_sent: bool) -> SVector<T, NU> {
        let actuator = &self.design.actuator;
        if actuator.limits.is_some() {
            // As they leave the actuator.
            self.in_flight.candidate().iter_mut().for_each(|input| *input = actuator.saturate(input));
        }
        self.in_flight.push_mean(&law.gains, law.arrives_at_once, is_sent)
    }

    /// Whether the trigger finds the sequence worth a packet; without a trigger every one is.
    pub(super) fn is_worth_sending(&mut self, law: &Law<'_, T, NX, NU>) -> bool {
        let Some(trigger) = &self.design.trigger else { return true };
        if let Some(period) = trigger.fixed_period() {
            return (self.in_flight.proposed().tick.0 as usize).is_multiple_of(period);
        }
        let candidate = Candidate {
            posterior_mean: self.filter.posterior_mean(),
            expected: self.expected.get(..law.gains.in_flight()).unwrap_or_default(),
            inputs: self.in_flight.proposed().inputs,
            displaced: self.displaced.get(..self.displaced_len).unwrap_or_default(),
            played: played(&self.filter, &around(&self.design, law, &self.in_flight), self.rounds_age),
        };
        #[cfg(feature = "schedule")]
        let numbers = &mut *self.numbers;
        #[cfg(not(feature = "schedule"))]
        let numbers = &mut [];
        let benefit = trigger.benefit(&law.gains, &self.in_flight, &candidate, self.room, numbers);
        trigger.is_worth_sending(benefit)
    }
}

/// What the estimator believes to have been played in the cycle before the current one.
fn played<'f, T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    filter: &'f ModeFilter<'_, T, NX, NU, NY>,
    around: &Surroundings<'_, T, NX, NU, NY>,
    rounds_age: bool,
) -> Played<'f, T, NU> {
    let Some(modes) = filter.modes() else { return Played::nothing() };
    let (last, length) = (filter.tick() - 1, around.gains.length());
    // Of a sequence that is not remembered nothing can be expected.
    let input = |age| around.applied(last, age, &modes).unwrap_or_else(SVector::zeros);
    let taken = if rounds_age { Some(modes.rounded(length)) } else { modes.known() };
    match taken {
        Some(age) => Played::Known(age, input(age)),
        None => {
            Played::Believed { modes, oldest: input(u8::try_from(length - 1).map_or(Age::Empty, Age::Steps)) }
        }
    }
}
