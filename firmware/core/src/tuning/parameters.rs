//! How a tuner goes about it, and why there may be none.

use crate::synthesis::InvalidProblem;

/// How a tuner goes about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Parameters {
    /// Cycles in which what was observed fades to `1/e`.
    pub memory: u32,
    /// Packets that the design's distribution counts for.
    pub prior_packets: u32,
    /// A link that has not changed is solved for again with a probability of `exp(-caution)` at most, at each look.
    pub caution: u32,
    /// Backward steps until it is given up, and as many for the proof.
    pub most_steps: u32,
}

impl Parameters {
    /// Ten seconds of memory at 50 Hz, far less than one false alarm in a million looks.
    pub const DEFAULT: Self = Self { memory: 500, prior_packets: 10, caution: 10, most_steps: 4000 };
}

impl Default for Parameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Why there can be no tuner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum InvalidTuner {
    /// The design follows a reference: its preview gains would stay those of the old link.
    Preview,
    /// The design has an event trigger: its tables would stay those of the old link.
    Trigger,
    /// The basis is for sequences of another length than the design's, or for another default input.
    Basis,
    /// The memory is shorter than [`super::tuner_len`], or something of the basis is.
    Problem(InvalidProblem),
    /// The memory in cycles is zero.
    Parameters,
}

impl core::fmt::Display for InvalidTuner {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Preview => {
                f.write_str("the design follows a reference, whose preview gains a tuner does not solve for")
            }
            Self::Trigger => {
                f.write_str("the design has an event trigger, whose tables a tuner does not solve for")
            }
            Self::Basis => f.write_str("the basis is of another length or default input than the design"),
            Self::Problem(problem) => problem.fmt(f),
            Self::Parameters => f.write_str("the memory must be one cycle at least"),
        }
    }
}

impl core::error::Error for InvalidTuner {}
