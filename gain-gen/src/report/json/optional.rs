//! Fields that are null, or missing, unless the design or the question asks for them.
//!
//! | field | of |
//! |---|---|
//! | `channel` | designs for a link whose quality comes and goes, when asked for |
//! | `task` | the laws of a task of finite length, when asked for |
//! | `tracking` | a design with `[tracking]` |
//! | `event` | a design with `[event]` |
//! | `unacknowledged` | a design without acknowledgements and with the linear estimator |
//! | `wire` | a design with `[wire]` whose frames travel on CAN |
//!
//! Symmetric matrices of the trigger are rows of their upper triangle: the first row is whole, the last one number.

use super::Report;
use crate::channels::ControlOnChannel;
use crate::design::{Authentication, Steps, WireSettings};
use crate::json::{Rows, rows, triangles};
use crate::solve::{Law, Outcome, ScheduleCost, ScheduledTrigger, Unacknowledged};
use nalgebra::DMatrix;
use serde::Serialize;

/// A loop without acknowledgements; [`crate::solve::Unacknowledged`].
#[derive(Serialize)]
pub(super) struct UnacknowledgedFigures {
    /// Long-run cost per step of the loop with its filter.
    cost: f64,
    mean_square_rate: f64,
    /// Whether cost and rate are those of the loop as it runs: every measurement comes at once.
    is_exact: bool,
    /// Whether the cost is the least that a law has with this filter; if not, it is close to that.
    is_least: bool,
    /// Probability that the controller hears of the newest measurement, and all before.
    hears: f64,
    /// Null where a law is found for measurements as late as they are.
    late_rate: Option<f64>,
    /// Covariance of the input about its mean, `nu x nu`.
    input_covariance: Rows,
    /// `nx x ny`.
    filter_gain: Rows,
}

impl UnacknowledgedFigures {
    pub(super) fn of(found: &Unacknowledged) -> Self {
        Self {
            cost: found.cost,
            mean_square_rate: found.rate,
            is_exact: found.is_exact,
            is_least: found.is_least,
            hears: found.hears,
            late_rate: found.late_rate,
            input_covariance: rows(&found.input_covariance),
            filter_gain: rows(&found.filter_gain),
        }
    }
}

/// Designs for a link whose quality comes and goes, on its true chain.
#[derive(Serialize)]
pub(super) struct Channel {
    /// Age of each mode.
    ages: Vec<usize>,
    /// States of the channel in the last cycles, for each mode; the newest first.
    states: Vec<Vec<usize>>,
    transition_matrix: Rows,
    designs: Vec<ChannelDesign>,
    /// By state of the channel in the cycle before: `Lx`, `(N nu) x nx`. Null if no gains stabilise the loop.
    lx: Option<Vec<Rows>>,
    /// The same for `M`, `(N nu) x (n_v nu)`.
    m: Option<Vec<Rows>>,
}

/// One of them.
#[derive(Serialize)]
struct ChannelDesign {
    /// `average`, `ages` or `channel`.
    knowledge: &'static str,
    mean_square_rate: f64,
    /// Null: unbounded.
    control_cost: Option<f64>,
    /// `L(j)` over `[x; rho]` (hold: and the default input) for each mode.
    gains: Vec<Rows>,
}

impl Channel {
    pub(super) fn of(report: &Report) -> Option<Self> {
        let found = report.channel.as_ref()?;
        let (chain, law) = (&found.correlated.chain, &found.in_flight.law);
        let is_found = found.in_flight.outcome == Outcome::Converged;
        let laws = |part: fn(&Law) -> &DMatrix<f64>| {
            is_found.then(|| (0..law.channel_states()).map(|state| rows(part(&law.at(&[state])))).collect())
        };
        Some(Self {
            ages: chain.ages.clone(),
            states: chain.channels.clone(),
            transition_matrix: rows(&chain.transitions),
            designs: found
                .correlated
                .designs
                .iter()
                .map(|design| ChannelDesign {
                    knowledge: design.knowledge.name(),
                    mean_square_rate: design.mean_square_rate,
                    control_cost: design.control_cost.is_finite().then_some(design.control_cost),
                    gains: design.gains.iter().map(rows).collect(),
                })
                .collect(),
            lx: laws(|law| &law.lx),
            m: laws(|law| &law.m),
        })
    }
}

/// A task of finite length: tables by cycle.
#[derive(Serialize)]
pub(super) struct Task {
    cycles: usize,
    control_cost: Option<f64>,
    lx: Vec<Rows>,
    m: Vec<Rows>,
    cost_to_go: Vec<Rows>,
    /// `Uff`, `N nu` numbers for each cycle; null without `[tracking]`.
    feedforward: Option<Rows>,
    /// What the task costs more if in each cycle the reference is taken to stay as it is; null without `[tracking]`.
    surprise_cost: Option<f64>,
}

impl Task {
    pub(super) fn of(report: &Report) -> Option<Self> {
        let task = report.task.as_ref()?;
        let tracked = task.tracked.as_ref();
        Some(Self {
            cycles: task.laws.len(),
            control_cost: report.task_cost(),
            lx: task.laws.iter().map(|law| rows(&law.lx)).collect(),
            m: task.laws.iter().map(|law| rows(&law.m)).collect(),
            cost_to_go: task.cost_to_go.iter().map(rows).collect(),
            feedforward: tracked
                .map(|tracked| tracked.feedforward.iter().map(|inputs| inputs.as_slice().to_vec()).collect()),
            surprise_cost: report.surprise_cost(),
        })
    }
}

/// What follows a reference. Without a steady state all but `z` is null.
#[derive(Serialize)]
pub(super) struct Tracking {
    /// `Z`, `nz x nx`: the tracked outputs are `z = Z x`.
    z: Rows,
    /// Reference samples known ahead, `T`; 1 for a set point.
    preview: Option<usize>,
    /// Share of the gains that belongs to samples beyond them.
    tail: Option<f64>,
    /// `[Gamma_1 .. Gamma_T]`, `(N nu) x (T nz)`: `Uff = sum_t Gamma_t z_{k+t}`.
    gains: Option<Rows>,
    /// `(n_v nu) x (T nz)`: what the inputs in flight are worth towards the reference; null without `[event]`.
    displaced: Option<Rows>,
    /// Cost per cycle of standing at the set point; null without one.
    standing_cost: Option<f64>,
}

impl Tracking {
    pub(super) fn of(report: &Report) -> Option<Self> {
        let tracking = report.design.tracking.as_ref()?;
        let gains = report.preview.as_ref().and_then(|gains| gains.as_ref().ok());
        Some(Self {
            z: rows(&tracking.z),
            preview: gains.map(|gains| gains.samples),
            tail: gains.map(|gains| gains.tail),
            gains: gains.map(|gains| rows(&gains.sequence)),
            displaced: gains.filter(|_| report.trigger.is_some()).map(|gains| rows(&gains.displaced)),
            standing_cost: gains.and_then(|gains| gains.standing_cost),
        })
    }
}

/// What sending is worth, as in [`slqg::event::Tables`]. Without a steady state all but `send_cost` is null.
#[derive(Serialize)]
pub(super) struct Event {
    /// Of one packet, in units of the stage cost.
    send_cost: f64,
    /// Cycles from one later packet to the next, `p`; null if no schedule was found.
    base: Option<usize>,
    /// `worth` or `schedule`.
    rule: &'static str,
    /// What sending is worth with `p > 1`, as in [`slqg::event::ScheduleTables`]; else null. `state`, `in_flight` and `sequence` are
    /// null then.
    scheduled: Option<ScheduledTables>,
    /// `nx x (n_v nu)`.
    state: Option<Rows>,
    /// `W_s` for `s = 0..n_v-1`, symmetric of `(n_v - s) nu` rows.
    in_flight: Option<Vec<Rows>>,
    /// `Rbar`, symmetric of `N nu` rows.
    sequence: Option<Rows>,
    /// By period, those shown to stabilise the loop; null with `[tracking]`, and where there are none.
    schedules: Option<Vec<ScheduleFigures>>,
}

/// [`slqg::event::ScheduleTables`], as it lies in memory.
#[derive(Serialize)]
struct ScheduledTables {
    in_flight: Vec<f64>,
    decided: Vec<f64>,
    phases: Vec<f64>,
}

impl ScheduledTables {
    fn of(trigger: &ScheduledTrigger) -> Self {
        let ScheduledTrigger { in_flight, decided, phases, .. } = trigger.clone();
        Self { in_flight, decided, phases }
    }
}

/// [`ScheduleCost`]: per cycle.
#[derive(Serialize)]
struct ScheduleFigures {
    period: usize,
    control_cost: f64,
    estimation_cost: f64,
    packet_cost: f64,
    total: f64,
    mean_square_rate: f64,
}

impl ScheduleFigures {
    fn of(cost: &ScheduleCost) -> Self {
        Self {
            period: cost.period,
            control_cost: cost.control,
            estimation_cost: cost.estimation,
            packet_cost: cost.packets,
            total: cost.total(),
            mean_square_rate: cost.mean_square_rate,
        }
    }
}

impl Event {
    pub(super) fn of(report: &Report) -> Option<Self> {
        let event = report.design.event?;
        let send_cost = event.send_cost;
        let base = report.scheduled.as_ref().map(|found| found.schedule.period);
        let (inputs, states) = (report.design.plant.inputs(), report.design.plant.states());
        let (tables, expected) = (report.trigger.as_ref(), report.in_flight() * inputs);
        let row = |row: usize, values: &[f64]| values[row * expected..(row + 1) * expected].to_vec();
        Some(Self {
            send_cost,
            base: base.or(report.trigger.as_ref().map(|_| 1)),
            rule: event.rule.name(),
            scheduled: report
                .scheduled
                .as_ref()
                .and_then(|found| Some(ScheduledTables::of(found.trigger.as_ref()?))),
            state: tables.map(|tables| (0..states).map(|at| row(at, &tables.state)).collect()),
            in_flight: tables.map(|tables| {
                triangles(
                    &tables.in_flight,
                    (1..=report.in_flight()).rev().map(|inputs_left| inputs_left * inputs),
                )
            }),
            sequence: tables.and_then(|tables| {
                triangles(&tables.sequence, [report.design.controller.sequence_length * inputs]).pop()
            }),
            schedules: report
                .schedules
                .as_ref()
                .map(|schedules| schedules.costs.iter().map(ScheduleFigures::of).collect()),
        })
    }
}

/// Frames on a CAN bus.
#[derive(Serialize)]
pub(super) struct Wire {
    format: &'static str,
    /// `none` or `cmac`; the bytes are those of sealed frames.
    authentication: &'static str,
    /// Data bytes of each CAN frame; null if it is too small.
    measurement_bytes: Option<usize>,
    control_bytes: Option<usize>,
    /// Null also where nothing is acknowledged.
    acknowledgement_bytes: Option<usize>,
    /// What would fit; null if all does.
    misfit: Option<String>,
    /// Null where values are not counted.
    #[serde(flatten)]
    rounding: Option<Rounding>,
}

/// What a count stands for, in the unit of each input and output.
#[derive(Serialize)]
struct Rounding {
    input_steps: Vec<f64>,
    output_steps: Vec<f64>,
    /// Per step, see [`Report::rounding_cost`].
    rounding_cost: Option<f64>,
}

impl Wire {
    pub(super) fn of(report: &Report) -> Option<Self> {
        let design = &report.design;
        let bytes = design.carried_bytes();
        let rounding = design.steps().map(|Steps { inputs, outputs }| Rounding {
            input_steps: inputs.steps,
            output_steps: outputs.steps,
            rounding_cost: report.rounding_cost(),
        });
        let is_sealed = design.authentication != Authentication::None;
        (design.wire != WireSettings::Bytes || is_sealed).then(|| Self {
            format: design.wire.name(),
            authentication: design.authentication.name(),
            measurement_bytes: bytes.map(|bytes| bytes.measurement),
            control_bytes: bytes.map(|bytes| bytes.control),
            acknowledgement_bytes: bytes.and_then(|bytes| bytes.acknowledgement),
            misfit: design.misfit().map(|misfit| misfit.to_string()),
            rounding,
        })
    }
}

/// What decides where packets depend on each other through a known channel. Null: the link's packets do not.
#[derive(Serialize)]
pub(super) struct OnChannels {
    control: Option<ControlFigures>,
    measurements: Option<SightFigures>,
}

/// [`ControlOnChannel`]; null: too large.
#[derive(Serialize)]
struct ControlFigures {
    mean_square_rate: Option<f64>,
    modes: Option<usize>,
}

/// [`crate::estimation::OnChannel`]; null: none was needed.
#[derive(Serialize)]
struct SightFigures {
    verdict: &'static str,
    loss_growth: f64,
    rate: Option<f64>,
}

impl OnChannels {
    pub(super) fn of(report: &Report) -> Option<Self> {
        let control = report.on_channel.map(|found| match found {
            ControlOnChannel::Rate { rate, modes } => {
                ControlFigures { mean_square_rate: Some(rate), modes: Some(modes) }
            }
            ControlOnChannel::TooLarge => ControlFigures { mean_square_rate: None, modes: None },
        });
        let measurements = report.estimation.channel.map(|found| SightFigures {
            verdict: found.verdict.name(),
            loss_growth: found.loss_growth,
            rate: found.rate,
        });
        (control.is_some() || measurements.is_some()).then_some(Self { control, measurements })
    }
}
