//! How often controllers under input limits are lost, side by side.

use super::columns::{aligned, figure};
use crate::{
    losses::Losses,
    monte_carlo::{Plan, Summary},
};

/// The losses of several controllers as a table for people; nothing where inputs have no limits.
pub fn losses_table(plan: Plan, summaries: &[&Summary]) -> String {
    let row = |summary: &&Summary| {
        let Losses { lost, hours, per_hour, per_hour_lower, per_hour_upper } = summary.losses?;
        let figures = [hours, per_hour, per_hour_lower, per_hour_upper].map(|value| figure(Some(value)));
        let names = [summary.controller.to_string(), format!("{lost} of {}", plan.runs)];
        Some(names.into_iter().chain(figures).collect::<Vec<_>>())
    };
    let rows: Vec<Vec<String>> = summaries.iter().filter_map(row).collect();
    if rows.is_empty() {
        return String::new();
    }
    let head = ["controller", "lost", "hours", "lost per hour", "95 % from", "to"].map(str::to_string);
    let table = aligned(&[vec![head.to_vec()], rows].concat(), 1);
    format!(
        "\nLost: beyond what inputs within their limits bring back. Hours of operation until then, of all runs together.\n\n{table}"
    )
}
