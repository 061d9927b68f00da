//! A sweep as a table and as one JSON object. Statistics come from the rows alone.

use super::{experiment::Case, file::Results, paired::Difference, row::Entry};
use crate::{
    closed_loop::RunResult,
    contender::Kind,
    monte_carlo::{Summary, summarise},
    output::{
        COLUMNS, PRICED,
        columns::{aligned, figure},
        row,
    },
};
use serde::Serialize;

/// One case.
#[derive(Debug, Clone, Serialize)]
pub struct CaseSummary {
    /// Name of the design.
    pub design: String,
    /// Results over all runs.
    #[serde(flatten)]
    pub summary: Summary,
    /// Cost of a run against the baseline's; absent for the baseline, and where it has no case of the same length.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub difference: Option<Difference>,
    /// The same of costs with sending; only where the design prices packets.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub total_difference: Option<Difference>,
}

/// A sweep in figures.
#[derive(Debug, Clone, Serialize)]
pub struct SweepSummary {
    /// Names of the designs.
    pub name: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Runs per case.
    pub runs: u64,
    /// Cycles per run.
    pub steps: usize,
    /// The controller that others are compared with.
    pub baseline: &'static str,
    /// Case by case.
    pub results: Vec<CaseSummary>,
    /// What the figures are of, for people.
    #[serde(skip)]
    heading: String,
}

/// The baseline is not among the controllers.
#[derive(Debug, Clone, thiserror::Error)]
#[error("--baseline {baseline}: there is none among the controllers: {controllers}; give one of them")]
pub struct NoBaseline {
    baseline: &'static str,
    controllers: String,
}

/// The controller to compare with: the one that is asked for, or the first.
///
/// # Errors
/// The one that is asked for is not among them.
pub fn baseline(wanted: Option<Kind>, controllers: &[Kind]) -> Result<Kind, NoBaseline> {
    match wanted {
        Some(kind) if !controllers.contains(&kind) => {
            let mut names: Vec<_> = controllers.iter().map(|kind| kind.name()).collect();
            names.dedup();
            Err(NoBaseline { baseline: kind.name(), controllers: names.join(", ") })
        }
        Some(kind) => Ok(kind),
        None => Ok(controllers[0]),
    }
}

impl SweepSummary {
    /// Of a complete experiment with at least one case, compared with `baseline`.
    pub fn new(results: &Results, baseline: Kind) -> Self {
        let experiment = &results.experiment;
        let case = |(case, entries): (&Case, &[Entry])| {
            let runs: Vec<RunResult> = entries.iter().map(|entry| entry.result).collect();
            let totals: Option<Vec<f64>> = entries.iter().map(|entry| entry.total_cost).collect();
            let partner = partner(results, case, baseline);
            let against = |of: fn(&Entry) -> Option<f64>| Difference::between(entries, partner?, of);
            CaseSummary {
                design: case.design.clone(),
                summary: summarise(
                    case.controller,
                    case.sequence_length,
                    experiment.steps,
                    &runs,
                    totals.as_deref(),
                ),
                difference: against(|entry| Some(entry.result.cost)),
                total_difference: against(|entry| entry.total_cost),
            }
        };
        let names: Vec<_> = experiment.designs.iter().map(|design| design.name.as_str()).collect();
        Self {
            name: names.join(", "),
            seed: experiment.seed,
            runs: experiment.runs,
            steps: experiment.steps,
            baseline: baseline.name(),
            results: results.by_case().map(case).collect(),
            heading: heading(results),
        }
    }

    /// As one JSON object; numbers that are not finite are null.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("numbers and strings are always JSON")
    }

    /// As a table for people.
    pub fn table(&self) -> String {
        let is_priced = self.results.iter().any(|case| case.summary.mean_total_cost.is_some());
        let is_compared = self.results.iter().any(|case| case.difference.is_some());
        let mut header = vec!["design".to_string()];
        header.extend(COLUMNS.map(String::from));
        if is_priced {
            header.extend(PRICED.map(String::from));
        }
        if is_compared {
            header.extend([format!("- {}", self.baseline), "std error".into(), "95 % interval".into()]);
        }
        let mut rows = vec![header];
        for case in &self.results {
            let mut cells = vec![case.design.clone()];
            cells.extend(row(&case.summary, is_priced));
            if is_compared {
                cells.extend(compared(case.total_difference.or(case.difference)));
            }
            rows.push(cells);
        }
        let mut names = 2;
        if self.results.iter().all(|case| case.design == self.results[0].design) {
            // One design is named above the table.
            rows.iter_mut().for_each(|cells| drop(cells.remove(0)));
            names = 1;
        }
        let mut text = format!("{}\n{}", self.heading, aligned(&rows, names));
        if is_compared {
            let cost = if is_priced { "cost, with sending where that has a price," } else { "cost" };
            text += &format!(
                "\n`- {}`: mean difference in {cost} to `{}` with the same N, run by run.\n",
                self.baseline, self.baseline
            );
        }
        text
    }
}

/// The baseline's entries to compare a case with: those of the same length, or its only ones where the length does not matter
/// to one of both.
fn partner<'r>(results: &'r Results, case: &Case, baseline: Kind) -> Option<&'r [Entry]> {
    if case.controller == baseline {
        return None;
    }
    let candidates =
        || results.by_case().filter(|(other, _)| other.design == case.design && other.controller == baseline);
    let any_length = case.controller.ignores_length() || baseline.ignores_length();
    let mut fitting =
        candidates().filter(|(other, _)| any_length || other.sequence_length == case.sequence_length);
    match (fitting.next(), fitting.next()) {
        (Some((_, entries)), None) => Some(entries),
        _ => None,
    }
}

fn compared(difference: Option<Difference>) -> [String; 3] {
    let Some(Difference { mean, std_error, interval_95 }) = difference else {
        return ["-"; 3].map(String::from);
    };
    let interval = interval_95.map(|[low, high]| format!("{} .. {}", figure(Some(low)), figure(Some(high))));
    [figure(mean), figure(std_error), interval.unwrap_or_else(|| "-".into())]
}

fn heading(results: &Results) -> String {
    let experiment = &results.experiment;
    let mut text = String::new();
    for design in &experiment.designs {
        text += &format!(
            "{}: {} runs of {} steps ({} s), seed {}\nCost is the sum of {} over a run, terminal term included.\n",
            design.name,
            experiment.runs,
            experiment.steps,
            experiment.steps as f64 * design.sample_time,
            experiment.seed,
            design.stage_cost
        );
    }
    text
}
