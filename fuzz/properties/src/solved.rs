//! Designs whose numbers are made up: every one that is accepted is solved and judged, and reads back from what is emitted.
//!
//! As [`crate::design`], but the text is always a design, so that none of the bytes is spent on its form.

use crate::design::judged;
use crate::script::{byte, up_to};
use arbitrary::{Result, Unstructured};
use std::fmt::Write;

/// Makes a design of the bytes.
pub fn check(bytes: &[u8]) {
    if let Ok(text) = text(&mut Unstructured::new(bytes)) {
        judged(&text);
    }
}

/// The text of a design of one or two states, inputs and outputs.
pub(crate) fn text(script: &mut Unstructured<'_>) -> Result<String> {
    let (states, inputs, outputs) = (1 + up_to(script, 1)?, 1 + up_to(script, 1)?, 1 + up_to(script, 1)?);
    let mut text = String::from("name = \"made up\"\n[plant]\nsample_time = 0.1\ninitial_mean = [");
    let mut add = |line: std::fmt::Arguments<'_>| {
        // Writing to a string does not fail.
        let _ = text.write_fmt(line);
    };
    add(format_args!("{}]\n", ["0", "1, 0"][usize::from(states) - 1]));
    let kind = ["discrete", "continuous"][usize::from(up_to(script, 1)?)];
    let (a, b) = (matrix(script, states, states)?, matrix(script, states, inputs)?);
    add(format_args!("{kind} = {{ a = {a}, b = {b} }}\nc = {}\n", matrix(script, outputs, states)?));
    add(format_args!("process_noise = {}\n", diagonal(script, states, 0)?));
    add(format_args!("measurement_noise = {}\n", diagonal(script, outputs, 1)?));
    add(format_args!("initial_covariance = {}\n[cost]\n", diagonal(script, states, 0)?));
    add(format_args!(
        "q = {}\nr = {}\n[network]\n",
        diagonal(script, states, 0)?,
        diagonal(script, inputs, 1)?
    ));
    add(format_args!("controller_to_actuator.delays = {}\n", delays(script)?));
    add(format_args!("sensor_to_controller.delays = {}\n", delays(script)?));
    match up_to(script, 3)? {
        0 => add(format_args!("acknowledgement = \"none\"\n")),
        1 => add(format_args!("acknowledgement.delays = {}\n", delays(script)?)),
        _ => {}
    }
    add(format_args!("[controller]\nsequence_length = {}\n", 1 + up_to(script, 3)?));
    let choice = byte(script)?;
    let is = |bit: u8| usize::from(choice >> bit & 1);
    add(format_args!(
        "default_input = \"{}\"\nscalar = \"{}\"\n",
        ["zero", "hold"][is(0)],
        ["f32", "f64"][is(1)]
    ));
    add(format_args!("estimator = \"{}\"\n", ["single", "single", "imm", "gpb2"][2 * is(2) + is(3)]));
    if is(4) == 1 {
        add(format_args!(
            "input_limits = {}\n",
            ["[[-2, 1]]", "[[-2, 1], [-1, 3]]"][usize::from(inputs) - 1]
        ));
    }
    if is(5) == 1 {
        add(format_args!("[event]\nsend_cost = {}\n", byte(script)?));
    }
    Ok(text)
}

/// Entries from -2 to 3.1.
fn matrix(script: &mut Unstructured<'_>, rows: u8, columns: u8) -> Result<String> {
    let row = |script: &mut Unstructured<'_>| -> Result<String> {
        let entries = (0..columns).map(|_| Ok(((f64::from(byte(script)?) - 100.0) / 50.0).to_string()));
        Ok(format!("[{}]", entries.collect::<Result<Vec<_>>>()?.join(", ")))
    };
    let rows = (0..rows).map(|_| row(script)).collect::<Result<Vec<_>>>()?;
    Ok(format!("[{}]", rows.join(", ")))
}

/// A diagonal of squares of hundredths, of at least `least` of them.
fn diagonal(script: &mut Unstructured<'_>, size: u8, least: u8) -> Result<String> {
    let entries = (0..size).map(|_| Ok((f64::from(byte(script)?.max(least)) / 100.0).powi(2)));
    let entries = entries.collect::<Result<Vec<f64>>>()?;
    let rows = (0..entries.len()).map(|row| {
        let row = (0..entries.len()).map(|column| if row == column { entries[row] } else { 0.0 }.to_string());
        format!("[{}]", row.collect::<Vec<_>>().join(", "))
    });
    Ok(format!("[{}]", rows.collect::<Vec<_>>().join(", ")))
}

/// Up to four delays; what is missing to 1 is lost.
fn delays(script: &mut Unstructured<'_>) -> Result<String> {
    let shares = (0..=up_to(script, 3)?).map(|_| Ok(f64::from(byte(script)?))).collect::<Result<Vec<_>>>()?;
    let whole = (shares.iter().sum::<f64>() + f64::from(byte(script)?)).max(1.0);
    let chances = shares.iter().map(|share| (share / whole).to_string());
    Ok(format!("[{}]", chances.collect::<Vec<_>>().join(", ")))
}
