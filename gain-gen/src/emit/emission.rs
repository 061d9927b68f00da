//! What is emitted: gains, the model of the plant and the settings of both nodes, with what is to be said of them.

use super::standing::Standing;
use crate::design::Design;
use crate::solve::{FiniteHorizon, Law, PreviewGains, Scheduled, TriggerTables, Unacknowledged};
use nalgebra::DMatrix;
use slqg::estimator::Merging;

/// A solved design that may be written; [`crate::report::Report::emission`] makes it.
#[derive(Clone)]
pub struct Emission<'r> {
    /// Plant and noise, the settings of both nodes, and what the gains were computed from.
    pub design: &'r Design,
    /// The law of a loop that goes on.
    pub law: &'r Law,
    /// What it is for a loop without acknowledgements; `None` for others.
    pub unacknowledged: Option<&'r Unacknowledged>,
    /// Whether the law is a mixture for acknowledgements that come late or are lost: [`crate::solve::Solution::for_acknowledgements`].
    pub is_mixed: bool,
    /// What a reference adds to it; `None` if the design follows none, or with a task.
    pub preview: Option<&'r PreviewGains>,
    /// The schedule that packets follow, or are taken to follow later; `None` if they are taken to be sent in every cycle, or with a task.
    pub scheduled: Option<&'r Scheduled>,
    /// What sending a packet is worth; `None` if the design sends in every cycle, or with a task.
    pub trigger: Option<&'r TriggerTables>,
    /// Time-varying gains in the place of the law.
    pub task: Option<TaskGains<'r>>,
    /// What is shown of the loop's stability.
    pub standing: Standing,
    /// Factor by which second moments change per cycle, with the state and every age known; without acknowledgements of the whole loop.
    pub mean_square_rate: f64,
    /// Cycles in which they fall to 1/e; `None` if they do not fall.
    pub time_constant: Option<f64>,
    /// Long-run cost per cycle, likewise; of a mixed law that of the best one for known ages, which is no higher.
    pub control_cost: f64,
    /// What JSON tells beside them.
    pub figures: &'r dyn Figures,
}

impl Emission<'_> {
    /// What the estimator keeps apart: with the law of a task, as with one for known ages, the spread of the input is its own.
    pub(super) fn merging(&self) -> Merging {
        match self.design.estimator() {
            Merging::Linear if self.unacknowledged.is_none() => Merging::Single,
            merging => merging,
        }
    }

    /// `W` as the filter is told it, `nx x nx`: without acknowledgements it contains what inputs are uncertain by.
    pub(super) fn process_noise(&self) -> DMatrix<f64> {
        let plant = &self.design.plant;
        match self.unacknowledged {
            Some(found) => found.filter_noise(plant),
            None => plant.process_noise.clone(),
        }
    }

    /// Under which conditions a generated file's rate and cost are those of the loop, and of which gains the cost is.
    pub(super) fn conditions(&self) -> (&'static str, &'static str) {
        match (self.unacknowledged.is_some(), self.is_mixed) {
            (true, _) => ("In the loop with its filter", ""),
            (false, true) => ("With the state and every age known", " with gains made for that"),
            (false, false) => ("With the state known", ""),
        }
    }

    /// Expected inputs that the law takes, `n_v`.
    pub(super) fn in_flight(&self) -> usize {
        self.law.default_input.in_flight(self.law.length)
    }
}

/// The gains of a task of finite length, and what it is expected to cost with the state known.
#[derive(Debug, Clone, Copy)]
pub struct TaskGains<'r> {
    /// One law a cycle, and the feedforward where a reference is followed.
    pub gains: &'r FiniteHorizon,
    /// The terminal cost included.
    pub cost: f64,
    /// What it costs more if in each cycle the reference is taken to stay as it is; `None` if none is followed.
    pub surprise_cost: Option<f64>,
}

/// Figures of a design for its JSON.
pub trait Figures {
    /// One JSON object with each field on its own line, and a newline at the end.
    fn to_json(&self) -> String;
}
