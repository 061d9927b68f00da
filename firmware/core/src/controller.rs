//! `Controller`: one control cycle, measurement and acknowledgement frames in, control frame out.
//!
//! It ties the rooms together and decides nothing itself: the estimate is [`crate::estimator`]'s, the
//! expected inputs [`crate::in_flight`]'s, the law [`crate::gains`]', the feedforward [`crate::tracking`]'s, whether to send
//! [`crate::event`]'s, the bytes [`crate::wire`]'s.

use crate::{
    DefaultInput, Scalar, Tick,
    actuator::{Age, Settings},
    estimator::{Kalman, Model, RejectedMeasurement},
    event::{Candidate, Trigger},
    gains::Gains,
    in_flight::{InFlight, push_newest},
    sequence::ControlSequence,
    tracking::{Feedforward, Preview, RejectedReference},
    wire::{self, Acknowledgement, DecodeError, EncodeError, Measurement},
};
use heapless::Deque;
use nalgebra::SVector;

/// Everything a controller is told at design time.
#[derive(Debug, Clone, Copy)]
pub struct Design<'a, T, const NX: usize, const NU: usize, const NY: usize> {
    /// The control law.
    pub gains: Gains<'a, T, NX, NU>,
    /// The plant.
    pub model: &'a Model<T, NX, NU, NY>,
    /// The actuator at the other end.
    pub actuator: Settings<T, NU>,
    /// Most cycles a measurement may be late and still count, `N^B`, thesis (3.34).
    pub measurement_buffer: usize,
    /// What a reference adds to the law; `None` where the state is controlled to zero.
    pub preview: Option<Preview<'a, T, NU>>,
    /// Sends a sequence only if it is worth it; `None` sends in every cycle.
    pub trigger: Option<Trigger<'a, T, NX, NU>>,
}

/// Why a design does not fit a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InvalidDesign {
    /// The gains' sequences are longer than the controller's capacity `N`, or than 255.
    Capacity,
    /// Gains, preview, trigger and actuator settings do not all name the same default input.
    DefaultInput,
    /// Measurements may be later than the controller's memory of `H` cycles reaches back.
    MeasurementBuffer,
    /// Gains for sequences of another length than those in flight, or preview or trigger for others than the gains.
    Length,
    /// The preview does not tell what the trigger must know.
    Preview,
}

/// Why a frame changed nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectedFrame {
    /// The bytes are neither a measurement nor an acknowledgement for this controller.
    Decode(DecodeError),
    /// The measurement in it is of no use.
    Measurement(RejectedMeasurement),
    /// The acknowledgement names a cycle that is not over, is too long ago, or a sequence that was never sent.
    Acknowledgement,
}

/// What a controller counted since its start; every count saturates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Frames that changed nothing.
    pub rejected_frames: u32,
    /// Cycles whose acknowledgement had not come when the next one began.
    pub unacknowledged: u32,
    /// Cycles in which no finite sequence could be computed, and none was sent.
    pub not_finite: u32,
    /// Cycles in which the sequence was not worth a packet, and none was sent.
    pub not_worth_sending: u32,
}

/// What the actuator is held to have played in one cycle.
#[derive(Debug, Clone, Copy)]
struct Played<T, const NU: usize> {
    acknowledged: bool,
    age: Age,
    /// After saturation.
    input: SVector<T, NU>,
}

/// The controller end of the link.
///
/// Each cycle: any number of [`Controller::receive`], [`Controller::follow`] if the reference has moved, then one
/// [`Controller::cycle`].
///
/// A cycle whose acknowledgement has not come is held to have played on without a new packet, until an
/// acknowledgement says otherwise. While the estimator remembers the cycle, it and those after it that are not
/// acknowledged themselves are corrected then: what is believed depends on which acknowledgements have come, not
/// on their order.
#[derive(Debug, Clone)]
pub struct Controller<
    'a,
    T: Scalar,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
> {
    design: Design<'a, T, NX, NU, NY>,
    kalman: Kalman<T, NX, NU, NY, H>,
    in_flight: InFlight<T, NU, N, H>,
    /// The last `H` cycles, newest first: with the one that the oldest remembered by the estimator follows.
    played: Deque<Played<T, NU>, H>,
    feedforward: Feedforward<T, NU, N>,
    counts: Counts,
}

impl<'a, T: Scalar, const NX: usize, const NU: usize, const NY: usize, const N: usize, const H: usize>
    Controller<'a, T, NX, NU, NY, N, H>
{
    /// A controller whose first cycle is `tick`.
    ///
    /// # Errors
    /// If the gains' sequences or the measurement buffer do not fit the capacities, or the actuator behaves unlike
    /// the gains assume.
    pub fn new(design: Design<'a, T, NX, NU, NY>, tick: Tick) -> Result<Self, InvalidDesign> {
        if design.gains.length() > N || design.gains.length() > usize::from(u8::MAX) {
            return Err(InvalidDesign::Capacity);
        }
        if design.gains.default_input() != design.actuator.default_input {
            return Err(InvalidDesign::DefaultInput);
        }
        if let Some(preview) = &design.preview {
            agree(&design, preview.length(), preview.default_input())?;
        }
        check_trigger(&design)?;
        if design.measurement_buffer >= H {
            return Err(InvalidDesign::MeasurementBuffer);
        }
        Ok(Self {
            kalman: Kalman::new(design.model, design.measurement_buffer, tick),
            in_flight: InFlight::default(),
            played: Deque::new(),
            feedforward: Feedforward::default(),
            counts: Counts::default(),
            design,
        })
    }

    /// Replaces the control law from the next cycle on: for time-varying gains, or gains for a link that has changed.
    /// Preview gains and trigger stay as they are.
    ///
    /// # Errors
    /// If the gains are for sequences of another length or for another default input; the law stays as it was.
    pub fn set_gains(&mut self, gains: Gains<'a, T, NX, NU>) -> Result<(), InvalidDesign> {
        agree(&self.design, gains.length(), gains.default_input())?;
        self.design.gains = gains;
        Ok(())
    }

    /// Replaces the trigger from the next cycle on: where a packet's cost changes, [`Trigger::with_send_cost`], or the law
    /// does; `None` sends in every cycle.
    ///
    /// # Errors
    /// If it does not fit the design; the one before stays.
    pub fn set_trigger(&mut self, trigger: Option<Trigger<'a, T, NX, NU>>) -> Result<(), InvalidDesign> {
        let design = Design { trigger, ..self.design };
        check_trigger(&design)?;
        self.design = design;
        Ok(())
    }

    /// Follows `reference`: the samples `z_{k+1}, z_{k+2}, ..`, where `k` is the cycle that [`Controller::cycle`] runs
    /// next.
    ///
    /// Samples beyond the design's preview change nothing, and of fewer the last one stands for those missing: a set point
    /// is one sample. The feedforward stays in force until the next call, so a reference that moves is handed over in
    /// every cycle. Before the first call the reference is zero.
    ///
    /// # Errors
    /// Says why the reference is not followed; the one before stays in force.
    pub fn follow<const NZ: usize>(&mut self, reference: &[SVector<T, NZ>]) -> Result<(), RejectedReference> {
        let preview = self.design.preview.as_ref().ok_or(RejectedReference::NoPreview)?;
        self.feedforward = preview.feedforward(reference)?;
        Ok(())
    }

    /// Sets the feedforward of the next cycle and those after it, where it was computed beforehand: for tasks of finite
    /// length, cycle by cycle along with [`Controller::set_gains`]. The design needs no preview for that.
    ///
    /// # Errors
    /// If it is not finite; the one before stays in force.
    pub fn set_feedforward(&mut self, feedforward: Feedforward<T, NU, N>) -> Result<(), RejectedReference> {
        if !feedforward.is_finite() {
            return Err(RejectedReference::NotFinite);
        }
        self.feedforward = feedforward;
        Ok(())
    }

    /// The cycle that [`Controller::cycle`] will run next.
    pub fn tick(&self) -> Tick {
        self.kalman.tick()
    }

    /// What was counted since the start.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The estimator; after [`Controller::cycle`] its posterior is that of the cycle that ran.
    pub fn estimator(&self) -> &Kalman<T, NX, NU, NY, H> {
        &self.kalman
    }

    /// Takes a measurement or acknowledgement frame from the link; any number of them, in any order.
    ///
    /// # Errors
    /// Says why the frame changed nothing. It is counted; there is nothing else to do.
    pub fn receive(&mut self, frame: &[u8]) -> Result<(), RejectedFrame> {
        let outcome = match wire::decode_measurement(frame) {
            Ok(measurement) => self.measured(measurement),
            Err(DecodeError::Kind(_)) => match wire::decode_acknowledgement::<T>(frame) {
                Ok(acknowledgement) => self.acknowledged(acknowledgement),
                Err(error) => Err(RejectedFrame::Decode(error)),
            },
            Err(error) => Err(RejectedFrame::Decode(error)),
        };
        if outcome.is_err() {
            count(&mut self.counts.rejected_frames);
        }
        outcome
    }

    fn measured(&mut self, measurement: Measurement<T, NY>) -> Result<(), RejectedFrame> {
        self.kalman.measure(measurement.tick, measurement.output).map_err(RejectedFrame::Measurement)
    }

    fn acknowledged(&mut self, acknowledgement: Acknowledgement) -> Result<(), RejectedFrame> {
        let Acknowledgement { tick, age } = acknowledgement;
        // Only cycles that are over can be acknowledged, while the estimator remembers them.
        let ago = self.kalman.tick().age_of(tick).and_then(|cycles| usize::try_from(cycles).ok());
        let ago = ago.filter(|ago| *ago > 0).ok_or(RejectedFrame::Acknowledgement)?;
        if self.kalman.input(tick).is_none() {
            return Err(RejectedFrame::Acknowledgement);
        }
        let input = self.applied_input(tick, age, ago + 1).ok_or(RejectedFrame::Acknowledgement)?;
        self.set_played(ago, Played { acknowledged: true, age, input });
        // The cycles since then play on from there, up to the next one that is known better.
        let mut age = age;
        for ago in (1..ago).rev() {
            let Some(&Played { acknowledged, age: known, .. }) = self.played_ago(ago) else { break };
            age = if acknowledged { known } else { age.played_on(self.design.gains.length()) };
            let tick = self.kalman.tick() - ago as u32;
            let input = self.applied_input(tick, age, ago + 1).unwrap_or_else(SVector::zeros);
            self.set_played(ago, Played { acknowledged, age, input });
        }
        if let Some(&Played { age, input, .. }) = self.played_ago(1) {
            self.in_flight.acknowledge(age, input);
        }
        Ok(())
    }

    /// What is held to have been played `ago >= 1` cycles ago.
    fn played_ago(&self, ago: usize) -> Option<&Played<T, NU>> {
        self.played.iter().nth(ago.checked_sub(1)?)
    }

    fn set_played(&mut self, ago: usize, played: Played<T, NU>) {
        if let Some(entry) = self.played.iter_mut().nth(ago - 1) {
            *entry = played;
        }
        self.kalman.set_input(self.kalman.tick() - ago as u32, played.input);
    }

    /// What left the actuator in cycle `tick` if it played `age`; `None` if no such sequence is remembered.
    /// `before` is how many cycles ago the one before `tick` was.
    fn applied_input(&self, tick: Tick, age: Age, before: usize) -> Option<SVector<T, NU>> {
        // Before the first cycle the actuator applied zero.
        let held = self.played_ago(before).map_or_else(SVector::zeros, |played| played.input);
        let input = self.in_flight.applied_input(self.design.actuator.default_input, tick, age, &held)?;
        Some(self.design.actuator.saturate(&input))
    }

    /// Runs one cycle: estimates the state, decides the sequence, and writes it as a frame into `buffer`.
    ///
    /// Returns the frame to send, [`wire::control_len`] bytes; `None` if nothing is to be sent: the sequence is not worth a
    /// packet, or no finite one came out, which costs the loop no more than a lost packet. Either is counted. The
    /// actuator needs no word of it: it plays on and acknowledges what it plays. Thesis (3.30), THEORY 3, 7.
    ///
    /// # Errors
    /// If `buffer` is too small for the frame. The cycle is over even so, as if the packet was lost.
    pub fn cycle<'b>(&mut self, buffer: &'b mut [u8]) -> Result<Option<&'b [u8]>, EncodeError> {
        if self.played_ago(1).is_some_and(|last| !last.acknowledged) {
            count(&mut self.counts.unacknowledged);
        }
        let tick = self.kalman.tick();
        self.kalman.filter(self.design.model);
        let expected = self.in_flight.expected_inputs(&self.design.gains);
        let mut inputs = self.design.gains.sequence(self.kalman.posterior_mean(), &expected);
        self.feedforward.add_to(&mut inputs);
        let sequence = ControlSequence { tick, inputs };
        let frame = if !sequence.is_finite() {
            count(&mut self.counts.not_finite);
            Ok(None)
        } else if !self.is_worth_sending(&sequence, &expected) {
            count(&mut self.counts.not_worth_sending);
            Ok(None)
        } else {
            wire::encode_control(&sequence, buffer).map(Some)
        };
        self.in_flight.push(matches!(frame, Ok(Some(_))).then_some(sequence));

        let age = self.in_flight.last_age().played_on(self.design.gains.length());
        let input = self.applied_input(tick, age, 1).unwrap_or_else(SVector::zeros);
        self.in_flight.acknowledge(age, input);
        push_newest(&mut self.played, Played { acknowledged: false, age, input });
        self.kalman.advance(self.design.model, input);
        frame
    }

    /// Without a trigger everything is.
    fn is_worth_sending(&self, sequence: &ControlSequence<T, NU, N>, expected: &[SVector<T, NU>]) -> bool {
        self.design.trigger.as_ref().is_none_or(|trigger| {
            let candidate = Candidate {
                posterior_mean: self.kalman.posterior_mean(),
                expected,
                inputs: &sequence.inputs,
                displaced: &self.feedforward.displaced,
            };
            trigger.is_worth_sending(trigger.benefit(&self.design.gains, &self.in_flight, candidate))
        })
    }
}

/// Whether a law for sequences of this length and default input fits the design.
fn agree<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    design: &Design<'_, T, NX, NU, NY>,
    length: usize,
    default_input: DefaultInput,
) -> Result<(), InvalidDesign> {
    if length != design.gains.length() {
        return Err(InvalidDesign::Length);
    }
    if default_input != design.actuator.default_input {
        return Err(InvalidDesign::DefaultInput);
    }
    Ok(())
}

/// Whether the trigger, if any, fits the law, and the preview, if any, tells it what it must know.
fn check_trigger<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    design: &Design<'_, T, NX, NU, NY>,
) -> Result<(), InvalidDesign> {
    let Some(trigger) = &design.trigger else { return Ok(()) };
    agree(design, trigger.length(), trigger.default_input())?;
    if design.preview.as_ref().is_some_and(|preview| !preview.serves_trigger()) {
        return Err(InvalidDesign::Preview);
    }
    Ok(())
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
