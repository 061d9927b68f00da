//! What runs come to together: costs, their spread, ages and packets.

use crate::{
    adaptation::Adaptation,
    closed_loop::{CycleRecord, RunResult},
    contender::{Contender, Kind},
    losses::Losses,
    sample::{mean, quantile, standard_error},
};
use serde::Serialize;
use slqg_links::loop_bus::LoopBus;

/// One controller's results over all runs. Costs are thesis (3.16) or (4.2), summed over a run.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// Name of the controller.
    pub controller: &'static str,
    /// Inputs per sequence.
    pub sequence_length: usize,
    /// Mean cost of a run.
    pub mean_cost: Option<f64>,
    /// Standard error of the mean.
    pub std_error: Option<f64>,
    /// Half of the runs cost less.
    pub median_cost: Option<f64>,
    /// 95 % of the runs cost less.
    pub p95_cost: Option<f64>,
    /// The most expensive run.
    pub worst_cost: Option<f64>,
    /// Runs whose state left 1e6 times its initial or noise scale.
    pub diverged: usize,
    /// Control frames sent per cycle.
    pub send_rate: f64,
    /// Mean age of the applied inputs in cycles; an empty buffer counts as the sequence length.
    pub mean_input_age: f64,
    /// Mean cost of a run with what its packets cost, thesis (5.1); only where the design prices packets.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_total_cost: Option<f64>,
    /// Standard error of that mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub total_std_error: Option<f64>,
    /// Costs before and after; only where the link to the actuator changes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptation: Option<Adaptation>,
    /// How often the loop was lost; only where inputs have limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub losses: Option<Losses>,
}

/// Everything simulated for one controller.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Results over all runs.
    pub summary: Summary,
    /// Cost of each run, in the order of the runs.
    pub costs: Vec<f64>,
    /// The same with what its packets cost; equal where the design does not price them.
    pub total_costs: Vec<f64>,
    /// Cycles of all runs by the age of the input applied, 0 to N - 1 cycles, then those with the default input.
    pub ages: Vec<u64>,
    /// The first run, cycle by cycle.
    pub first_run: Vec<CycleRecord>,
    /// The bus of the first run, at its end.
    pub bus: Option<LoopBus>,
}

impl Outcome {
    /// What is known where only the summary was kept.
    pub fn of(summary: Summary) -> Self {
        Self {
            ages: vec![0; summary.sequence_length + 1],
            summary,
            costs: Vec::new(),
            total_costs: Vec::new(),
            first_run: Vec::new(),
            bus: None,
        }
    }
}

/// What each run cost with what its packets cost; `None` where the contender's design does not price them.
pub fn total_costs(contender: &Contender, results: &[RunResult]) -> Option<Vec<f64>> {
    let send_cost = contender.send_cost?;
    Some(results.iter().map(|result| result.cost + send_cost * result.sent as f64).collect())
}

/// The results of runs of `steps` cycles; `total_costs`, if packets have a price, in the same order.
pub fn summarise(
    kind: Kind,
    sequence_length: usize,
    steps: usize,
    results: &[RunResult],
    total_costs: Option<&[f64]>,
) -> Summary {
    let costs: Vec<f64> = results.iter().map(|result| result.cost).collect();
    let cycles = (results.len() * steps) as f64;
    let finite = |value: f64| value.is_finite().then_some(value);
    let priced = |of: fn(&[f64]) -> f64| total_costs.and_then(|costs| finite(of(costs)));
    Summary {
        controller: kind.name(),
        sequence_length,
        mean_cost: finite(mean(&costs)),
        std_error: finite(standard_error(&costs)),
        median_cost: finite(quantile(&costs, 0.5)),
        p95_cost: finite(quantile(&costs, 0.95)),
        worst_cost: finite(quantile(&costs, 1.0)),
        diverged: results.iter().filter(|result| result.diverged).count(),
        send_rate: results.iter().map(|result| result.sent).sum::<usize>() as f64 / cycles,
        mean_input_age: results.iter().map(|result| result.age_sum).sum::<usize>() as f64 / cycles,
        mean_total_cost: priced(mean),
        total_std_error: priced(standard_error),
        adaptation: None,
        losses: None,
    }
}
