//! What a simulation looks like to people and programs: a table, a JSON object, a report with pictures.
//!
//! Nothing is simulated here. `table` is for the terminal, `report` for a browser, `charts` for its pictures, `pictures` for the
//! options that ask for them, `columns` for how figures are spelled.

mod adaptation;
pub(crate) mod charts;
pub mod columns;
mod losses;
mod pictures;
mod report;
mod table;

pub use adaptation::adaptation_table;
pub use losses::losses_table;
pub use pictures::{PictureError, Pictures};
pub use report::{Plot, Report, command_line, report};
pub use table::table;
pub(crate) use table::{COLUMNS, PRICED, row};

use crate::monte_carlo::{Outcome, Plan, Summary};
use gain_gen::design::Goal;
use serde::Serialize;

/// Everything one `host-sim run` simulated.
#[derive(Debug)]
pub struct Simulation<'a> {
    /// Name of the design.
    pub name: &'a str,
    /// Seconds per cycle.
    pub sample_time: f64,
    /// What is tracked, if anything.
    pub goal: Option<&'a Goal>,
    /// How much was simulated.
    pub plan: Plan,
    /// One outcome per controller.
    pub outcomes: Vec<Outcome>,
}

impl Simulation<'_> {
    /// Whether packets have a price.
    fn is_priced(&self) -> bool {
        self.outcomes.iter().any(|outcome| outcome.summary.mean_total_cost.is_some())
    }

    /// What a cycle costs, as a formula.
    fn stage_cost(&self) -> &'static str {
        stage_cost(self.goal)
    }
}

/// What a cycle costs, as a formula.
pub fn stage_cost(goal: Option<&Goal>) -> &'static str {
    match goal {
        None => "x'Qx + u'Ru",
        Some(Goal::Trajectory(_)) => "(z-ref)'Q(z-ref) + u'Ru",
        Some(Goal::SetPoint(_)) => "(z-ref)'Q(z-ref) + (u-u_ref)'R(u-u_ref)",
    }
}

#[derive(Serialize)]
struct Json<'a> {
    name: &'a str,
    seed: u64,
    runs: usize,
    steps: usize,
    results: Vec<&'a Summary>,
}

/// The simulation as one JSON object; numbers that are not finite are null.
pub fn json(simulation: &Simulation<'_>) -> String {
    let object = Json {
        name: simulation.name,
        seed: simulation.plan.seed,
        runs: simulation.plan.runs,
        steps: simulation.plan.steps,
        results: simulation.outcomes.iter().map(|outcome| &outcome.summary).collect(),
    };
    serde_json::to_string_pretty(&object).expect("numbers and strings are always JSON")
}
