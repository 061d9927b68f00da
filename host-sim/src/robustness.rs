//! Designed for one network, run on another: what it costs when the link is not what was assumed.
//!
//! Controllers and estimators keep the gains and probabilities of the design they are from; only the links are another's.

use crate::{
    contender::{Contender, Kind},
    monte_carlo::{CannotSimulate, Plan, Simulate, Summary},
    output::columns,
};
use gain_gen::design::Design;
use serde::Serialize;

/// One cell: a design on a network.
#[derive(Debug, Clone, Serialize)]
pub struct Cell {
    /// Name of the design whose gains are used.
    pub designed_for: String,
    /// Name of the design whose network is used.
    pub run_on: String,
    /// How that went.
    #[serde(flatten)]
    pub summary: Summary,
}

/// Every design on the network of every design.
#[derive(Debug, Clone, Serialize)]
pub struct Robustness {
    /// Seed of the simulation.
    pub seed: u64,
    /// Runs per cell.
    pub runs: usize,
    /// Cycles per run.
    pub steps: usize,
    /// Row by row: all networks for the first design, then for the second.
    pub results: Vec<Cell>,
}

/// Why a table cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum NoTable {
    /// Costs of different plants cannot be compared.
    #[error(
        "{name}: its {what} differs from that of {first}; give designs that differ in network and controller only"
    )]
    Incomparable {
        /// The design that differs.
        name: String,
        /// The first design.
        first: String,
        /// What differs.
        what: &'static str,
    },
    /// A controller that is told more of its own network than another network has.
    #[error(
        "`slqg-channel` is told the states of its own channel, which other networks do not have; give --controller slqg"
    )]
    OwnChannel,
    /// A design cannot be simulated.
    #[error("{name}: {error}")]
    Simulate {
        /// The design.
        name: String,
        /// Why.
        error: CannotSimulate,
    },
}

/// Checks that the designs can be compared, one plant and one cost, with a controller that runs on any network.
///
/// # Errors
/// The first difference, or a controller that only its own network can have.
pub fn check(designs: &[Design], kind: Kind) -> Result<(), NoTable> {
    if kind == Kind::SlqgChannel {
        return Err(NoTable::OwnChannel);
    }
    for design in designs {
        let first = &designs[0];
        let differs = [
            ("[plant]", design.plant != first.plant),
            ("[cost]", design.cost != first.cost),
            ("[tracking]", design.tracking != first.tracking),
            ("[event]", design.event != first.event),
        ];
        if let Some((what, _)) = differs.into_iter().find(|(_, differs)| *differs) {
            return Err(NoTable::Incomparable { name: design.name.clone(), first: first.name.clone(), what });
        }
    }
    Ok(())
}

impl Robustness {
    /// Simulates every contender on the network of every design; all cells meet the same random numbers. `done` is called
    /// when a run is.
    ///
    /// # Errors
    /// A design that does not fit the simulator.
    pub fn new(
        designs: &[Design],
        contenders: &[Contender],
        plan: Plan,
        done: impl Fn() + Sync,
    ) -> Result<Self, NoTable> {
        let mut results = Vec::new();
        for (design, contender) in designs.iter().zip(contenders) {
            let name = || design.name.clone();
            for other in designs {
                let mut contender = contender.clone();
                contender.put_on(&other.network);
                let simulate = Simulate { design, contender: &contender, plan, done: &done };
                let outcome =
                    simulate.outcome().map_err(|error| NoTable::Simulate { name: name(), error })?;
                results.push(Cell {
                    designed_for: name(),
                    run_on: other.name.clone(),
                    summary: outcome.summary,
                });
            }
        }
        let Plan { runs, steps, seed } = plan;
        Ok(Self { seed, runs, steps, results })
    }

    /// The table for people.
    pub fn table(&self) -> String {
        let header = ["designed for", "run on", "N", "mean cost", "std error", "median", "p95", "diverged"];
        let mut rows = vec![header.map(String::from).to_vec()];
        rows.extend(self.results.iter().map(|cell| {
            let Summary { mean_cost, std_error, median_cost, p95_cost, .. } = cell.summary;
            let mut row = vec![
                cell.designed_for.clone(),
                cell.run_on.clone(),
                cell.summary.sequence_length.to_string(),
            ];
            row.extend([mean_cost, std_error, median_cost, p95_cost].map(columns::figure));
            row.push(cell.summary.diverged.to_string());
            row
        }));
        format!(
            "{} runs of {} steps, seed {}; cost of a run\n\n{}",
            self.runs,
            self.steps,
            self.seed,
            columns::aligned(&rows, 2)
        )
    }
}
