//! What a reference adds to the law, as Rust source: checked preview gains, or the feedforward of a task cycle by cycle.

use super::{default_input, storage};
use crate::design::{Goal, SetPoint};
use crate::emit::literal::Table;
use crate::emit::{Emission, EmitError, TaskGains};
use crate::figure::{counted, figure, percent};
use crate::solve::PreviewGains;
use nalgebra::DMatrix;

/// The preview gains, and where the design has one the set point; `None` if it follows no reference.
pub(super) fn preview(emission: &Emission<'_>) -> Result<Option<String>, EmitError> {
    let (Some(tracking), Some(gains)) = (&emission.design.tracking, emission.preview) else {
        return Ok(None);
    };
    let mut text = format!(
        "\
/// Tracked outputs, `nz`.
pub const TRACKED_OUTPUTS: usize = {outputs};
/// Reference samples that make a difference, `T`.
pub const PREVIEW_SAMPLES: usize = {samples};

",
        outputs = tracking.outputs(),
        samples = gains.samples,
    );
    let use_of_it = match &tracking.goal {
        Goal::SetPoint(point) => {
            text.push_str(&set_point(emission, point)?);
            let cost = figure(gains.standing_cost.unwrap_or(f64::NAN));
            format!(
                "A reference that stands still is one sample: see [`SET_POINT`]. To stand there costs {cost} per cycle, on
/// top of the long-run cost."
            )
        }
        Goal::Trajectory(_) => format!(
            "In each cycle `k` hand the samples `z_{{k+1}}, z_{{k+2}}, ..` to the controller's `follow`, before its `cycle`. The
/// last one stands for all that come after it. Beyond {samples} ahead lie {tail} of the gains.",
            samples = counted(gains.samples, "sample"),
            tail = percent(gains.tail),
        ),
    };
    Ok(Some(text + &constant(emission, gains, &use_of_it)?))
}

fn constant(emission: &Emission<'_>, gains: &PreviewGains, use_of_it: &str) -> Result<String, EmitError> {
    let scalar = emission.design.controller.scalar;
    let table = Table { name: "preview gains", scalar };
    let (rows, columns) = gains.sequence.shape();
    let (worth, displaced) = if emission.trigger.is_some() {
        let worth =
            format!(", {} x {columns}, is what the inputs in flight are worth", gains.displaced.nrows());
        (format!("{worth} towards it, for [`TRIGGER`]"), table.rows(&gains.displaced, 16)?)
    } else {
        (" is for an event trigger only".into(), String::new())
    };
    Ok(format!(
        "\
/// What the reference adds to the sequence, `Uff = Gamma_1 z_{{k+1}} + .. + Gamma_T z_{{k+T}}`, gains in input unit per unit
/// of a tracked output.
///
/// By rows: `sequence`, {rows} x {columns}, is `[Gamma_1 .. Gamma_T]`;
/// `displaced`{worth}.
///
/// {use_of_it}
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub static PREVIEW: slqg::tracking::Preview<'static, Scalar, INPUTS> =
    slqg::tracking::Preview::<Scalar, INPUTS>::new(
        SEQUENCE_LENGTH,
        {default},
        TRACKED_OUTPUTS,
        PREVIEW_SAMPLES,
        slqg::tracking::Tables {{
            sequence: slqg::checked::Finite::<Scalar>::new(&[
{sequence}            ]),
            displaced: slqg::checked::Finite::<Scalar>::new(&[
{displaced}            ]),
        }},
    );
",
        default = default_input(emission),
        sequence = table.rows(&gains.sequence, 16)?,
    ))
}

fn set_point(emission: &Emission<'_>, point: &SetPoint) -> Result<String, EmitError> {
    let table = Table { name: "tracking.set_point", scalar: emission.design.controller.scalar };
    let value = DMatrix::from_column_slice(point.value.len(), 1, point.value.as_slice());
    Ok(format!(
        "\
/// Where the tracked outputs are to stay. `controller.follow(&[SET_POINT])` once is enough; until then it is zero.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const SET_POINT: slqg::nalgebra::SVector<Scalar, TRACKED_OUTPUTS> =
    {value};

",
        value = storage(table, &value, 4)?
    ))
}

/// The feedforward of each cycle of a task; `None` if it follows no reference.
pub(super) fn feedforward(
    emission: &Emission<'_>,
    task: &TaskGains<'_>,
) -> Result<Option<String>, EmitError> {
    let Some(tracked) = &task.gains.tracked else { return Ok(None) };
    let table = Table { name: "feedforward", scalar: emission.design.controller.scalar };
    let mut rows = String::new();
    for inputs in &tracked.feedforward {
        rows.push_str(&format!("    [\n{}    ],\n", table.lines(inputs.as_slice(), inputs.len(), 8)?));
    }
    Ok(Some(format!(
        "\
/// What the reference adds to the sequence of each cycle of the task, its {length} one after the other: before cycle
/// `k` hand `&FEEDFORWARD[k]` to the controller's `set_feedforward_rows`.
{surprise}#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub static FEEDFORWARD: [[Scalar; SEQUENCE_LENGTH * INPUTS]; CYCLES] = [
{rows}];
",
        length = counted(emission.law.length, "input"),
        surprise = match task.surprise_cost {
            Some(cost) if cost > 0.0 => format!(
                "///
/// If in each cycle the reference was taken to stay as it is, the task would cost {} more.
",
                figure(cost)
            ),
            _ => String::new(),
        },
    )))
}
