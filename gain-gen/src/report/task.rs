//! What a task of finite length adds to a report: its laws, its cost, and why there is none.

use super::Report;
use crate::solve::{LoopProblem, Tracked, finite_horizon, tracking_task};

/// Most cycles of a task: more tables than these fill no device's flash.
pub const LONGEST_TASK: usize = 10_000;

/// Part of a task's cost below which a sum of squares is none.
const ROUNDING: f64 = 1e-20;

/// Why a design has no task of finite length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoTask {
    /// It follows a reference that nobody knows yet.
    #[error(
        "--horizon: tracking.reference is missing: the feedforward of a task is computed beforehand, from a reference \
         that is known; give its points in time"
    )]
    NoReference,
    /// It decides in every cycle whether to send.
    #[error(
        "--horizon: found [event]: what sending a packet is worth is known for a loop that goes on, not for a task \
         that ends; leave [event] out for a task"
    )]
    Event,
}

impl Report {
    /// Adds the gains of a task of `cycles` cycles, at least one, that ends with the terminal weight. Where the design
    /// tracks, the task follows the design's reference from its beginning.
    ///
    /// # Errors
    /// The design has a reference that is known at run time only, or sends only what is worth a packet.
    pub fn find_task(&mut self, cycles: usize) -> Result<(), NoTask> {
        let design = &self.design;
        if design.event.is_some() {
            return Err(NoTask::Event);
        }
        let problem = LoopProblem::of(design);
        self.task = Some(match (&design.tracking, Tracked::of(design)) {
            (Some(tracking), Some(tracked)) => {
                let at = |cycle| tracking.reference(cycle, design.plant.sample_time);
                let reference: Option<Vec<_>> = (0..=cycles).map(at).collect();
                tracking_task(&problem, &tracked, &reference.ok_or(NoTask::NoReference)?)
            }
            _ => finite_horizon(&problem, &design.cost.terminal, cycles),
        });
        Ok(())
    }

    /// Expected cost of the task with the state known, and with the reference known ahead where one is followed; `None`
    /// before [`Report::find_task`].
    pub fn task_cost(&self) -> Option<f64> {
        let plant = &self.design.plant;
        let task = self.task.as_ref()?;
        Some(task.control_cost(&plant.initial_mean, &plant.initial_covariance, &plant.process_noise))
    }

    /// What the task is expected to cost more if in each cycle the reference is taken to stay as it is; `None` before
    /// [`Report::find_task`], and if no reference is followed.
    pub fn surprise_cost(&self) -> Option<f64> {
        let surprise = self.task.as_ref()?.tracked.as_ref()?.surprise;
        // A sum of squares: what rounding leaves of a reference that does stay as it is.
        let is_none = surprise <= ROUNDING * self.task_cost()?.abs();
        Some(if is_none { 0.0 } else { surprise })
    }
}
