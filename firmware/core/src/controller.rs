//! `Controller`: one control cycle, measurement and acknowledgement frames in, control frame out.
//!
//! It ties the rooms together and decides nothing itself: the estimate is [`crate::estimator`]'s, the
//! expected inputs [`crate::in_flight`]'s, the law [`crate::gains`]', the bytes [`crate::wire`]'s.

use crate::{
    Scalar, Tick,
    actuator::{Age, Settings},
    estimator::{Kalman, Model, RejectedMeasurement},
    gains::Gains,
    in_flight::InFlight,
    sequence::ControlSequence,
    wire::{self, Acknowledgement, DecodeError, EncodeError, Measurement},
};
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
}

/// Why a design does not fit a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InvalidDesign {
    /// The gains' sequences are longer than the controller's capacity `N`, or than 255.
    Capacity,
    /// Gains and actuator settings name different default inputs.
    DefaultInput,
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
}

/// The controller end of the link.
///
/// Each cycle: any number of [`Controller::receive`], then one [`Controller::cycle`].
///
/// A cycle whose acknowledgement has not come is held to have played on without a new packet, until an
/// acknowledgement says otherwise; while the estimator remembers the cycle it is corrected then.
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
    in_flight: InFlight<T, NU, N>,
    /// Whether the last cycle is acknowledged; true before the first, which has nothing to acknowledge.
    acknowledged: bool,
    counts: Counts,
}

impl<'a, T: Scalar, const NX: usize, const NU: usize, const NY: usize, const N: usize, const H: usize>
    Controller<'a, T, NX, NU, NY, N, H>
{
    /// A controller whose first cycle is `tick`.
    ///
    /// # Errors
    /// If the gains' sequences do not fit the capacity or the actuator behaves unlike the gains assume.
    pub fn new(design: Design<'a, T, NX, NU, NY>, tick: Tick) -> Result<Self, InvalidDesign> {
        if design.gains.length() > N || design.gains.length() > usize::from(u8::MAX) {
            return Err(InvalidDesign::Capacity);
        }
        if design.gains.default_input() != design.actuator.default_input {
            return Err(InvalidDesign::DefaultInput);
        }
        Ok(Self {
            kalman: Kalman::new(design.model, design.measurement_buffer, tick),
            in_flight: InFlight::default(),
            acknowledged: true,
            counts: Counts::default(),
            design,
        })
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
        // Only cycles that are over can be acknowledged.
        if !self.kalman.tick().is_after(tick) {
            return Err(RejectedFrame::Acknowledgement);
        }
        let input = self.applied_input(tick, age).ok_or(RejectedFrame::Acknowledgement)?;
        if !self.kalman.set_input(tick, input) {
            return Err(RejectedFrame::Acknowledgement);
        }
        if tick + 1 == self.kalman.tick() {
            self.in_flight.acknowledge(age, input);
            self.acknowledged = true;
        }
        Ok(())
    }

    /// What left the actuator in cycle `tick` if it played `age`; `None` if no such sequence is remembered.
    fn applied_input(&self, tick: Tick, age: Age) -> Option<SVector<T, NU>> {
        let held = self.kalman.input(tick - 1).copied().unwrap_or_else(SVector::zeros);
        let input = self.in_flight.applied_input(self.design.actuator.default_input, tick, age, &held)?;
        Some(self.design.actuator.saturate(&input))
    }

    /// Runs one cycle: estimates the state, decides the sequence, and writes it as a frame into `buffer`.
    ///
    /// Returns the frame to send, [`wire::control_len`] bytes; `None` if no finite sequence came out, which is
    /// counted and costs the loop no more than a lost packet. Thesis (3.30), THEORY 3.
    ///
    /// # Errors
    /// If `buffer` is too small for the frame. The cycle is over even so, as if the packet was lost.
    pub fn cycle<'b>(&mut self, buffer: &'b mut [u8]) -> Result<Option<&'b [u8]>, EncodeError> {
        if !self.acknowledged {
            count(&mut self.counts.unacknowledged);
        }
        let tick = self.kalman.tick();
        self.kalman.filter(self.design.model);
        let expected = self.in_flight.expected_inputs(&self.design.gains);
        let inputs = self.design.gains.sequence(self.kalman.posterior_mean(), &expected);
        let sequence = ControlSequence { tick, inputs };
        let frame = if sequence.is_finite() {
            wire::encode_control(&sequence, buffer).map(Some)
        } else {
            count(&mut self.counts.not_finite);
            Ok(None)
        };
        self.in_flight.push(matches!(frame, Ok(Some(_))).then_some(sequence));

        let age = self.in_flight.last_age().played_on(self.design.gains.length());
        let input = self.applied_input(tick, age).unwrap_or_else(SVector::zeros);
        self.in_flight.acknowledge(age, input);
        self.kalman.advance(self.design.model, input);
        self.acknowledged = false;
        frame
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}
