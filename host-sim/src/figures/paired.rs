//! What other controllers cost more than `slqg`, run by run with the same random numbers: `docs/comparison.md`.
//!
//! Common noise and common fates of packets drop out of a difference, so that it is known far better than either cost. The
//! interval is that of its mean with 99 % confidence, by the normal distribution.

use crate::{
    contender::{Contender, Kind},
    monte_carlo::{Outcome, Plan, Simulate},
    output::columns::{aligned, figure},
    sample::{mean, standard_error},
};
use gain_gen::{
    design::Design,
    solve::{LoopProblem, mean_square_rate},
};
use slqg::DefaultInput;

/// Who is compared with `slqg`: all that know no more than it does, and obey a length.
pub const OTHERS: [Kind; 5] = [Kind::Nominal, Kind::ExpectedInput, Kind::LqgLoss, Kind::Mpc, Kind::Deadband];
/// Half the width of a 99 % interval of a normal variable, in standard deviations.
const HALF_WIDTH: f64 = 2.575_829_303_548_901;

/// Runs, and the cycles of each: some whose cost is left out, and those that count.
#[derive(Debug, Clone, Copy)]
pub struct Amount {
    /// Runs of each controller.
    pub runs: usize,
    /// Cycles whose cost is left out.
    pub start: usize,
    /// Cycles whose cost counts.
    pub steps: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// What can be said of a difference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finding {
    /// The interval is above zero.
    Dearer,
    /// The interval is below zero.
    Cheaper,
    /// Every run costs the same.
    Same,
    /// The interval includes zero.
    Open,
    /// The loop with this law is not stable in the mean square: its mean cost grows without bound with the length of a run, and
    /// that of a few runs says nothing.
    Unstable,
}

impl Finding {
    /// As in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Dearer => "dearer",
            Self::Cheaper => "cheaper",
            Self::Same => "same",
            Self::Open => "open",
            Self::Unstable => "unstable",
        }
    }
}

/// What a controller costs more than `slqg`, per run.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Which controller.
    pub kind: Kind,
    /// Mean over the runs.
    pub mean: f64,
    /// Where its expectation is with 99 % confidence.
    pub interval: [f64; 2],
    /// Runs whose state left every bound.
    pub diverged: usize,
    /// The factor by which second moments of the loop with this law shrink in a cycle, in closed form; from 1 on they grow.
    pub rate: f64,
}

impl Difference {
    /// What it says.
    pub fn finding(&self) -> Finding {
        let [low, high] = self.interval;
        if self.rate >= 1.0 {
            Finding::Unstable
        } else if self.interval == [0.0, 0.0] {
            Finding::Same
        } else if low > 0.0 {
            Finding::Dearer
        } else if high < 0.0 {
            Finding::Cheaper
        } else {
            Finding::Open
        }
    }
}

/// One design with one length: `slqg` and what the others cost more.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Name of the design.
    pub design: String,
    /// What the actuator applies when its sequence has run out.
    pub default_input: DefaultInput,
    /// Inputs per sequence.
    pub length: usize,
    /// Mean cost of `slqg`, its 99 % interval, and its rate; `None`: no gains stabilise the loop, and there is nothing to
    /// compare with.
    pub own: Option<(f64, [f64; 2], f64)>,
    /// The others.
    pub others: Vec<Difference>,
}

/// Costs of all runs of `kind`, runs that diverged, and its rate; `None` if it has no gains.
fn simulate(design: &Design, kind: Kind, amount: Amount) -> Option<(Vec<f64>, usize, f64)> {
    let Amount { runs, start, steps, seed } = amount;
    let contender = Contender::new(kind, design, start + steps).ok()?;
    let run = |steps| -> Option<Outcome> {
        let plan = Plan { runs, steps, seed };
        let simulate = Simulate { design, contender: &contender, plan, done: &|| () };
        simulate.outcome().ok()
    };
    let mut whole = run(start + steps)?;
    if start > 0 {
        // The same random numbers make the beginning the same; both ends have a terminal cost.
        let early = run(start)?;
        whole.costs.iter_mut().zip(early.costs).for_each(|(cost, early)| *cost -= early);
    }
    let rate = mean_square_rate(&LoopProblem::of(design), &contender.laws[0].mode_gains());
    Some((whole.costs, whole.summary.diverged, rate))
}

fn interval(values: &[f64]) -> (f64, [f64; 2]) {
    let (mean, half) = (mean(values), HALF_WIDTH * standard_error(values));
    (mean, [mean - half, mean + half])
}

impl Comparison {
    /// Of `slqg` and `others` on `design`, as long as its sequences are.
    pub fn new(design: &Design, others: &[Kind], amount: Amount) -> Self {
        let own = simulate(design, Kind::Slqg, amount);
        let difference = |own: &[f64], kind: Kind| {
            let (costs, diverged, rate) = simulate(design, kind, amount)?;
            let more: Vec<f64> = costs.iter().zip(own).map(|(cost, own)| cost - own).collect();
            let (mean, interval) = interval(&more);
            Some(Difference { kind, mean, interval, diverged, rate })
        };
        let others = own.iter().flat_map(|(own, ..)| others.iter().filter_map(|kind| difference(own, *kind)));
        let others = others.collect();
        Self {
            design: design.name.clone(),
            default_input: design.controller.default_input,
            length: design.controller.sequence_length,
            own: own.map(|(costs, _, rate)| {
                let (mean, interval) = interval(&costs);
                (mean, interval, rate)
            }),
            others,
        }
    }

    /// Of all `lengths`, and with one held input per packet, of `hold-last`.
    pub fn all(design: &Design, lengths: &[usize], amount: Amount) -> Vec<Self> {
        let mut design = design.clone();
        let of_length = |length: &usize| {
            design.set_sequence_length(*length);
            Self::new(&design, &OTHERS, amount)
        };
        let mut all: Vec<Self> = lengths.iter().map(of_length).collect();
        design.set_sequence_length(1);
        design.controller.default_input = DefaultInput::Hold;
        all.push(Self::new(&design, &[Kind::HoldLast], amount));
        all
    }

    fn rows(&self) -> Vec<Vec<String>> {
        let hold = if self.default_input == DefaultInput::Hold { ", hold" } else { "" };
        let row = |name: &str, cells: [String; 6]| {
            [name.to_string(), format!("{}{hold}", self.length)].into_iter().chain(cells).collect()
        };
        let number = |value: f64| figure(value.is_finite().then_some(value));
        let Some((mean, [low, high], rate)) = self.own else {
            let nothing = ["-", "-", "-", "-", "-", "no steady law"].map(String::from);
            return vec![row(Kind::Slqg.name(), nothing)];
        };
        let own = [
            number(mean),
            number(low),
            number(high),
            "-".into(),
            format!("{rate:.3}"),
            "the cost itself".into(),
        ];
        let mut rows = vec![row(Kind::Slqg.name(), own)];
        rows.extend(self.others.iter().map(|other| {
            let [low, high] = other.interval.map(number);
            let cells = [
                number(other.mean),
                low,
                high,
                other.diverged.to_string(),
                format!("{:.3}", other.rate),
                other.finding().name().into(),
            ];
            row(other.kind.name(), cells)
        }));
        rows
    }
}

/// The comparisons of one design as a table.
pub fn table(all: &[Comparison]) -> String {
    let heads = ["controller", "N", "costs more", "99 % from", "to", "diverged", "rate", "finding"];
    let mut rows = vec![heads.map(String::from).to_vec()];
    rows.extend(all.iter().flat_map(Comparison::rows));
    aligned(&rows, 1)
}
