//! Options that several subcommands share, and what they do to a design.

use super::Failure;
use clap::{Args, ValueEnum};
use gain_gen::{
    design::{Acknowledgement, Base, DelayDistribution, Design, LONGEST_PERIOD, Link},
    report::Report,
    solve::Method,
    warnings,
};
use host_sim::{
    contender::{Change, Contender, ContenderError, DEFAULT_DEADBAND, DEFAULT_SLICES, Kind, Outage},
    monte_carlo::Plan,
    size_class,
};
use slqg::estimator::Merging;
use std::{
    fmt::Display,
    path::{Path, PathBuf},
};

/// How much to simulate, and how to say it.
#[derive(Args)]
pub(super) struct Amount {
    /// Runs per controller.
    #[arg(long, value_name = "R", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) runs: u32,
    /// Control cycles per run.
    #[arg(long, value_name = "K", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) steps: u32,
    /// Seed of all random numbers; the same seed gives the same numbers on any number of threads.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub(super) seed: u64,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    pub(super) json: bool,
}

impl Amount {
    pub(super) fn plan(&self) -> Plan {
        Plan { runs: self.runs as usize, steps: self.steps as usize, seed: self.seed }
    }
}

/// Which controllers, and what is changed in the design.
#[derive(Args)]
pub(super) struct Selection {
    /// Controllers to simulate, separated by commas: slqg (sequence-based LQG over the design's network), slqg-always (sends
    /// in every cycle, worth it or not), slqg-periodic (sends in every p-th, with the law for that), slqg-no-preview (takes the reference of the moment for all that is to come),
    /// slqg-channel (told the state of a bursty link one cycle late), slqg-tuning (learns its link, solves its own gains),
    /// slqg-told (told when --changes-to changes its link), slqg-task (time-varying law of a task that ends with the run), slqg-udp (without acknowledgements),
    /// slqg-udp-rounded (the same with the mean age rounded), lqg (at the plant, without a network: the lower bound),
    /// hold-last (one input per packet, held: what is built today), nominal (LQR that predicts its own loop),
    /// expected-input (the same with what is to be expected in flight), lqg-loss (optimal if there were no delays),
    /// mpc (sends its plan, within the design's input limits), deadband (nominal, sent if it changes). docs/controllers.md.
    #[arg(long, value_delimiter = ',', default_value = "slqg,lqg")]
    pub(super) controllers: Vec<Kind>,
    /// What becomes of acknowledgements, instead of the design's: instant, none, or the probabilities of a delay of 0, 1, ..
    /// cycles, as 0.7,0.1.
    #[arg(long, value_name = "A", value_parser = acknowledgement)]
    acknowledgement: Option<Acknowledgement>,
    /// Cycles that each acknowledgement tells, instead of the design's.
    #[arg(long, value_name = "C", value_parser = clap::value_parser!(u8).range(1..=8))]
    acknowledged_cycles: Option<u8>,
    /// What the estimator keeps apart where ages are not acknowledged, instead of the design's.
    #[arg(long, value_enum)]
    estimator: Option<EstimatorName>,
    /// What a packet costs, instead of the design's `event.send_cost`.
    #[arg(long, value_name = "COST", value_parser = price)]
    send_cost: Option<f64>,
    /// When later packets are taken to be sent, instead of the design's `event.base`: auto, or the cycles from one to the next.
    #[arg(long, value_name = "P", value_parser = base)]
    event_base: Option<Base>,
    /// Change of an input, as a multiple of the new one, above which `deadband` sends.
    #[arg(long, value_name = "DELTA", default_value_t = DEFAULT_DEADBAND, value_parser = deadband)]
    deadband: f64,
    /// Backward steps that the device of `slqg-tuning` computes in a cycle while it solves.
    #[arg(long, value_name = "S", default_value_t = DEFAULT_SLICES as u16, value_parser = clap::value_parser!(u16).range(1..))]
    slices: u16,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum EstimatorName {
    /// Nothing: one filter, told mean and covariance of the input.
    Single,
    /// The age in the last cycle.
    Imm,
    /// The ages in the last two cycles.
    Gpb2,
    /// Nothing: one filter, told the mean of the input, and gains that know that it is uncertain. Without acknowledgements only.
    Linear,
}

fn deadband(text: &str) -> Result<f64, String> {
    let delta = text.parse().ok().filter(|&delta: &f64| delta >= 0.0);
    delta.ok_or_else(|| "give a number of 0 or more".into())
}

fn price(text: &str) -> Result<f64, String> {
    let price = text.parse().ok().filter(|&price: &f64| price >= 0.0 && price.is_finite());
    price.ok_or_else(|| "give a number of 0 or more".into())
}

fn base(text: &str) -> Result<Base, String> {
    if text == "auto" {
        return Ok(Base::Auto);
    }
    let period = text.parse().ok().filter(|period| (1..=LONGEST_PERIOD).contains(period));
    period.map(Base::Every).ok_or_else(|| format!("give auto, or a number from 1 to {LONGEST_PERIOD}"))
}

fn acknowledgement(text: &str) -> Result<Acknowledgement, String> {
    match text {
        "instant" => Ok(Acknowledgement::Instant),
        "none" => Ok(Acknowledgement::None),
        _ => {
            let probabilities: Option<Vec<f64>> =
                text.split(',').map(|part| part.trim().parse().ok()).collect();
            let probabilities =
                probabilities.ok_or("give instant, none, or probabilities separated by commas")?;
            let delays = DelayDistribution::new(probabilities).map_err(|error| error.to_string())?;
            Ok(Acknowledgement::Over(Link::independent(delays)))
        }
    }
}

const NO_PRICE: &str = "--send-cost, --event-base: the design has no [event] to change";
const NO_PAUSE: &str = "--event-base: with [tracking] only 1: what a pause costs depends on the reference";

const NOTHING_TO_TELL: &str = "`slqg-told` is `slqg` on a link that stays as it is; say what becomes of it, `host-sim run \
     --changes-to OTHER --at K`, or simulate `slqg`";

impl Selection {
    /// The design at `path` with what the command line changes.
    pub(super) fn load(&self, path: &Path) -> Result<Design, Failure> {
        let mut design = warnings::load(path).map_err(|error| Failure::Input(error.to_string()))?;
        if let Some(acknowledgement) = &self.acknowledgement {
            design.network.acknowledgement = acknowledgement.clone();
        }
        if let Some(estimator) = self.estimator {
            design.controller.estimator = Some(match estimator {
                EstimatorName::Single => Merging::Single,
                EstimatorName::Imm => Merging::Imm,
                EstimatorName::Gpb2 => Merging::Gpb2,
                EstimatorName::Linear => Merging::Linear,
            });
        }
        if design.controller.estimator == Some(Merging::Linear) {
            design.check_linear().map_err(|why| wrong(path, &format_args!("controller.estimator: {why}")))?;
        }
        if self.send_cost.is_some() || self.event_base.is_some() {
            let Some(event) = &mut design.event else { return Err(wrong(path, &NO_PRICE)) };
            event.send_cost = self.send_cost.unwrap_or(event.send_cost);
            event.base = self.event_base.unwrap_or(event.base);
            if design.tracking.is_some() && event.may_pause() {
                return Err(wrong(path, &NO_PAUSE));
            }
        }
        if let Some(cycles) = self.acknowledged_cycles {
            design.set_acknowledged_cycles(usize::from(cycles));
        }
        Ok(design)
    }

    /// What is changed beside the design's network.
    pub(super) fn changes(&self) -> String {
        let plain = format!("estimator {:?}, deadband {}", self.estimator, self.deadband);
        match (self.send_cost, self.event_base) {
            (None, None) => plain,
            (price, base) => format!("{plain}, send cost {price:?}, base {base:?}"),
        }
    }

    /// The controller `kind` for runs of `steps` cycles of `design`, which is that at `path`, perhaps with another length;
    /// the link to the actuator may `change` during each.
    pub(super) fn contender(
        &self,
        kind: Kind,
        design: &Design,
        path: &Path,
        steps: usize,
        change: Option<&Change>,
    ) -> Result<Contender, Failure> {
        // Before gains are computed, which can take longer than saying no.
        size_class::check(design).map_err(|error| wrong(path, &error))?;
        let mut contender =
            Contender::new(kind, design, steps).map_err(|error| refused(&error, design, path))?;
        contender.slices = self.slices.into();
        match change {
            Some(change) => {
                contender.meet(change.clone(), design).map_err(|error| refused(&error, design, path))?;
            }
            None if kind == Kind::SlqgTold => return Err(wrong(path, &NOTHING_TO_TELL)),
            None => {}
        }
        if let Some(rule) = &mut contender.deadband {
            rule.delta = self.deadband;
        }
        Ok(contender)
    }
}

/// A link that changes during a run.
#[derive(Args)]
pub(super) struct LinkBecomes {
    /// Design file whose link from controller to actuator this one's becomes during each run.
    #[arg(long, value_name = "OTHER", requires = "at")]
    changes_to: Option<PathBuf>,
    /// The cycle in which it does.
    #[arg(long, value_name = "K", requires = "changes_to")]
    at: Option<u32>,
}

impl LinkBecomes {
    /// What becomes of the link, if anything, in runs of `cycles` cycles, which `longer` is the option for. `load` reads the
    /// other design.
    pub(super) fn change(
        &self,
        cycles: usize,
        longer: &str,
        load: impl FnOnce(&Path) -> Result<Design, Failure>,
    ) -> Result<Option<Change>, Failure> {
        let (Some(other), Some(at)) = (&self.changes_to, self.at) else { return Ok(None) };
        let cycle = at as usize;
        if cycle >= cycles {
            return Err(Failure::Input(format!(
                "--at: found {at}; a run has {cycles} cycles, {longer} makes it longer"
            )));
        }
        Ok(Some(Change { link: load(other)?.network.controller_to_actuator, cycle }))
    }
}

/// Cycles in which links are dead.
#[derive(Args)]
pub(super) struct Outages {
    /// Nothing arrives of what is sent in these cycles, CYCLE and those after it; over all links, or one: sensor@5000+58,
    /// control@5000+58 or acknowledgement@5000+58. May be given several times.
    #[arg(long = "outage", value_name = "[LINK@]CYCLE+CYCLES")]
    outages: Vec<Outage>,
}

impl Outages {
    /// Those of runs of `cycles` cycles, which `longer` is the option for.
    pub(super) fn within(&self, cycles: usize, longer: &str) -> Result<Vec<Outage>, Failure> {
        match self.outages.iter().find(|outage| outage.cycles.start >= cycles as u64) {
            None => Ok(self.outages.clone()),
            Some(outage) => Err(Failure::Input(format!(
                "--outage: found {outage}; a run has {cycles} cycles, {longer} makes it longer"
            ))),
        }
    }
}

/// An error about the design at `path`.
pub(super) fn wrong(path: &Path, error: &dyn Display) -> Failure {
    Failure::Input(format!("{}: {error}", path.display()))
}

/// A controller that cannot be, for the design at `path`.
pub(super) fn refused(error: &ContenderError, design: &Design, path: &Path) -> Failure {
    let origin = path.display();
    match error {
        ContenderError::Unstable { .. } => {
            // Which condition fails is the generator's to say.
            let why = Report::new(design, Method::InFlight).require_stable().err();
            let why = why.map_or_else(String::new, |condition| format!(": {condition}"));
            Failure::Unstable(format!("{origin}: {error}{why}"))
        }
        wrong => Failure::Input(format!("{origin}: {wrong}")),
    }
}
