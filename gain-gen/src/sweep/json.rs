//! The sweep as one JSON object; its fields are part of the stable command line.

use super::Sweep;
use serde::Serialize;

/// Both default inputs in one table.
const BOTH: &str = "both";

/// The fields in their order. Numbers that are not finite become null.
#[derive(Serialize)]
struct Document<'s> {
    name: &'s str,
    /// That of all results, or `both`.
    default_input: &'static str,
    results: Vec<Entry>,
}

#[derive(Serialize)]
struct Entry {
    sequence_length: usize,
    /// As in the report.
    converged: bool,
    mean_square_rate: f64,
    control_cost: f64,
    table_floats: usize,
    table_bytes: usize,
    coupled_table_floats: usize,
    coupled_table_bytes: usize,
    default_input: &'static str,
    verdict: &'static str,
    relative_cost: Option<f64>,
}

impl Sweep {
    /// One JSON object with a newline at the end: the fields of `gain-gen sweep --json`.
    pub fn to_json(&self) -> String {
        let entry = |figures: &super::LengthFigures| Entry {
            sequence_length: figures.sequence_length,
            converged: figures.converged,
            mean_square_rate: figures.mean_square_rate,
            control_cost: figures.control_cost,
            table_floats: figures.table_floats,
            table_bytes: self.bytes(figures.table_floats),
            coupled_table_floats: figures.coupled_table_floats,
            coupled_table_bytes: self.bytes(figures.coupled_table_floats),
            default_input: figures.default_input.name(),
            verdict: figures.verdict.name(),
            relative_cost: self.relative_cost(figures),
        };
        let document = Document {
            name: &self.name,
            default_input: match self.default_inputs[..] {
                [input] => input.name(),
                _ => BOTH,
            },
            results: self.results.iter().map(entry).collect(),
        };
        let text = serde_json::to_string_pretty(&document).expect("names and numbers are written to memory");
        text + "\n"
    }
}
