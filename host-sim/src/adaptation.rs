//! What a run costs before its link changes, while a controller adapts to that, and after.
//!
//! Costs are per cycle, without the terminal term, so that windows of different lengths compare. How the link changes is
//! [`crate::contender::Change`]'s business; without a change there are no windows.

use crate::{
    contender::{Change, Contender},
    sample::{mean, standard_error},
};
use serde::Serialize;
use slqg::tuning::Event;

/// Cycles at which the windows end, in a run of `steps` cycles: the change, half of what is left after it, the end.
pub(crate) fn ends(change: &Change, steps: usize) -> [usize; 3] {
    let at = change.cycle.min(steps);
    [at, at + (steps - at) / 2, steps]
}

/// One run, window by window, and what the controller's tuner did in it.
#[derive(Debug, Clone)]
pub struct RunWindows {
    ends: [usize; 3],
    costs: [f64; 3],
    started: usize,
    switched: usize,
    kept: usize,
}

impl RunWindows {
    /// For a run of `steps` cycles of `contender`; `None` if its link does not change.
    pub fn new(contender: &Contender, steps: usize) -> Option<Self> {
        let ends = ends(contender.change.as_ref()?, steps);
        Some(Self { ends, costs: [0.0; 3], started: 0, switched: 0, kept: 0 })
    }

    /// Takes cycle `cycle`, of this cost, in which a tuner did this.
    pub fn add<T>(&mut self, cycle: usize, cost: f64, event: Option<&Event<T>>) {
        if let Some(window) = self.ends.iter().position(|end| cycle < *end) {
            self.costs[window] += cost;
        }
        match event {
            None => {}
            Some(Event::Started { .. }) => self.started += 1,
            Some(Event::Switched(_)) => self.switched += 1,
            Some(Event::Kept(_)) => self.kept += 1,
        }
    }

    fn per_cycle(&self, window: usize) -> f64 {
        let begin = window.checked_sub(1).map_or(0, |before| self.ends[before]);
        self.costs[window] / (self.ends[window] - begin) as f64
    }
}

/// Cost per cycle in one window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WindowCost {
    /// Mean over the runs.
    pub mean_cost: Option<f64>,
    /// Standard error of the mean.
    pub std_error: Option<f64>,
}

/// All runs of one controller, window by window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Adaptation {
    /// Until the link changes.
    pub before: WindowCost,
    /// In the first half of what is left.
    pub adapting: WindowCost,
    /// In the second half.
    pub after: WindowCost,
    /// Solutions that a controller which tunes itself began, per run.
    pub solutions: f64,
    /// Laws that it put in force, per run.
    pub switches: f64,
    /// Solutions after which it kept the law in force, per run.
    pub kept: f64,
}

impl Adaptation {
    /// Of runs on a link that changes; `None` of none.
    pub fn of(runs: &[RunWindows]) -> Option<Self> {
        let finite = |value: f64| value.is_finite().then_some(value);
        let window = |window: usize| {
            let costs: Vec<f64> = runs.iter().map(|run| run.per_cycle(window)).collect();
            WindowCost { mean_cost: finite(mean(&costs)), std_error: finite(standard_error(&costs)) }
        };
        let per_run =
            |of: fn(&RunWindows) -> usize| runs.iter().map(of).sum::<usize>() as f64 / runs.len() as f64;
        (!runs.is_empty()).then(|| Self {
            before: window(0),
            adapting: window(1),
            after: window(2),
            solutions: per_run(|run| run.started),
            switches: per_run(|run| run.switched),
            kept: per_run(|run| run.kept),
        })
    }
}
