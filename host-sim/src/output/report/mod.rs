//! The report: one HTML file with everything in it, for a browser without a network. What to look for in it: docs/report.md.
//!
//! One file per part of the report, in its order: `design`, `results`, `lengths` (where sequences of several lengths were
//! simulated), `first_run`, `packets`, `statistics`, `origin`. `page` puts HTML together, `style.css` is what it looks like.

mod design;
mod first_run;
mod lengths;
mod origin;
mod packets;
mod page;
mod results;
mod statistics;

pub use origin::command_line;
pub use page::Plot;

use super::Simulation;
use crate::monte_carlo::Outcome;
use gain_gen::design::Design;
use page::Page;

/// A report and the pictures in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// A self-contained HTML page.
    pub html: String,
    /// Every picture as a file of its own, with names that differ.
    pub plots: Vec<Plot>,
}

/// The report on `simulation` of `design`, which `command` prints.
pub fn report(simulation: &Simulation<'_>, design: &Design, command: &str) -> Report {
    let mut page = Page::new(simulation.name);
    results::headline(&mut page, simulation, design);
    design::add(&mut page, design);
    results::add(&mut page, simulation);
    if has_lengths(simulation) {
        lengths::add(&mut page, simulation);
    } else {
        first_run::add(&mut page, simulation);
        packets::add(&mut page, simulation, design);
        statistics::add(&mut page, simulation);
    }
    origin::add(&mut page, simulation, command);
    let (html, plots) = page.finish();
    Report { html, plots }
}

/// Whether there are several lengths of one controller.
fn has_lengths(simulation: &Simulation<'_>) -> bool {
    let name = |outcome: &Outcome| outcome.summary.controller;
    let all = &simulation.outcomes;
    all.iter().enumerate().any(|(at, outcome)| all[..at].iter().any(|other| name(other) == name(outcome)))
}
