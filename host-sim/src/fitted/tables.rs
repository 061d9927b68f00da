//! A contender's tables, cast to the device's scalar and padded to the size class block by block.

use crate::contender::Sending;
use gain_gen::solve::{Law, PreviewGains, ScheduledTrigger, TriggerTables};
use nalgebra::DMatrix;
use slqg::{
    Scalar,
    checked::NonNegative,
    event::{self, packed_index},
};

/// A law's gains, by rows.
#[derive(Debug, Clone)]
pub(super) struct LawTables<T> {
    pub(super) lx: Vec<T>,
    pub(super) m: Vec<T>,
}

/// Preview gains, by rows.
#[derive(Debug, Clone)]
pub(super) struct PreviewTables<T> {
    pub(super) samples: usize,
    pub(super) sequence: Vec<T>,
    pub(super) displaced: Vec<T>,
}

/// What decides whether a packet is sent.
#[derive(Debug, Clone)]
pub(super) enum SendingTables<T> {
    Worth(EventTables<T>),
    WorthOverSchedule(OverSchedule<T>),
    Every { send_cost: NonNegative<T>, period: usize },
}

/// Tables of an event trigger over a schedule.
#[derive(Debug, Clone)]
pub(super) struct OverSchedule<T> {
    pub(super) send_cost: NonNegative<T>,
    pub(super) period: usize,
    pub(super) in_flight: Vec<T>,
    pub(super) decided: Vec<T>,
    pub(super) phases: Vec<T>,
}

/// Tables of an event trigger.
#[derive(Debug, Clone)]
pub(super) struct EventTables<T> {
    pub(super) send_cost: NonNegative<T>,
    pub(super) state: Vec<T>,
    pub(super) in_flight: Vec<T>,
    pub(super) sequence: Vec<T>,
}

/// Where an index over padded blocks of `PADDED` stands among blocks of `size`; `None` in the padding.
fn unpadded<const PADDED: usize>(index: usize, size: usize) -> Option<usize> {
    (index % PADDED < size).then_some(index / PADDED * size + index % PADDED)
}

/// A matrix by rows, each of its indices in blocks that are padded from `(rows, columns)` to `(R, C)`.
fn table<T: Scalar, const R: usize, const C: usize>(matrix: &DMatrix<f64>, blocks: (usize, usize)) -> Vec<T> {
    let (rows, columns) = (matrix.nrows() / blocks.0 * R, matrix.ncols() / blocks.1 * C);
    let at = |index: usize| {
        let row = unpadded::<R>(index / columns, blocks.0)?;
        Some(matrix[(row, unpadded::<C>(index % columns, blocks.1)?)])
    };
    (0..rows * columns).map(|index| T::nearest(at(index).unwrap_or(0.0))).collect()
}

/// The upper triangle of a symmetric matrix over `count` inputs, padded from `inputs` to `NU` each.
fn triangle<T: Scalar, const NU: usize>(packed: &[f64], count: usize, inputs: usize) -> Vec<T> {
    let (size, padded) = (count * inputs, count * NU);
    let mut out = Vec::with_capacity(event::TableLengths::packed(padded));
    for row in 0..padded {
        for column in row..padded {
            let place = unpadded::<NU>(row, inputs).zip(unpadded::<NU>(column, inputs));
            out.push(T::nearest(place.map_or(0.0, |(row, column)| packed[packed_index(size, row, column)])));
        }
    }
    out
}

pub(super) fn law_tables<T: Scalar, const NX: usize, const NU: usize>(law: &Law) -> LawTables<T> {
    let (states, inputs) = (law.lx.ncols(), law.inputs());
    LawTables {
        lx: table::<T, NU, NX>(&law.lx, (inputs, states)),
        m: table::<T, NU, NU>(&law.m, (inputs, inputs)),
    }
}

pub(super) fn preview_tables<T: Scalar, const NX: usize, const NU: usize>(
    gains: &PreviewGains,
    inputs: usize,
) -> PreviewTables<T> {
    let blocks = (inputs, gains.sequence.ncols() / gains.samples);
    PreviewTables {
        samples: gains.samples,
        sequence: table::<T, NU, NX>(&gains.sequence, blocks),
        displaced: table::<T, NU, NX>(&gains.displaced, blocks),
    }
}

pub(super) fn sending_tables<T: Scalar, const NX: usize, const NU: usize>(
    cost: f64,
    sending: &Sending,
    law: &Law,
) -> SendingTables<T> {
    let send_cost = NonNegative::check(T::nearest(cost)).expect("a cost is not below zero");
    match sending {
        Sending::Worth(tables) => SendingTables::Worth(event_tables::<T, NX, NU>(send_cost, tables, law)),
        Sending::WorthOverSchedule(tables) => {
            SendingTables::WorthOverSchedule(over_schedule::<T, NX, NU>(send_cost, tables, law))
        }
        Sending::Every(period) => SendingTables::Every { send_cost, period: *period },
    }
}

/// The triangles over the inputs in flight, from all of `expected` down to the last.
fn triangles<T: Scalar, const NU: usize>(packed: &[f64], expected: usize, inputs: usize) -> Vec<T> {
    let (mut rest, mut out) = (packed, Vec::new());
    for left in (1..=expected).rev() {
        let (own, others) = rest.split_at(event::TableLengths::packed(left * inputs));
        out.extend(triangle::<T, NU>(own, left, inputs));
        rest = others;
    }
    out
}

fn over_schedule<T: Scalar, const NX: usize, const NU: usize>(
    send_cost: NonNegative<T>,
    tables: &ScheduledTrigger,
    law: &Law,
) -> OverSchedule<T> {
    let (states, inputs) = (law.lx.ncols(), law.inputs());
    let expected = law.default_input.in_flight(law.length);
    let rows = expected * inputs;
    let mut phases = Vec::new();
    for phase in tables.phases.chunks_exact(event::phase_len(states, rows, inputs)) {
        let (state, rest) = phase.split_at(event::TableLengths::packed(states));
        let (coupling, rest) = rest.split_at(states * rows);
        let (applied, numbers) = rest.split_at(inputs * rows);
        phases.extend(triangle::<T, NX>(state, 1, states));
        let coupling = DMatrix::from_row_slice(states, rows, coupling);
        phases.extend(table::<T, NX, NU>(&coupling, (states, inputs)));
        let applied = DMatrix::from_row_slice(inputs, rows, applied);
        phases.extend(table::<T, NU, NU>(&applied, (inputs, inputs)));
        phases.extend(numbers.iter().map(|&number| T::nearest(number)));
    }
    OverSchedule {
        send_cost,
        period: tables.period,
        in_flight: triangles::<T, NU>(&tables.in_flight, expected, inputs),
        decided: triangle::<T, NU>(&tables.decided, expected, inputs),
        phases,
    }
}

fn event_tables<T: Scalar, const NX: usize, const NU: usize>(
    send_cost: NonNegative<T>,
    tables: &TriggerTables,
    law: &Law,
) -> EventTables<T> {
    let (states, inputs) = (law.lx.ncols(), law.inputs());
    let expected = law.default_input.in_flight(law.length);
    let state = DMatrix::from_row_slice(states, expected * inputs, &tables.state);
    EventTables {
        send_cost,
        state: table::<T, NX, NU>(&state, (states, inputs)),
        in_flight: triangles::<T, NU>(&tables.in_flight, expected, inputs),
        sequence: triangle::<T, NU>(&tables.sequence, law.length, inputs),
    }
}
