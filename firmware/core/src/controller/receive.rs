//! Frames in: measurements and acknowledgements, and why one changes nothing.

use super::{Controller, count};
use crate::{
    Scalar,
    estimator::RejectedMeasurement,
    wire::{self, Acknowledgement, DecodeError, Measurement},
};
use nalgebra::SVector;

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
    /// Takes a measurement or acknowledgement frame from the link; any number of them, in any order.
    ///
    /// # Errors
    /// Says why the frame changed nothing. It is counted; there is nothing else to do.
    pub fn receive(&mut self, frame: &[u8]) -> Result<(), RejectedFrame> {
        let outcome = match wire::decode_measurement(frame) {
            Ok(measurement) => self.measured(measurement),
            Err(DecodeError::Kind(_)) => match wire::decode_acknowledgement::<T>(frame) {
                Ok(acknowledgement) => self.acknowledged(&acknowledgement),
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
        self.filter.measure(measurement.tick, measurement.output).map_err(RejectedFrame::Measurement)
    }

    fn acknowledged(&mut self, acknowledgement: &Acknowledgement) -> Result<(), RejectedFrame> {
        let told = || (0..).zip(&acknowledgement.ages).map(|(ago, age)| (acknowledgement.tick - ago, *age));
        // Only cycles that are over can be acknowledged, while the estimator remembers them.
        let remembered = told().take_while(|(tick, _)| self.filter.is_acknowledged(*tick).is_some()).count();
        let default_input = self.design.actuator.default_input;
        let sent = |tick, age| self.in_flight.applied_input(default_input, tick, age, &SVector::zeros());
        if remembered == 0 || told().take(remembered).any(|(tick, age)| sent(tick, age).is_none()) {
            return Err(RejectedFrame::Acknowledgement);
        }
        for (tick, age) in told().take(remembered) {
            self.filter.acknowledge(tick, age);
        }
        Ok(())
    }
}
