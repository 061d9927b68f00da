//! The table on the terminal.

use super::Simulation;
use crate::monte_carlo::Summary;
use std::fmt::Write;

const COLUMNS: [&str; 9] =
    ["controller", "N", "mean cost", "std error", "median", "p95", "diverged", "sent", "mean age"];
/// Where packets have a price.
const PRICED: [&str; 2] = ["with sending", "std error"];

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
    let is_priced = simulation.is_priced();
    let header =
        COLUMNS.iter().chain(if is_priced { &PRICED[..] } else { &[] }).map(ToString::to_string).collect();
    let rows = simulation.outcomes.iter().map(|outcome| row(&outcome.summary, is_priced));
    let rows: Vec<Vec<String>> = std::iter::once(header).chain(rows).collect();
    for row in &rows {
        for (column, cell) in row.iter().enumerate() {
            let width = rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
            // Names to the left, numbers to the right.
            let _ =
                if column == 0 { write!(text, "{cell:<width$}") } else { write!(text, "  {cell:>width$}") };
        }
        text.push('\n');
    }
    text
}

fn row(result: &Summary, is_priced: bool) -> Vec<String> {
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

/// Five significant digits, or what there is instead.
pub(super) fn figure(value: Option<f64>) -> String {
    match value {
        None => "-".to_string(),
        Some(value) if value == 0.0 || (1e-3..1e6).contains(&value.abs()) => {
            let digits = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
            format!("{value:.*}", (4 - digits).clamp(0, 8) as usize)
        }
        Some(value) => format!("{value:.4e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_five_digits_at_any_size() {
        assert_eq!(figure(Some(12345.678)), "12346");
        assert_eq!(figure(Some(1.2345678)), "1.2346");
        assert_eq!(figure(Some(0.0123456)), "0.012346");
        assert_eq!(figure(Some(1.2345678e9)), "1.2346e9");
        assert_eq!(figure(Some(0.0)), "0.0000");
        assert_eq!(figure(None), "-");
    }
}
