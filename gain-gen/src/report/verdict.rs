//! What the conditions come to: stable, unstable or undecided, and who is let through with that.

use super::{FailedCondition, NotStabilised, Report};
use crate::stability::{Growth, growth};

/// Whether the loop is shown to be mean-square stable as it runs: with its filter, its acknowledgements, the numbers on
/// the device and the limits of its inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It is: every condition holds.
    Stable,
    /// It is not: a condition fails.
    Unstable,
    /// No condition is known to fail, and one at least is not shown to hold.
    Undecided,
}

impl Verdict {
    /// As in reports and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Unstable => "unstable",
            Self::Undecided => "undecided",
        }
    }

    /// With these conditions failed or open.
    pub(crate) fn of(conditions: &[FailedCondition]) -> Self {
        if conditions.is_empty() {
            Self::Stable
        } else if conditions.iter().all(FailedCondition::is_open) {
            Self::Undecided
        } else {
            Self::Unstable
        }
    }
}

/// Why second moments stay bounded although inputs have limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitsShown {
    /// The plant comes back by itself.
    Decay,
    /// The one mode that does not decay, an integrator, is taken back by every input at its limit.
    Drift,
}

impl LimitsShown {
    /// As in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Decay => "decay",
            Self::Drift => "drift",
        }
    }
}

impl Report {
    /// Why the limits of inputs leave the loop bounded; `None` without limits, and where that is not shown.
    pub fn limits_shown_by(&self) -> Option<LimitsShown> {
        self.design.controller.input_limits.as_ref()?;
        let is_open = |condition: &FailedCondition| matches!(condition, FailedCondition::Limited { .. });
        if !self.solution.is_stabilising() || self.failed_conditions.iter().any(is_open) {
            return None;
        }
        Some(if growth(&self.design.plant) == Growth::Decays {
            LimitsShown::Decay
        } else {
            LimitsShown::Drift
        })
    }

    /// Whether the loop is shown to be stable as it runs.
    pub fn verdict(&self) -> Verdict {
        Verdict::of(&self.failed_conditions)
    }

    /// Whether the loop of the theorems is stable: the recursion converged, and measurements come often enough. Its
    /// acknowledgements are instant, its inputs without limits.
    pub fn converged(&self) -> bool {
        !self.failed_conditions.iter().any(FailedCondition::is_of_theorems)
    }

    /// Nothing if the loop is stable, otherwise the error that says why it is not.
    ///
    /// # Errors
    /// The verdict is not [`Verdict::Stable`].
    pub fn require_stable(&self) -> Result<(), NotStabilised> {
        if self.failed_conditions.is_empty() {
            return Ok(());
        }
        Err(NotStabilised {
            name: self.design.name.clone(),
            length: self.design.controller.sequence_length,
            default_input: self.design.controller.default_input,
            verdict: self.verdict(),
            conditions: self.failed_conditions.clone(),
        })
    }

    /// Lets [`crate::emit`] write the design although its stability is undecided; what is written says so.
    pub fn accept_undecided_stability(&mut self) {
        self.accepts_undecided_stability = true;
    }

    /// Nothing if the loop may be written for a device, otherwise why not.
    ///
    /// # Errors
    /// The loop is unstable, or undecided and that was not accepted.
    pub(crate) fn require_emittable(&self) -> Result<(), NotStabilised> {
        match self.verdict() {
            Verdict::Undecided
                if self.accepts_undecided_stability
                    && !self.failed_conditions.iter().any(FailedCondition::leaves_no_gains) =>
            {
                Ok(())
            }
            _ => self.require_stable(),
        }
    }
}
