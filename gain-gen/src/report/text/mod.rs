//! The report as one screen of text, every figure with its unit.
//!
//! Here are the sections that every report of a loop has whose gains stabilise it; those that are there only for some designs,
//! or when asked for, are in `optional`, the verdict is in `stability`, distances to instability in `margins`, and what travels on CAN is in `wire`.

mod margins;
mod optional;
mod stability;
mod wire;

use super::figure::{counted, duration, figure, grouped, ordinal, percent};
use super::{Report, Verdict};
use crate::design::{Acknowledgement, Behaviour, DeviceScalar, Link};
use crate::stability::{Growth, growth};
use core::fmt::{self, Display, Formatter};
use nalgebra::DMatrix;

/// Error of the gains up to which it need not worry anybody.
const GOOD_GAINS: f64 = 1e-8;
/// Most rows and columns of a gain that still fit on the screen with the rest.
const SMALL: (usize, usize) = (10, 6);

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let settings = &self.design.controller;
        writeln!(
            f,
            "{}: sequences of N = {}{}, default input {}",
            self.design.name.escape_debug(),
            counted(settings.sequence_length, "input"),
            self.design.length_choice().map(|choice| format!(" ({choice})")).unwrap_or_default(),
            settings.default_input.name()
        )?;
        self.plant(f)?;
        self.link(f)?;
        self.stability(f)?;
        if self.solution.is_stabilising() && self.verdict() != Verdict::Unstable {
            self.closed_loop(f)?;
            self.estimation(f)?;
            self.unacknowledged(f)?;
            self.tracking(f)?;
            self.event(f)?;
            self.wire(f)?;
            self.margins(f)?;
            self.tables(f)?;
            self.state_gain(f)?;
        }
        self.channel(f)?;
        self.task(f)?;
        self.warnings(f)
    }
}

/// Width of a sentence beside what it is about.
const SENTENCE: usize = 96;

/// One aligned line: what, and how much.
fn line(f: &mut Formatter<'_>, what: &str, figures: impl Display) -> fmt::Result {
    writeln!(f, "  {what:<20}{figures}")
}

/// Two bounds on a figure; one number where they agree.
fn interval(lower: f64, upper: f64) -> String {
    let (lower, upper) = (figure(lower), figure(upper));
    if lower == upper { lower } else { format!("{lower} to {upper}") }
}

impl Report {
    /// `count` steps, and the same in seconds.
    fn steps(&self, count: f64) -> String {
        let plural = if count == 1.0 { "" } else { "s" };
        format!("{} step{plural} = {} s", duration(count), duration(count * self.design.plant.sample_time))
    }

    fn plant(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let plant = &self.design.plant;
        let (states, inputs) = (counted(plant.states(), "state"), counted(plant.inputs(), "input"));
        writeln!(f, "\nPlant")?;
        line(f, "dimensions", format!("{states}, {inputs}, {}", counted(plant.outputs(), "output")))?;
        line(f, "sample time", format!("{} s", figure(plant.sample_time)))?;
        let modulus = self.open_loop_modulus;
        let growth = match growth(plant) {
            Growth::Decays => "stable".into(),
            Growth::OnTheLimit => "on the limit of stability".into(),
            Growth::Grows => {
                let doubling = 2.0_f64.ln() / modulus.ln();
                format!("unstable, doubles in {}", self.steps(doubling))
            }
        };
        line(f, "open loop", format!("largest |eigenvalue| {} per step: {growth}", figure(modulus)))
    }

    fn link(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let link = &self.design.network.controller_to_actuator.delays;
        let last = self.design.controller.sequence_length - 1;
        let in_time = link.arrival(last);
        let arrives = link.arrival(link.largest_delay());
        writeln!(f, "\nLink from controller to actuator")?;
        let within = format!("within the sequence, at most {} late", counted(last, "step"));
        line(f, "arrives in time", format!("{:<12}{within}", percent(in_time)))?;
        line(f, "arrives too late", percent((arrives - in_time).max(0.0)))?;
        line(f, "lost", percent(link.loss()))?;
        line(f, "mean delay", format!("{}, of the packets that arrive", self.steps(link.mean_delay())))?;
        match &self.design.network.controller_to_actuator.behaviour {
            Behaviour::Independent => Ok(()),
            Behaviour::Markov(channel) => {
                let states =
                    format!("{} that come and go; the figures here are averages, and", channel.states());
                line(f, "channel states", states)?;
                line(f, "", "rate and costs take packets as independent; --method coupled adds the channel")
            }
            Behaviour::Bus => line(
                f,
                "bus",
                "delays found by running the loop's frames on it; verdict and costs take packets as independent",
            ),
            Behaviour::Recorded(recording) => {
                let cycles = recording.cycles();
                line(
                    f,
                    "recorded",
                    format!("in {cycles} cycles; verdict and costs take packets as independent"),
                )
            }
        }
    }

    fn closed_loop(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let every = self.scheduled.as_ref().map(|found| ordinal(found.schedule.period));
        let every = every.map(|every| format!(", a packet sent in every {every} step"));
        let sending = if let Some(every) = &every {
            every.as_str()
        } else if self.trigger.is_some() {
            ", a packet sent in every step"
        } else if self.unacknowledged.is_some() {
            " and acknowledged: nothing does better without"
        } else {
            ""
        };
        writeln!(f, "\nClosed loop, state known{sending}")?;
        let of_loop = self.scheduled.as_ref().map(|found| found.schedule.mean_square_rate);
        let rate = figure(of_loop.unwrap_or(self.solution.mean_square_rate));
        line(f, "mean-square rate", format!("{rate:<12}per step: second moments shrink by this factor"))?;
        if let Some(steps) = self.time_constant().filter(|_| self.unacknowledged.is_none()) {
            line(f, "time constant", format!("{}, of the second moments", self.steps(steps)))?;
        }
        let of_what = if self.scheduled.is_some() { "mean of tr(P W)" } else { "tr(P W)" };
        line(f, "long-run cost", format!("{:<12}per step, {of_what}", figure(self.control_cost())))?;
        for (input, applied) in self.applied.iter().flatten().enumerate() {
            let what = format!("input {}", input + 1);
            let away = format!("its nearer limit is {} of that away", figure(applied.limit_distance));
            line(f, &what, format!("{:<12}root mean square; {away}", figure(applied.rms)))?;
        }
        Ok(())
    }

    fn estimation(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let found = &self.estimation;
        let (verdict, arrival, critical) =
            (found.verdict.name(), percent(found.arrival), percent(found.critical));
        // What does not grow but for rounding needs no share of the measurements.
        let growing = found.limit.as_ref().filter(|limit| limit.cycle.is_some());
        let limits = growing.map_or((0.0, 0.0), |limit| (limit.lower, limit.upper));
        let (lower, upper) = (percent(limits.0), percent(limits.1));
        let limit = if lower == upper { upper } else { format!("{lower} to {upper}") };
        let shares =
            format!("q_arr = {arrival} of the measurements count, q_lim = {limit}, q_crit = {critical}");
        writeln!(f, "\nEstimation: {verdict}, {shares}")?;
        if let Some(cycle) = growing.and_then(|limit| limit.cycle.as_ref()).filter(|cycle| cycle.period > 1) {
            line(f, "q_lim", format!("decided by {cycle}"))?;
        }
        let trace = |bound: &Option<DMatrix<f64>>| bound.as_ref().map_or(f64::INFINITY, DMatrix::trace);
        let (lower, upper) = (trace(&found.covariance.lower), trace(&found.covariance.upper));
        line(f, "error covariance", format!("{}, trace, bounds in steady state", interval(lower, upper)))?;
        let (lower, upper) = (found.cost_lower, found.cost_upper);
        line(
            f,
            "long-run cost",
            format!("{} per step, bounds, estimation included", interval(lower, upper)),
        )?;
        for (input, applied) in self.applied.iter().flatten().enumerate() {
            let bounds = applied.rms_estimated.zip(applied.limit_distance_estimated);
            let Some(((lower, upper), distance)) = bounds else { continue };
            let (rms, distance) = (interval(lower, upper), figure(distance));
            let away = format!("its nearer limit is {distance} times the larger away");
            line(f, &format!("input {}", input + 1), format!("{rms} root mean square; {away}"))?;
        }
        self.acknowledgement(f)
    }

    fn acknowledgement(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let network = &self.design.network;
        let told = match &network.acknowledgement {
            Acknowledgement::Instant => "instant".into(),
            Acknowledgement::None => "none".into(),
            Acknowledgement::Over(Link { delays: link, .. }) => {
                let (mean, lost) = (self.steps(link.mean_delay()), percent(link.loss()));
                let cycles = counted(network.acknowledged_cycles, "cycle");
                format!("mean delay {mean}, {lost} lost, {cycles} in each")
            }
        };
        let estimator = self.design.estimator().name();
        line(f, "acknowledgement", format!("{told}; estimator {estimator}"))?;
        if network.acknowledgement == Acknowledgement::Instant || self.unacknowledged.is_some() {
            return Ok(());
        }
        let weight = self.solution.unknown_weight;
        if weight > 0.0 {
            let (unknown, known) = (percent(weight), percent(1.0 - weight));
            line(
                f,
                "gains",
                format!("{unknown} those for no acknowledgement, {known} those for instant ones"),
            )?;
        }
        line(
            f,
            "",
            "verdict, rate and costs hold for instant acknowledgement; here the costs are lower bounds",
        )
    }

    fn tables(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let scalar = self.design.controller.scalar;
        let bytes = match scalar {
            DeviceScalar::F32 => size_of::<f32>(),
            DeviceScalar::F64 => size_of::<f64>(),
        };
        let law = self.law();
        let size = |floats: usize| format!("{} numbers, {} bytes", grouped(floats), grouped(floats * bytes));
        writeln!(f, "\nTables on the device, {}", scalar.name())?;
        let rate = match scalar {
            DeviceScalar::F32 => format!("; mean-square rate {} with them", figure(self.emitted_rate)),
            DeviceScalar::F64 => String::new(),
        };
        line(f, "Lx, M, r", size(law.table_floats()) + &rate)?;
        if let Some(floats) = self.preview_floats() {
            line(f, "preview gains", size(floats))?;
        }
        if let Some(trigger) = &self.trigger {
            line(f, "event trigger", size(trigger.floats()))?;
        }
        if let Some(trigger) = self.scheduled.as_ref().and_then(|found| found.trigger.as_ref()) {
            line(f, "event trigger", size(trigger.floats()))?;
        }
        line(f, "coupled form", format!("{}, not needed", size(law.coupled_table_floats())))
    }

    fn state_gain(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let law = self.law();
        if law.lx.nrows() > SMALL.0 || law.lx.ncols() > SMALL.1 {
            return Ok(());
        }
        writeln!(f, "\nState gain Lx, input unit per state unit")?;
        write!(f, "  {:<8}", "")?;
        (1..=law.lx.ncols()).try_for_each(|state| write!(f, "{:>13}", format!("x{state}")))?;
        writeln!(f)?;
        for (row, gains) in law.lx.row_iter().enumerate() {
            let (step, input) = (row / law.inputs(), row % law.inputs() + 1);
            let of = if step == 0 { format!("u{input}(k)") } else { format!("u{input}(k+{step})") };
            write!(f, "  {of:<8}")?;
            gains.iter().try_for_each(|gain| write!(f, "{:>13}", figure(*gain)))?;
            writeln!(f)?;
        }
        Ok(())
    }
}
