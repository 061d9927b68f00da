//! What controllers cost before and after their link changes, side by side.

use super::columns::{aligned, figure};
use crate::{
    adaptation::{WindowCost, ends},
    contender::Change,
    monte_carlo::{Plan, Summary},
};

/// The windows of several controllers as a table for people.
pub fn adaptation_table(change: &Change, plan: Plan, summaries: &[&Summary]) -> String {
    let [at, settled, steps] = ends(change, plan.steps);
    let head = [
        "controller".to_string(),
        format!("0..{at}"),
        "std error".to_string(),
        format!("{at}..{settled}"),
        "std error".to_string(),
        format!("{settled}..{steps}"),
        "std error".to_string(),
        "solved".to_string(),
        "switched".to_string(),
    ];
    let row = |summary: &&Summary| {
        let windows = summary.adaptation?;
        let mut cells = vec![summary.controller.to_string()];
        for WindowCost { mean_cost, std_error } in [windows.before, windows.adapting, windows.after] {
            cells.extend([figure(mean_cost), figure(std_error)]);
        }
        cells.extend([windows.solutions, windows.switches].map(|count| format!("{count:.1}")));
        Some(cells)
    };
    let rows: Vec<_> = std::iter::once(head.to_vec()).chain(summaries.iter().filter_map(row)).collect();
    let told = "\nMean cost per cycle before the link to the actuator changes, while the controller may adapt, and after; solutions and
switches per run.\n\n";
    format!("{told}{}", aligned(&rows, 1))
}
