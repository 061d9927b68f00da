//! The table on the terminal.

use super::{
    Simulation,
    columns::{aligned, figure},
};
use crate::monte_carlo::Summary;

/// Heads of [`row`].
pub(crate) const COLUMNS: [&str; 9] =
    ["controller", "N", "mean cost", "std error", "median", "p95", "diverged", "sent", "mean age"];
/// And where packets have a price.
pub(crate) const PRICED: [&str; 2] = ["with sending", "std error"];

/// The simulation as a table for people.
pub fn table(simulation: &Simulation<'_>) -> String {
    let plan = simulation.plan;
    let seconds = plan.steps as f64 * simulation.sample_time;
    let mut text = format!(
        "{}: {} runs of {} steps ({seconds} s), seed {}\nCost is the sum of {} over a run, terminal term included.\n\n",
        simulation.name,
        plan.runs,
        plan.steps,
        plan.seed,
        simulation.stage_cost()
    );
    text += &aligned(&rows(simulation), 1);
    text
}

/// Names of the columns, then one row per controller.
pub(super) fn rows(simulation: &Simulation<'_>) -> Vec<Vec<String>> {
    let is_priced = simulation.is_priced();
    let header =
        COLUMNS.iter().chain(if is_priced { &PRICED[..] } else { &[] }).map(ToString::to_string).collect();
    let rows = simulation.outcomes.iter().map(|outcome| row(&outcome.summary, is_priced));
    std::iter::once(header).chain(rows).collect()
}

/// A controller's cells.
pub(crate) fn row(result: &Summary, is_priced: bool) -> Vec<String> {
    let mut cells = vec![
        result.controller.to_string(),
        result.sequence_length.to_string(),
        figure(result.mean_cost),
        figure(result.std_error),
        figure(result.median_cost),
        figure(result.p95_cost),
        result.diverged.to_string(),
        format!("{:.1} %", 100.0 * result.send_rate),
        format!("{:.2}", result.mean_input_age),
    ];
    if is_priced {
        cells.extend([figure(result.mean_total_cost), figure(result.total_std_error)]);
    }
    cells
}
