//! What of a report is emitted, and which loops are not.

use super::{FailedCondition, NotStabilised, Report, Verdict};
use crate::design::Misfit;
use crate::emit::{Emission, Figures, Standing, TaskGains};
use crate::solve::PreviewTooLong;

/// Why a design is not emitted in any format.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotEmittable {
    /// The loop is not shown to be stable.
    #[error("{0}{advice}", advice = advice(.0))]
    NotStabilised(#[from] NotStabilised),
    /// The preview that the design asks for is too long.
    #[error(transparent)]
    Preview(#[from] PreviewTooLong),
    /// The frames are too long for what is to carry them.
    #[error(transparent)]
    Wire(#[from] Misfit),
}

/// What lets an undecided loop through. Nothing does with an unstable one.
fn advice(refused: &NotStabilised) -> &'static str {
    match refused.verdict {
        Verdict::Undecided if !refused.conditions.iter().any(FailedCondition::leaves_no_gains) => {
            "\n  nothing is written unless that is accepted: --accept-undecided-stability, or in build scripts \
             Compile::accept_undecided_stability"
        }
        Verdict::Stable | Verdict::Unstable | Verdict::Undecided => "",
    }
}

impl Report {
    /// What [`crate::emit`] writes: the task if there is one, otherwise the law of the loop that goes on.
    ///
    /// # Errors
    /// Frames do not fit. A loop that goes on is not shown to be stable and that was not accepted, or its preview is too
    /// long; a task that ends needs neither.
    pub fn emission(&self) -> Result<Emission<'_>, NotEmittable> {
        self.design.misfit().map_or(Ok(()), Err)?;
        if self.task.is_none() {
            self.require_emittable()?;
            self.require_preview()?;
        }
        let goes_on = self.task.is_none();
        let unacknowledged = self.unacknowledged.as_ref().filter(|_| goes_on);
        Ok(Emission {
            design: &self.design,
            law: if goes_on { self.law() } else { &self.solution.law },
            unacknowledged,
            is_mixed: goes_on && self.solution.unknown_weight > 0.0,
            preview: self.preview.as_ref().and_then(|gains| gains.as_ref().ok()).filter(|_| goes_on),
            scheduled: self.scheduled.as_ref().filter(|_| goes_on),
            trigger: self.trigger.as_ref().filter(|_| goes_on),
            task: self.task.as_ref().map(|gains| TaskGains {
                gains,
                cost: self.task_cost().unwrap_or(f64::NAN),
                surprise_cost: self.surprise_cost(),
            }),
            standing: self.standing(),
            mean_square_rate: self.mean_square_rate(),
            time_constant: self.time_constant(),
            control_cost: unacknowledged.map_or_else(|| self.control_cost(), |found| found.cost),
            figures: self,
        })
    }

    fn standing(&self) -> Standing {
        match (&self.task, self.verdict()) {
            (Some(task), _) => Standing::Ends { cycles: task.laws.len() },
            (None, Verdict::Stable) => Standing::Stable,
            (None, verdict) => Standing::Accepted {
                verdict: verdict.name(),
                open: self.failed_conditions.iter().map(ToString::to_string).collect(),
            },
        }
    }
}

impl Figures for Report {
    fn to_json(&self) -> String {
        self.to_json()
    }
}
