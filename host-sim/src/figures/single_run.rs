//! One run of the pendulum that follows a reference, with and without preview: thesis Figure 4.4.
//!
//! Both controllers meet the same noise and the same fates of packets. The cart is to stand at 50 m, and from
//! [`CHANGE`] on at -50 m.

use super::example;
use crate::{
    closed_loop::CycleRecord,
    contender::{Contender, Kind},
    monte_carlo::{Plan, Simulate},
    output::{
        charts::{Quantity, in_units, overlay},
        columns::{aligned, figure},
    },
};
use gain_gen::design::Design;
use std::fmt::Write;

/// Cycles of the run, as in the thesis: 10 s.
pub const STEPS: usize = 500;
/// Inputs per sequence, as in the thesis.
pub const LENGTH: usize = 4;
/// The cycle in which the reference changes: 5 s.
pub const CHANGE: usize = 250;
/// One that looks ahead begins to move before the reference does, and one that does not moves all the faster after it:
/// extremes are taken from this cycle on, 4 s.
pub const BEFORE: usize = 200;
/// The controllers, the one with preview first.
pub const KINDS: [Kind; 2] = [Kind::Slqg, Kind::SlqgNoPreview];
/// Every so many cycles have a row in the table: 0.5 s.
const ROW: usize = 25;
/// States and input: as columns of the CSV, as columns of the table, and with their units.
const QUANTITIES: [(&str, &str, &str); 5] = [
    ("position", "s", "position s (m)"),
    ("velocity", "s'", "velocity s' (m/s)"),
    ("angle", "phi", "angle phi (rad)"),
    ("rate", "phi'", "rate phi' (rad/s)"),
    ("input", "u", "input u (N)"),
];

/// The runs on one network.
#[derive(Debug, Clone)]
pub struct Runs {
    /// Name of the design.
    pub design: String,
    /// Seconds per cycle.
    pub sample_time: f64,
    /// By [`KINDS`], every cycle.
    pub cycles: [Vec<CycleRecord>; KINDS.len()],
}

/// What a run came to around the change of the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reaction {
    /// When the cart turns: the time of its greatest position, s.
    pub turn: f64,
    /// That position, m.
    pub farthest: f64,
    /// Position when the reference changes, m.
    pub position: f64,
    /// Largest |angle| from [`BEFORE`] on, rad.
    pub angle: f64,
    /// Largest |rate of the angle| from then on, rad/s.
    pub rate: f64,
    /// Largest |input| from then on, N.
    pub input: f64,
}

/// Simulates run 0 on both networks.
pub fn simulate(seed: u64) -> Vec<Runs> {
    [example!("pendulum_tracking"), example!("pendulum_tracking_bad")].map(|design| runs(design, seed)).into()
}

fn runs(mut design: Design, seed: u64) -> Runs {
    design.set_sequence_length(LENGTH);
    let cycles = KINDS.map(|kind| {
        let contender = Contender::new(kind, &design, STEPS).expect("both networks allow this length");
        let plan = Plan { runs: 1, steps: STEPS, seed };
        let simulate = Simulate { design: &design, contender: &contender, plan, done: &|| () };
        simulate.outcome().expect("examples fit the simulator").first_run
    });
    Runs { design: design.name.clone(), sample_time: design.plant.sample_time, cycles }
}

/// Quantity `number` of a cycle.
fn value(cycle: &CycleRecord, number: usize) -> f64 {
    values(cycle).nth(number).unwrap_or(f64::NAN)
}

/// All quantities of a cycle.
fn values(cycle: &CycleRecord) -> impl Iterator<Item = f64> + '_ {
    cycle.state.iter().chain(&cycle.input).copied()
}

/// Where the cart is to be, m.
fn reference(cycle: &CycleRecord) -> f64 {
    cycle.tracked[0].1
}

impl Runs {
    /// What each of [`KINDS`] did around the change.
    pub fn reactions(&self) -> [Reaction; KINDS.len()] {
        self.cycles.each_ref().map(|cycles| {
            let largest = |number: usize| {
                cycles[BEFORE..].iter().map(|cycle| value(cycle, number).abs()).fold(0.0, f64::max)
            };
            let position = |cycle: &CycleRecord| value(cycle, 0);
            let turn =
                (0..cycles.len()).max_by(|a, b| position(&cycles[*a]).total_cmp(&position(&cycles[*b])));
            let turn = turn.expect("a run has cycles");
            Reaction {
                turn: turn as f64 * self.sample_time,
                farthest: position(&cycles[turn]),
                position: position(&cycles[CHANGE]),
                angle: largest(2),
                rate: largest(3),
                input: largest(4),
            }
        })
    }

    /// Largest distance between the two positions up to cycle `end`, m.
    pub fn apart(&self, end: usize) -> f64 {
        let [with, without] = self.cycles.each_ref().map(|cycles| &cycles[..end]);
        with.iter()
            .zip(without)
            .map(|(with, without)| (value(with, 0) - value(without, 0)).abs())
            .fold(0.0, f64::max)
    }

    /// A run as a table: time in s, the position that is to be and the states in m, m/s, rad, rad/s, the input in N.
    fn table(cycles: &[CycleRecord], sample_time: f64) -> String {
        let heads = ["time", "reference"].into_iter().chain(QUANTITIES.map(|(_, short, _)| short));
        let mut rows = vec![heads.map(String::from).collect::<Vec<_>>()];
        rows.extend(cycles.iter().enumerate().step_by(ROW).map(|(at, cycle)| {
            let values =
                std::iter::once(reference(cycle)).chain(values(cycle)).map(|value| figure(Some(value)));
            std::iter::once(format!("{:.1}", at as f64 * sample_time)).chain(values).collect()
        }));
        aligned(&rows, 0)
    }

    /// Every cycle, as comma-separated values.
    pub fn csv(&self) -> String {
        let mut text = String::from("time,reference");
        for kind in KINDS {
            for (name, ..) in QUANTITIES {
                // Writing to a string cannot fail.
                let _ = write!(text, ",{}_{name}", kind.name().replace('-', "_"));
            }
        }
        for cycle in 0..STEPS {
            let _ = write!(
                text,
                "\n{:.2},{}",
                cycle as f64 * self.sample_time,
                reference(&self.cycles[0][cycle])
            );
            let all = self.cycles.iter().flat_map(|cycles| values(&cycles[cycle]));
            all.for_each(|value| _ = write!(text, ",{value}"));
        }
        text + "\n"
    }

    /// All quantities over time, as SVG.
    pub fn picture(&self) -> String {
        let quantity = |(number, (_, _, label)): (usize, &(&str, &str, &str))| Quantity {
            label: label.to_string(),
            // All states are tracked, in their order; the input is not.
            reference: self.cycles[0].iter().filter_map(|cycle| Some(cycle.tracked.get(number)?.1)).collect(),
            runs: self
                .cycles
                .iter()
                .map(|cycles| cycles.iter().map(|cycle| value(cycle, number)).collect())
                .collect(),
        };
        let quantities: Vec<Quantity> = QUANTITIES.iter().enumerate().map(quantity).collect();
        in_units(&overlay(&KINDS.map(Kind::name), &quantities, self.sample_time))
    }
}

/// What all did around the change, then the runs.
pub fn table(all: &[Runs]) -> String {
    let heads = [
        "design",
        "controller",
        "turns at (s)",
        "s there (m)",
        "s at 5 s (m)",
        "|phi| (rad)",
        "|phi'| (rad/s)",
        "|u| (N)",
    ];
    let mut rows = vec![heads.map(String::from).to_vec()];
    for runs in all {
        for (kind, found) in KINDS.iter().zip(runs.reactions()) {
            let Reaction { turn, farthest, position, angle, rate, input } = found;
            let figures = [farthest, position, angle, rate, input].map(|value| figure(Some(value)));
            let name = [runs.design.clone(), kind.name().into(), format!("{turn:.2}")];
            rows.push(name.into_iter().chain(figures).collect());
        }
    }
    let mut text = aligned(&rows, 2) + "\n|phi|, |phi'|, |u|: the largest from 4 s on.\n";
    for runs in all {
        for (kind, cycles) in KINDS.iter().zip(&runs.cycles) {
            let (name, table) = (kind.name(), Runs::table(cycles, runs.sample_time));
            text += &format!("\n{}, {name}, N = {LENGTH}; s, m, m/s, rad, rad/s, N\n{table}", runs.design);
        }
    }
    text
}
