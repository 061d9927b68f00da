//! What a controller is told at design time, and whether it fits together.
//!
//! What it does with it is in the parent module; where it comes from, the generator's business.

use super::{Law, Sizes};
use crate::{
    Scalar,
    actuator::Settings,
    estimator::{Merging, Model, Plausibility},
    event::Trigger,
    gains::Gains,
    played::DefaultInput,
    tracking::Preview,
    wire::can::Grid,
};

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
    /// Most cycles ago that an acknowledgement may tell of and still count; 1 is the cycle before.
    pub acknowledgement_buffer: usize,
    /// What a reference adds to the law; `None` where the state is controlled to zero.
    pub preview: Option<Preview<'a, T, NU>>,
    /// Sends a sequence only if it is worth it; `None` sends in every cycle.
    pub trigger: Option<Trigger<'a, T, NX, NU>>,
    /// Probability that a sequence arrives in the cycle it was sent in, `q(0)`. With the gains' arrival probabilities it
    /// says what may have been played where no acknowledgement does.
    pub arrives_at_once: T,
    /// What the estimator keeps apart while no acknowledgement decides.
    pub merging: Merging,
    /// What is believed of the measurements, and when the loop is lost.
    pub plausibility: &'a Plausibility<T, NY>,
    /// What inputs are rounded to before they are remembered and sent, where the carrier counts them; `None` sends them as
    /// they are computed.
    pub grid: Option<Grid<T, NU>>,
}

/// Why a design does not fit a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum InvalidDesign {
    /// The gains' sequences are longer than 255 inputs.
    Capacity,
    /// Gains, preview, trigger and actuator settings do not all name the same default input.
    DefaultInput,
    /// There is less memory than this; or, where a controller is restarted, not just as much.
    Memory(Sizes),
    /// Gains for sequences of another length than those in flight, or preview or trigger for others than the gains.
    Length,
    /// The preview does not tell what the trigger must know, or the trigger takes later packets to go out at fixed times, and knows of
    /// no reference.
    Preview,
    /// The probability to arrive at once is not within 0..=1.
    NotAProbability,
    /// Inputs may change so much in a cycle only, and ages are kept apart: what was applied before is remembered once for all.
    Rates,
    /// The linear estimator, in a program that was built without the feature `linear`.
    Feature,
    /// An event trigger weighs ages, and preview gains go with a law for known ages: neither goes with the linear estimator.
    Linear,
    /// The gate is not positive, or the range of an output empty.
    Plausibility,
    /// A step of the grid is not positive, or a value on it not finite.
    Grid,
}

impl core::fmt::Display for InvalidDesign {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Capacity => f.write_str("sequences of more than 255 inputs; a frame counts no more"),
            Self::DefaultInput => {
                f.write_str("gains, preview, trigger and actuator must all name the same default input")
            }
            Self::Memory(needed) => write!(f, "the design takes other memory than there is: {needed}"),
            Self::Length => {
                f.write_str("gains, preview and trigger must be for sequences of the same length")
            }
            Self::Preview => {
                f.write_str("a trigger needs a preview that tells what the inputs in flight are worth, and one over a schedule takes none")
            }
            Self::NotAProbability => f.write_str("the probability to arrive at once is not within 0..=1"),
            Self::Rates => f.write_str("rate limits of inputs go with one estimate for all ages only"),
            Self::Feature => f.write_str("the linear estimator takes a build with the feature `linear`"),
            Self::Linear => f.write_str(
                "trigger and preview do not go with an estimator that is told the mean input only",
            ),
            Self::Plausibility => f.write_str("the gate is not positive, or the range of an output is empty"),
            Self::Grid => {
                f.write_str("a step of the grid is not positive, or so large that values are not finite")
            }
        }
    }
}

impl core::error::Error for InvalidDesign {}

impl<'a, T: Scalar, const NX: usize, const NU: usize, const NY: usize> Design<'a, T, NX, NU, NY> {
    /// What of it belongs to the link.
    pub fn law(&self) -> Law<'a, T, NX, NU> {
        Law { gains: self.gains, arrives_at_once: self.arrives_at_once }
    }

    /// Cycles that the estimator has to remember, the current one included: as late as measurements and acknowledgements may
    /// be, and the cycle before, whose input becomes known in the current one.
    pub const fn history(&self) -> usize {
        let (measured, told) = (self.measurement_buffer, self.acknowledgement_buffer);
        let late = if measured > told { measured } else { told };
        // Who remembers more than there will ever be needs more memory than there is.
        if late > 1 { late.saturating_add(1) } else { 2 }
    }

    /// Numbers to work in that the trigger takes.
    pub(super) fn numbers(&self) -> usize {
        self.trigger.as_ref().map_or(0, Trigger::numbers_len)
    }

    /// Memory that a controller of this design is lent.
    pub fn sizes(&self) -> Sizes {
        let length = self.gains.length();
        if self.merging.is_linear() {
            return Sizes::linear(length, self.history());
        }
        Sizes::of(length, self.history(), self.merging.estimates(length)).with_numbers(self.numbers())
    }

    /// Whether everything fits together.
    pub(super) fn check(&self) -> Result<(), InvalidDesign> {
        if self.gains.length() > usize::from(u8::MAX) {
            return Err(InvalidDesign::Capacity);
        }
        if self.gains.default_input() != self.actuator.default_input {
            return Err(InvalidDesign::DefaultInput);
        }
        if let Some(preview) = &self.preview {
            self.check_law(preview.length(), preview.default_input())?;
        }
        self.check_trigger()?;
        // NaN is outside.
        if !(T::zero()..=T::one()).contains(&self.arrives_at_once) {
            return Err(InvalidDesign::NotAProbability);
        }
        if matches!(self.merging, Merging::Linear) && !self.merging.is_linear() {
            return Err(InvalidDesign::Feature);
        }
        if self.merging.is_linear() && (self.trigger.is_some() || self.preview.is_some()) {
            return Err(InvalidDesign::Linear);
        }
        if self.actuator.rate().is_some() && self.merging != Merging::Single {
            return Err(InvalidDesign::Rates);
        }
        if !self.plausibility.is_valid() {
            return Err(InvalidDesign::Plausibility);
        }
        if self.grid.as_ref().is_some_and(|grid| !grid.is_valid()) {
            return Err(InvalidDesign::Grid);
        }
        Ok(())
    }

    /// Whether a law for sequences of this length and default input fits.
    pub(super) fn check_law(&self, length: usize, default_input: DefaultInput) -> Result<(), InvalidDesign> {
        if length != self.gains.length() {
            return Err(InvalidDesign::Length);
        }
        if default_input != self.actuator.default_input {
            return Err(InvalidDesign::DefaultInput);
        }
        Ok(())
    }

    /// Whether the trigger, if any, fits the law, and the preview, if any, tells it what it must know.
    pub(super) fn check_trigger(&self) -> Result<(), InvalidDesign> {
        let Some(trigger) = &self.trigger else { return Ok(()) };
        self.check_law(trigger.length(), trigger.default_input())?;
        if self
            .preview
            .as_ref()
            .is_some_and(|preview| !preview.serves_trigger() || !trigger.follows_reference())
        {
            return Err(InvalidDesign::Preview);
        }
        Ok(())
    }
}
