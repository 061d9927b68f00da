//! What a tuner tells its host.

use super::{Solved, Unsolved};
use crate::bank::InvalidLaw;

/// Why the law in force stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kept {
    /// No gains were found for the link as it seems to be.
    Unsolved(Unsolved),
    /// What was found are no gains.
    Law(InvalidLaw),
}

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
