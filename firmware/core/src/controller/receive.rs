//! Frames in: measurements and acknowledgements, and why one changes nothing.

use super::{Controller, count};
use crate::{
    Scalar, Tick,
    estimator::RejectedMeasurement,
    played::Age,
    wire::{self, Acknowledgement, DecodeError, Kind, MOST_AGES, Measurement},
};
use nalgebra::SVector;

/// Why a frame changed nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RejectedFrame {
    /// The bytes are neither a measurement nor an acknowledgement for this controller.
    Decode(DecodeError),
    /// The measurement in it is of no use to the estimate. If it is newer than those before, what it tells of its sensor
    /// ([`Controller::health`]) is kept all the same.
    Measurement(RejectedMeasurement),
    /// No reading of the measurement is within the sensor's range, or all are of sensors that are stuck. What it tells of its
    /// sensor is kept.
    Implausible,
    /// The acknowledgement names a cycle that is not over, is too long ago, or a sequence that was never sent.
    Acknowledgement,
}

impl core::fmt::Display for RejectedFrame {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Decode(why) => why.fmt(f),
            Self::Measurement(why) => why.fmt(f),
            Self::Implausible => {
                f.write_str("a measurement whose readings are all out of range, or of sensors that are stuck")
            }
            Self::Acknowledgement => f.write_str(
                "an acknowledgement of a cycle that is not over or too long ago, or of a sequence that was not sent",
            ),
        }
    }
}

impl core::error::Error for RejectedFrame {}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Controller<'_, T, NX, NU, NY> {
    /// Takes a measurement or acknowledgement frame from the link; any number of them, in any order.
    ///
    /// # Errors
    /// Says why the frame changed nothing. It is counted; there is nothing else to do.
    pub fn receive(&mut self, frame: &[u8]) -> Result<(), RejectedFrame> {
        // What it says it is picks the decoder, which checks all of it: once.
        let taken = match Kind::of(frame) {
            Some(Kind::Acknowledgement) => {
                wire::decode_acknowledgement::<T>(frame).map(|taken| self.acknowledged(&taken))
            }
            _ => wire::decode_measurement(frame).map(|taken| self.measured(&taken)),
        };
        taken.unwrap_or_else(|error| self.counted(Err(RejectedFrame::Decode(error))))
    }

    /// Takes a measurement that came some other way than as bytes. An output that is no finite number is not measured.
    ///
    /// # Errors
    /// Says why it changed nothing. It is counted.
    pub fn measured(&mut self, measurement: &Measurement<T, NY>) -> Result<(), RejectedFrame> {
        let seen = self.watch.sees(self.design.plausibility, measurement, self.filter.tick());
        let taken = match self.filter.measure(measurement.tick, seen) {
            // Nothing of it is left, though there was something in it.
            Err(RejectedMeasurement::NotFinite)
                if measurement.output.iter().any(|value| value.is_finite()) =>
            {
                Err(RejectedFrame::Implausible)
            }
            taken => taken.map_err(RejectedFrame::Measurement),
        };
        self.counted(taken)
    }

    /// Takes an acknowledgement that came some other way than as bytes.
    ///
    /// # Errors
    /// Says why it changed nothing. It is counted.
    pub fn acknowledged(&mut self, acknowledgement: &Acknowledgement) -> Result<(), RejectedFrame> {
        let is_taken = self.take_acknowledgement(acknowledgement);
        self.counted(if is_taken { Ok(()) } else { Err(RejectedFrame::Acknowledgement) })
    }

    fn take_acknowledgement(&mut self, acknowledgement: &Acknowledgement) -> bool {
        let Acknowledgement { tick, ages } = acknowledgement;
        if self.design.merging.is_linear() {
            return false;
        }
        // Only cycles that are over can be acknowledged, while the estimator remembers them.
        let Some(newest) = self.filter.position_over(*tick) else { return false };
        let remembered = ages.get(..=newest).unwrap_or(ages);
        let mut news: heapless::Vec<(Tick, Age), MOST_AGES> = heapless::Vec::new();
        for (ago, age) in remembered.iter().enumerate() {
            // Most of what it tells was told before, and found to be right then.
            if self.filter.known_at(newest - ago) == Some(*age) {
                continue;
            }
            let (played, default_input) = (*tick - ago as u32, self.design.actuator.default_input);
            if self.in_flight.applied_input(default_input, played, *age, &SVector::zeros()).is_none() {
                return false;
            }
            // There is room for all.
            let _ = news.push((played, *age));
        }
        for (played, age) in &news {
            self.filter.acknowledge(*played, *age);
        }
        !remembered.is_empty()
    }

    fn counted(&mut self, outcome: Result<(), RejectedFrame>) -> Result<(), RejectedFrame> {
        if outcome.is_err() {
            count(&mut self.counts.rejected_frames);
        }
        outcome
    }
}
