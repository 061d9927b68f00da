//! What became of the packets of the first run.

use super::page::Page;
use crate::{
    monte_carlo::Outcome,
    output::{
        Simulation,
        charts::{Ladder, packets},
    },
};
use gain_gen::design::{Acknowledgement, Design};
use slqg_links::path::Fate;

const CAPTION: &str = "Each dot is a packet in the cycle it is sent in; its line leads to the cycle it arrives in. Upright: in the same \
     cycle; slanted: late; cross: lost; dashed: a copy made by the link. A sequence is used if an input of it is ever applied, a \
     measurement if it is not older than the measurement buffer. Below: how many cycles ago the sequence was sent whose input is \
     applied. No dot: nothing was sent.";
const TOLD: &str = " An acknowledgement is used if it tells of a cycle that none before it has told of; upright: it is there before the \
     next cycle.";

pub(super) fn add(page: &mut Page, simulation: &Simulation<'_>, design: &Design) {
    page.section("Packets of the first run");
    let has_fates = |outcome: &&Outcome| {
        let mut fates = outcome
            .first_run
            .iter()
            .flat_map(|cycle| [cycle.control_frame, cycle.measurement_frame, cycle.acknowledgement_frame]);
        fates.any(|fate| !matches!(fate, None | Some(Fate::Delayed(0))))
    };
    let (eventful, smooth): (Vec<_>, Vec<_>) = simulation.outcomes.iter().partition(has_fates);
    for (number, outcome) in eventful.iter().enumerate() {
        let name = outcome.summary.controller;
        let acknowledged_cycles = acknowledged_cycles(outcome, design);
        let ladder = Ladder {
            title: name,
            run: &outcome.first_run,
            measurement_buffer: design.controller.measurement_buffer,
            sequence_length: outcome.summary.sequence_length,
            acknowledged_cycles,
        };
        let told = acknowledged_cycles.map(|_| TOLD).unwrap_or_default();
        let picture = |page: &mut Page| {
            page.wide_figure(&format!("packets-{name}"), packets(&ladder), &format!("{CAPTION}{told}"));
        };
        match number {
            0 => picture(page),
            _ => page.folded(&format!("Packets of {name}"), picture),
        }
    }
    if !smooth.is_empty() {
        let names: Vec<_> = smooth.iter().map(|outcome| outcome.summary.controller).collect();
        page.paragraph(&format!("Not drawn: {}, of which no packet was late or lost.", names.join(", ")));
    }
}

/// Cycles that acknowledgements tell of where they go over a link; elsewhere there is nothing to see of them.
fn acknowledged_cycles(outcome: &Outcome, design: &Design) -> Option<usize> {
    let network = &design.network;
    let are_sent = outcome.first_run.iter().any(|cycle| cycle.acknowledgement_frame.is_some());
    (are_sent && matches!(network.acknowledgement, Acknowledgement::Over(_)))
        .then_some(network.acknowledged_cycles)
}
