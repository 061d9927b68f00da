//! Which designs are solved within a fraction of a second, so that many are.

use toml::{Table, Value};

/// Numbers in all tables together.
const MOST_NUMBERS: usize = 90;
/// Rows of a matrix: states, inputs, outputs.
const MOST_ROWS: usize = 3;
/// Inputs per sequence.
const LONGEST_SEQUENCE: i64 = 4;
/// Cycles that are remembered, or known ahead.
const MOST_CYCLES: i64 = 20;
/// Bytes of text.
const LONGEST_TEXT: usize = 4096;

/// Whether the text is no TOML, which costs nothing, or asks for little. Recordings are read from other files, and a bus is
/// simulated: neither is little.
pub(super) fn is_small(text: &str) -> bool {
    if text.len() > LONGEST_TEXT {
        return false;
    }
    let Ok(table) = text.parse::<Table>() else { return true };
    let mut numbers = 0;
    is_small_table(&table, &mut numbers) && numbers <= MOST_NUMBERS
}

fn is_small_table(table: &Table, numbers: &mut usize) -> bool {
    table.iter().all(|(key, value)| {
        let is_small = match (key.as_str(), value) {
            ("trace" | "can", _) => false,
            ("sequence_length", Value::Integer(length)) => *length <= LONGEST_SEQUENCE,
            // To be found among all lengths.
            ("sequence_length" | "preview", Value::String(_)) => false,
            ("preview" | "measurement_buffer", Value::Integer(cycles)) => *cycles <= MOST_CYCLES,
            ("a" | "b" | "c" | "q" | "transitions", Value::Array(rows)) => rows.len() <= MOST_ROWS,
            // Where it is missing, it is found.
            ("tracking", Value::Table(tracking)) => {
                tracking.contains_key("preview") || tracking.contains_key("set_point")
            }
            _ => true,
        };
        is_small && is_small_value(value, numbers)
    })
}

fn is_small_value(value: &Value, numbers: &mut usize) -> bool {
    match value {
        Value::Table(table) => is_small_table(table, numbers),
        Value::Array(entries) => entries.iter().all(|entry| is_small_value(entry, numbers)),
        Value::Integer(_) | Value::Float(_) => {
            *numbers += 1;
            true
        }
        _ => true,
    }
}
