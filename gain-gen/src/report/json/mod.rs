//! The report as one JSON object; its fields are part of the stable command line.
//!
//! `optional` has the fields that are null for many designs, `mode_gains` the one that is for long sequences, `margins` the
//! distances to instability.

mod margins;
mod mode_gains;
mod optional;

use super::{AppliedInput, FailedCondition, LimitsShown, Report};
use crate::design::Acknowledgement;
use crate::estimation::{ArrivalLimit, DecidingCycle};
use crate::json::{Rows, line_per_field, rows, write_line_per_field};
use crate::solve::LoopProblem;
use crate::warnings::Warning;
use margins::MarginFigures;
use mode_gains::Spelled;
use nalgebra::DMatrix;
use optional::{Channel, Event, OnChannels, Task, Tracking, UnacknowledgedFigures, Wire};
use serde::Serialize;
use std::io::{self, Write};

pub use mode_gains::{MOST_MODE_GAINS, ModeGains};

/// The fields in their order. Numbers that are not finite become null.
#[derive(Serialize)]
pub(crate) struct Document<'r> {
    name: &'r str,
    sequence_length: usize,
    default_input: &'static str,
    method: &'static str,
    /// The recursion converged and measurements come often enough. What else the verdict asks is in `failed_conditions`.
    converged: bool,
    iterations: usize,
    residual: f64,
    transition_matrix: Rows,
    mean_square_rate: f64,
    control_cost: f64,
    lx: Rows,
    m: Rows,
    r: Rows,
    /// Null where they are many and not asked for.
    gains: Option<Spelled<'r>>,
    cost_to_go: Rows,
    n_min: Option<usize>,
    n_crit: Option<usize>,
    table_floats: usize,
    coupled_table_floats: usize,
    verdict: &'static str,
    failed_conditions: Vec<String>,
    n_v: usize,
    /// Of the iterations, those that began with the exact cost of the gains before.
    policy_iterations: usize,
    /// Only with input limits: root mean square of each input applied, and how many of them its nearer limit is away.
    #[serde(skip_serializing_if = "Option::is_none")]
    applied_inputs: Option<Vec<InputFigures>>,
    /// Estimated error of the gains relative to the largest; null unless converged.
    gain_error: Option<f64>,
    /// Mean-square rate with the numbers that are emitted.
    emitted_rate: f64,
    estimation: EstimationFigures,
    /// Of a length that was chosen; null where it was given.
    length_tolerance: Option<f64>,
    /// Null where not asked for, or the loop is not stable.
    margins: Option<MarginFigures>,
    /// Only where they were asked for and are not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    margins_not_given: Option<String>,
    /// Only for links whose packets depend on each other through a known channel, or are copied.
    #[serde(skip_serializing_if = "Option::is_none")]
    on_channels: Option<OnChannels>,
    /// Only with input limits: `decay`, `drift`, or null where it is not shown that they do no harm.
    #[serde(skip_serializing_if = "Option::is_none")]
    limits_shown_by: Option<Option<&'static str>>,
    /// Only for a link with a channel, by the coupled method.
    #[serde(skip_serializing_if = "Option::is_none")]
    channel: Option<Channel>,
    /// Only with a task.
    #[serde(skip_serializing_if = "Option::is_none")]
    task: Option<Task>,
    /// Null without `[tracking]`.
    tracking: Option<Tracking>,
    /// Null without `[event]`.
    event: Option<Event>,
    /// `single`, `imm`, `gpb2` or `linear`.
    estimator: &'static str,
    /// Null where nothing is acknowledged.
    acknowledged_cycles: Option<usize>,
    /// What makes no sense; see [`crate::warnings`].
    warnings: Vec<String>,
    /// Only on CAN.
    #[serde(skip_serializing_if = "Option::is_none")]
    wire: Option<Wire>,
    /// Only without acknowledgements, by the linear estimator.
    #[serde(skip_serializing_if = "Option::is_none")]
    unacknowledged: Option<UnacknowledgedFigures>,
    /// Only where acknowledgements come late or are lost and the gains know it.
    #[serde(skip_serializing_if = "Option::is_none")]
    unknown_weight: Option<f64>,
}

/// [`AppliedInput`]; null: no bounds are known.
#[derive(Serialize)]
struct InputFigures {
    rms: f64,
    limit_distance: f64,
    rms_estimated_lower: Option<f64>,
    rms_estimated_upper: Option<f64>,
    limit_distance_estimated: Option<f64>,
}

impl InputFigures {
    fn of(input: &AppliedInput) -> Self {
        Self {
            rms: input.rms,
            limit_distance: input.limit_distance,
            rms_estimated_lower: input.rms_estimated.map(|bounds| bounds.0),
            rms_estimated_upper: input.rms_estimated.map(|bounds| bounds.1),
            limit_distance_estimated: input.limit_distance_estimated,
        }
    }
}

/// [`crate::estimation::Estimation`]; null: unbounded, or no bound is known.
#[derive(Serialize)]
struct EstimationFigures {
    q_arr: f64,
    q_crit: f64,
    verdict: &'static str,
    error_covariance_lower: Option<f64>,
    error_covariance_upper: Option<f64>,
    expected_cost_lower: f64,
    expected_cost_upper: f64,
    /// Null where no measurement is needed.
    limit: Option<LimitFigures>,
}

/// [`crate::estimation::ArrivalLimit`]; the last three are null where no mode grows.
#[derive(Serialize)]
struct LimitFigures {
    lower: f64,
    upper: f64,
    eigenvalues: Option<Rows>,
    period: Option<usize>,
    losses: Option<usize>,
}

impl LimitFigures {
    fn of(limit: &ArrivalLimit) -> Self {
        let cycle = limit.cycle.as_ref();
        let parts =
            |cycle: &DecidingCycle| cycle.eigenvalues.iter().map(|value| vec![value.re, value.im]).collect();
        Self {
            lower: limit.lower,
            upper: limit.upper,
            eigenvalues: cycle.map(parts),
            period: cycle.map(|cycle| cycle.period),
            losses: cycle.map(|cycle| cycle.losses),
        }
    }
}

impl<'r> Document<'r> {
    pub(crate) fn of(report: &'r Report, mode_gains: ModeGains) -> Self {
        let (solution, law, network) = (&report.solution, report.law(), &report.design.network);
        Self {
            name: &report.design.name,
            sequence_length: law.length,
            default_input: law.default_input.name(),
            method: report.method.name(),
            converged: report.converged(),
            iterations: solution.iterations,
            residual: solution.residual,
            transition_matrix: rows(&report.transition_matrix),
            mean_square_rate: report.mean_square_rate(),
            control_cost: report.control_cost(),
            lx: rows(&law.lx),
            m: rows(&law.m),
            r: rows(&law.arrival_matrix()),
            gains: (report.unacknowledged.is_none() && report.scheduled.is_none())
                .then(|| Spelled::of(solution, mode_gains))
                .flatten(),
            cost_to_go: rows(&solution.cost_to_go),
            n_min: report.n_min,
            n_crit: report.n_crit,
            table_floats: law.table_floats(),
            coupled_table_floats: law.coupled_table_floats(),
            verdict: report.verdict().name(),
            failed_conditions: report.failed_conditions.iter().map(FailedCondition::to_string).collect(),
            n_v: report.in_flight(),
            policy_iterations: solution.policy_iterations,
            emitted_rate: report.emitted_rate,
            applied_inputs: report
                .applied
                .as_ref()
                .map(|inputs| inputs.iter().map(InputFigures::of).collect()),
            gain_error: solution.gain_error.is_finite().then_some(solution.gain_error),
            estimation: EstimationFigures {
                q_arr: report.estimation.arrival,
                q_crit: report.estimation.critical,
                verdict: report.estimation.verdict.name(),
                error_covariance_lower: report.estimation.covariance.lower.as_ref().map(DMatrix::trace),
                error_covariance_upper: report.estimation.covariance.upper.as_ref().map(DMatrix::trace),
                expected_cost_lower: report.estimation.cost_lower,
                expected_cost_upper: report.estimation.cost_upper,
                limit: report.estimation.limit.as_ref().map(LimitFigures::of),
            },
            length_tolerance: report.design.length_choice().map(|choice| choice.tolerance),
            margins: report.margins.as_ref().map(MarginFigures::of),
            margins_not_given: report.margins_not_given.as_ref().map(ToString::to_string),
            on_channels: OnChannels::of(report),
            limits_shown_by: report
                .design
                .controller
                .input_limits
                .is_some()
                .then(|| report.limits_shown_by().map(LimitsShown::name)),
            channel: Channel::of(report),
            task: Task::of(report),
            tracking: Tracking::of(report),
            event: Event::of(report),
            estimator: report.design.estimator().name(),
            acknowledged_cycles: (network.acknowledgement != Acknowledgement::None)
                .then_some(network.acknowledged_cycles),
            warnings: report.warnings.iter().map(Warning::within_file).collect(),
            wire: Wire::of(report),
            unacknowledged: report.unacknowledged.as_ref().map(UnacknowledgedFigures::of),
            unknown_weight: Some(solution.unknown_weight).filter(|weight| *weight > 0.0),
        }
    }
}

impl Report {
    /// One JSON object: the fields of `gain-gen report --json`, one on a line, and a newline at the end.
    pub fn to_json(&self) -> String {
        line_per_field(&Document::of(self, ModeGains::Small))
    }

    /// Writes the same object, with the gains of every age if asked for, piece by piece.
    ///
    /// # Errors
    /// Those of `writer`.
    pub fn write_json(&self, writer: impl Write, mode_gains: ModeGains) -> io::Result<()> {
        write_line_per_field(writer, &Document::of(self, mode_gains))
    }

    /// The certificate's file, if there is one: see [`crate::certificate`].
    pub fn certificate_json(&self) -> Option<String> {
        let (problem, gains) =
            (LoopProblem::of(&self.design), self.solution.emitted_gains(self.design.controller.scalar));
        Some(self.certificate.as_ref()?.to_json(&self.design.name, &problem, &gains))
    }
}
