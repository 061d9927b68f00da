//! What sending a packet is worth, as Rust source: a checked [`slqg::event::Trigger`].

use super::default_input;
use crate::design::Event;
use crate::emit::literal::Table;
use crate::emit::{Emission, EmitError};
use crate::figure::ordinal;
use crate::json::triangles;
use crate::solve::Scheduled;

/// Numbers on a line.
const PER_LINE: usize = 8;

/// The trigger; `None` if the design sends in every cycle.
pub(super) fn trigger(emission: &Emission<'_>) -> Result<Option<String>, EmitError> {
    if let (Some(event), Some(scheduled)) = (emission.design.event, emission.scheduled) {
        return over_schedule(emission, event, scheduled).map(Some);
    }
    let (Some(event), Some(tables)) = (emission.design.event, emission.trigger) else { return Ok(None) };
    let scalar = emission.design.controller.scalar;
    let send_cost = Table { name: "event.send_cost", scalar };
    // A price that rounds to zero would send always.
    send_cost.nonzero(event.send_cost)?;
    let table = Table { name: "event trigger", scalar };
    let (states, inputs) = (emission.design.plant.states(), emission.design.plant.inputs());
    let (length, expected) = (emission.law.length, emission.in_flight());
    let symmetric = |values: &[f64], sizes: &mut dyn Iterator<Item = usize>| -> Result<String, EmitError> {
        triangles(values, sizes).iter().flatten().map(|row| table.lines(row, row.len(), 16)).collect()
    };
    Ok(Some(format!(
        "\
/// Cost of sending one control packet, in units of the stage cost.
#[allow(clippy::approx_constant)]
pub const SEND_COST: Scalar = {price};

/// Sends a sequence only if it is expected to save more than [`SEND_COST`], given that all later ones are sent.
///
/// `state`, {states} x {columns} by rows, weighs states times inputs in flight. The others are symmetric, by rows of their
/// upper triangles: `in_flight` has one of {columns} rows, and for each cycle in which more has run out one of {inputs} rows
/// less; `sequence` has {rows} rows.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub static TRIGGER: slqg::event::Trigger<'static, Scalar, STATES, INPUTS> =
    slqg::event::Trigger::<Scalar, STATES, INPUTS>::new(
        SEQUENCE_LENGTH,
        {default},
        slqg::checked::NonNegative::<Scalar>::new(SEND_COST),
        slqg::event::Tables {{
            state: slqg::checked::Finite::<Scalar>::new(&[
{state}            ]),
            in_flight: slqg::checked::Finite::<Scalar>::new(&[
{in_flight}            ]),
            sequence: slqg::checked::Finite::<Scalar>::new(&[
{sequence}            ]),
        }},
    );
",
        price = send_cost.number(event.send_cost)?,
        columns = expected * inputs,
        rows = length * inputs,
        default = default_input(emission),
        state = table.lines(&tables.state, expected * inputs, 16)?,
        in_flight = symmetric(&tables.in_flight, &mut (1..=expected).rev().map(|left| left * inputs))?,
        sequence = symmetric(&tables.sequence, &mut std::iter::once(length * inputs))?,
    )))
}

/// The trigger where later packets go out in every p-th cycle, or all do.
fn over_schedule(emission: &Emission<'_>, event: Event, scheduled: &Scheduled) -> Result<String, EmitError> {
    let scalar = emission.design.controller.scalar;
    let send_cost = Table { name: "event.send_cost", scalar };
    send_cost.nonzero(event.send_cost)?;
    let (price, default) = (send_cost.number(event.send_cost)?, default_input(emission));
    let period = scheduled.schedule.period;
    let Some(tables) = &scheduled.trigger else {
        return Ok(format!(
            "\
/// Cost of sending one control packet, in units of the stage cost.
#[allow(clippy::approx_constant)]
pub const SEND_COST: Scalar = {price};

/// Sends a sequence in the cycles whose number is a multiple of {period}, and in no other. It takes the feature `schedule` of slqg.
#[rustfmt::skip]
pub static TRIGGER: slqg::event::Trigger<'static, Scalar, STATES, INPUTS> =
    slqg::event::Trigger::<Scalar, STATES, INPUTS>::fixed(
        SEQUENCE_LENGTH,
        {default},
        slqg::checked::NonNegative::<Scalar>::new(SEND_COST),
        {period},
    );
"
        ));
    };
    let table = Table { name: "event trigger", scalar };
    let numbers = |values: &[f64]| table.lines(values, PER_LINE, 16);
    Ok(format!(
        "\
/// Cost of sending one control packet, in units of the stage cost.
#[allow(clippy::approx_constant)]
pub const SEND_COST: Scalar = {price};

/// Sends a sequence unless it is better to wait, packets at [`SEND_COST`] each counted in, given that later ones are sent in every
/// {ordinal} cycle. It takes the feature `schedule` of slqg, whose `ScheduleTables` say what these numbers are.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub static TRIGGER: slqg::event::Trigger<'static, Scalar, STATES, INPUTS> =
    slqg::event::Trigger::<Scalar, STATES, INPUTS>::scheduled(
        SEQUENCE_LENGTH,
        {default},
        slqg::checked::NonNegative::<Scalar>::new(SEND_COST),
        slqg::event::ScheduleTables {{
            period: {period},
            in_flight: slqg::checked::Finite::<Scalar>::new(&[
{in_flight}            ]),
            decided: slqg::checked::Finite::<Scalar>::new(&[
{decided}            ]),
            phases: slqg::checked::Finite::<Scalar>::new(&[
{phases}            ]),
        }},
    );
",
        ordinal = ordinal(period),
        in_flight = numbers(&tables.in_flight)?,
        decided = numbers(&tables.decided)?,
        phases = numbers(&tables.phases)?,
    ))
}
