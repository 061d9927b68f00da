//! A law that may change while the controller runs, and what goes wrong when it does not fit.

use super::InvalidDesign;
use crate::{gains::Gains, wire::EncodeError};

/// What of a [`super::Design`] belongs to the link, and changes with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law<'a, T, const NX: usize, const NU: usize> {
    /// The control law.
    pub gains: Gains<'a, T, NX, NU>,
    /// Probability that a sequence arrives in the cycle it was sent in, `q(0)`.
    pub arrives_at_once: T,
}

/// Why a cycle under another law than the design's brought no frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CycleError {
    /// The law does not fit the design. The cycle has not been run.
    Law(InvalidDesign),
    /// The frame could not be written. The cycle is over.
    Encode(EncodeError),
}

impl core::fmt::Display for CycleError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Law(why) => why.fmt(f),
            Self::Encode(why) => why.fmt(f),
        }
    }
}

impl core::error::Error for CycleError {}
