//! What a slice of a solution comes to.

/// Gains that were found, and what is known about them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solved<T> {
    /// Backward steps to the fixed point.
    pub steps: u32,
    /// Steps under the gains until the proof held.
    pub proof_steps: u32,
    /// Relative residual of the fixed-point equation at the last step.
    pub residual: T,
    /// Bound on the mean-square rate of the closed loop with these gains; below 1. See `docs/self-tuning.md`.
    pub rate: T,
}

/// Why no gains were found that may be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Unsolved {
    /// The cost-to-go grew until it overflowed: the link cannot carry the loop.
    Diverged,
    /// The residual was still falling when the steps allowed were over.
    NotConverged,
    /// The steps allowed were over before the cost-to-go was proved to fall under the gains found.
    NotProved,
}

impl core::fmt::Display for Unsolved {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Diverged => "the cost-to-go grew until it overflowed: the link cannot carry the loop",
            Self::NotConverged => "the gains had not settled when the steps allowed were over",
            Self::NotProved => {
                "the steps allowed were over before the gains were proved to stabilise the loop"
            }
        })
    }
}

impl core::error::Error for Unsolved {}

/// What a slice came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress<T> {
    /// There is nothing to do.
    Idle,
    /// There is more to do.
    Working,
    /// The gains are there: [`super::Solver::write_law`].
    Solved(Solved<T>),
    /// There are none.
    Unsolved(Unsolved),
}
