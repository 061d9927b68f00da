//! Costs over the sequence length, for several controllers and networks.

use crate::{
    contender::{Contender, ContenderError, Kind},
    monte_carlo::{Outcome, Plan, Simulate, Summary},
    output::{
        Plot, Simulation,
        columns::{aligned, figure},
        report,
    },
};
use gain_gen::design::Design;
use std::ops::RangeInclusive;

/// What is compared.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// One design per network.
    pub designs: Vec<Design>,
    /// Controllers.
    pub kinds: Vec<Kind>,
    /// Inputs per sequence.
    pub lengths: RangeInclusive<usize>,
    /// Runs of each.
    pub runs: usize,
    /// Cycles per run.
    pub steps: usize,
}

/// One point.
#[derive(Debug, Clone)]
pub struct Point {
    /// Name of the design.
    pub design: String,
    /// Which controller.
    pub kind: Kind,
    /// Inputs per sequence.
    pub length: usize,
    /// `None`: no gains stabilise the loop.
    pub summary: Option<Summary>,
}

impl Comparison {
    /// Runs that are done in all, at most.
    pub fn work(&self) -> usize {
        self.designs.len() * self.kinds.len() * self.lengths.clone().count() * self.runs
    }

    /// Simulates everything; `done` is called when a run is.
    ///
    /// # Errors
    /// A controller that cannot work with a design.
    pub fn points(&self, seed: u64, done: impl Fn() + Sync) -> Result<Vec<Point>, ContenderError> {
        let plan = Plan { runs: self.runs, steps: self.steps, seed };
        let mut points = Vec::new();
        for design in &self.designs {
            let mut design = design.clone();
            for &kind in &self.kinds {
                let lengths = if kind.ignores_length() { 1..=1 } else { self.lengths.clone() };
                for length in lengths {
                    design.set_sequence_length(length);
                    let summary = match Contender::new(kind, &design, plan.steps) {
                        Ok(contender) => {
                            let simulate =
                                Simulate { design: &design, contender: &contender, plan, done: &done };
                            Some(simulate.outcome().expect("examples fit the simulator").summary)
                        }
                        Err(ContenderError::Unstable { .. }) => None,
                        Err(other) => return Err(other),
                    };
                    points.push(Point { design: design.name.clone(), kind, length, summary });
                }
            }
        }
        Ok(points)
    }
}

impl Comparison {
    /// Costs over the lengths, one picture for each design: its name, and the picture as SVG.
    pub fn pictures(&self, points: &[Point], seed: u64) -> Vec<(String, String)> {
        let of_design = |design: &Design| {
            let own = points.iter().filter(|point| point.design == design.name);
            let outcomes: Vec<Outcome> =
                own.filter_map(|point| point.summary.clone()).map(Outcome::of).collect();
            let simulation = Simulation {
                name: &design.name,
                sample_time: design.plant.sample_time,
                goal: design.tracking.as_ref().map(|tracking| &tracking.goal),
                plan: Plan { runs: self.runs, steps: self.steps, seed },
                outcomes,
            };
            let plots = report(&simulation, design, "").plots.into_iter();
            let named = |plot: Plot| (format!("{}-{}", design.name, plot.name), plot.svg);
            plots.filter(|plot| !plot.name.contains("delay")).map(named).collect::<Vec<_>>()
        };
        self.designs.iter().flat_map(of_design).collect()
    }
}

/// The points as a table; a loop that cannot be stabilised has a dash for its cost.
pub fn table(points: &[Point]) -> String {
    let header = [
        "design",
        "controller",
        "N",
        "mean cost",
        "std error",
        "median",
        "p95",
        "diverged",
        "sent",
        "with sending",
    ];
    let mut rows = vec![header.map(String::from).to_vec()];
    rows.extend(points.iter().map(|point| {
        let name = [point.design.clone(), point.kind.name().into(), point.length.to_string()];
        let figures = match &point.summary {
            None => vec!["-".into()],
            Some(found) => vec![
                figure(found.mean_cost),
                figure(found.std_error),
                figure(found.median_cost),
                figure(found.p95_cost),
                found.diverged.to_string(),
                format!("{:.1} %", 100.0 * found.send_rate),
                figure(found.mean_total_cost),
            ],
        };
        let mut row: Vec<String> = name.into_iter().chain(figures).collect();
        row.resize(header.len(), String::new());
        row
    }));
    aligned(&rows, 2)
}
