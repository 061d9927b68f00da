//! What a tuner tells its host, and as a frame says it.

use super::{Solved, Unsolved};
use crate::{
    Scalar,
    bank::InvalidLaw,
    wire::{Tuned, TuningStep},
};

/// Why the law in force stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kept {
    /// No gains were found for the link as it seems to be.
    Unsolved(Unsolved),
    /// What was found are no gains.
    Law(InvalidLaw),
}

impl core::fmt::Display for Kept {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Unsolved(why) => why.fmt(f),
            Self::Law(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for Kept {}

/// Something that the host may want to know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<T> {
    /// The link is not the one in force: this far from it, in the units of [`super::DelayEstimate::distance`]. Gains are being
    /// computed.
    Started {
        /// The distance.
        distance: T,
    },
    /// New gains are in force from the next cycle on.
    Switched(Solved<T>),
    /// They are not.
    Kept(Kept),
}

impl<T: Scalar> From<Event<T>> for Tuned {
    fn from(event: Event<T>) -> Self {
        // As precise as whoever reads it needs.
        let narrow = |value: T| value.widen() as f32;
        match event {
            Event::Started { distance } => {
                Self { step: TuningStep::Started, steps: 0, value: narrow(distance) }
            }
            Event::Switched(solved) => {
                Self { step: TuningStep::Switched, steps: solved.steps, value: narrow(solved.rate) }
            }
            Event::Kept(_) => Self { step: TuningStep::Kept, steps: 0, value: 0.0 },
        }
    }
}

/// What a tuner counted since its start; every count saturates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Solutions begun.
    pub started: u32,
    /// Laws put in force.
    pub switched: u32,
    /// Solutions that were not.
    pub kept: u32,
    /// Slices that did something.
    pub slices: u32,
}
