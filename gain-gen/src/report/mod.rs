//! What a design comes to: gains, the stability verdict and the figures behind it.
//!
//! [`Report`] holds them all; `text` and `json` only write them down.
//! `applied` says how near inputs come to their limits, `condition` which condition for stability fails or is open, `verdict` what they come to, `channel` what a link that comes and goes adds, `task` what a task of
//! finite length adds, `rounding` what counted values cost, `emission` what of it is emitted.

mod applied;
mod channel;
mod condition;
mod emission;
mod json;
mod rounding;
mod task;
mod text;
mod verdict;

use crate::certificate::{Certificate, NotCertified, certify_gains};
use crate::channels;
use crate::design::Design;
use crate::estimation::Estimation;
use crate::figure;
use crate::margins::{Margins, NotGiven, margins};
use crate::solve::{
    FiniteHorizon, Law, LoopProblem, Method, Outcome, PreviewGains, PreviewTooLong, Scheduled, Schedules,
    Solution, Start, TriggerTables, Unacknowledged, age_transitions, applied_costs, critical_length,
    emitted_rate, if_linear, scheduled, shortest_unacknowledged, trigger_tables,
};
use crate::stability;
use crate::warnings::{self, Warning};
use nalgebra::DMatrix;
use slqg::estimator::Merging;

pub use crate::channels::ControlOnChannel;
pub use crate::saturation::NotShown;
pub use applied::AppliedInput;
pub use channel::ChannelDesigns;
pub(crate) use condition::failed;
pub use condition::{FailedCondition, NotKnown, NotStabilised};
pub use emission::NotEmittable;
pub use json::{MOST_MODE_GAINS, ModeGains};
pub use task::{LONGEST_TASK, NoTask};
pub use verdict::{LimitsShown, Verdict};

/// A design, its solution and everything that is told about it.
#[derive(Debug, Clone)]
pub struct Report {
    /// The design the figures are for.
    pub design: Design,
    /// The recursion that computed the gains.
    pub method: Method,
    /// Gains and how the recursion ended.
    pub solution: Solution,
    /// The law and the loop without acknowledgements; `None` with others than the linear estimator, or where none was found.
    pub unacknowledged: Option<Unacknowledged>,
    /// Mean-square rate with the numbers that are emitted: [`Solution::emitted_rate`].
    pub emitted_rate: f64,
    /// Conditions for stability that do not hold or are not shown to; empty iff the verdict is [`Verdict::Stable`].
    pub failed_conditions: Vec<FailedCondition>,
    /// Whether [`crate::emit`] writes it although its stability is undecided: [`Report::accept_undecided_stability`].
    pub accepts_undecided_stability: bool,
    /// Transition probabilities of the actuator's age, `(N+1) x (N+1)`; the last state is an empty buffer.
    pub transition_matrix: DMatrix<f64>,
    /// Largest modulus of the eigenvalues of `A`, per step.
    pub open_loop_modulus: f64,
    /// `(1 - Q(N-1)) |lambda_max(A)|^2`, at most 1 in a loop that can be stabilised. Theorem 3.4 b).
    pub dry_growth: f64,
    /// `(1 - q_arr) |lambda_max(A)|^2`, below 1 in a loop whose state can be followed. Theorem 3.4 a).
    pub sight_growth: f64,
    /// Shortest length that Theorem 3.4 b) does not rule out; `None` if it rules out all.
    pub n_min: Option<usize>,
    /// Shortest length that stabilises; `None` if none was found.
    pub n_crit: Option<usize>,
    /// The estimator, and what the loop costs with it.
    pub estimation: Estimation,
    /// What a reference adds to the law; `None` if the design follows none, or no steady state was found.
    pub preview: Option<Result<PreviewGains, PreviewTooLong>>,
    /// What sending a packet is worth; `None` if the design sends in every cycle, or no steady state was found.
    pub trigger: Option<TriggerTables>,
    /// The schedule that later packets are taken to follow, or all do; `None` if a packet is taken to be sent in every cycle, or no
    /// schedule was found.
    pub scheduled: Option<Scheduled>,
    /// What packets at fixed times cost instead; `None` if packets have no price, with `[tracking]`, whose cost depends on the
    /// reference, or if no schedule is shown to stabilise the loop.
    pub schedules: Option<Schedules>,
    /// Time-varying gains for a task of finite length; `None` before [`Report::find_task`].
    pub task: Option<FiniteHorizon>,
    /// Distances to instability; `None` before [`Report::find_margins`] and for a loop that has not [`Report::converged`].
    pub margins: Option<Margins>,
    /// Why there are none although [`Report::find_margins`] looked for them.
    pub margins_not_given: Option<NotGiven>,
    /// Designs for a link whose quality comes and goes; `None` before [`Report::find_channel`] and for other links.
    pub channel: Option<ChannelDesigns>,
    /// The loop on the channel of the link to the actuator, where its packets are not independent and that is known.
    pub on_channel: Option<ControlOnChannel>,
    /// What the design asks for that makes no sense.
    pub warnings: Vec<Warning>,
    /// How large the inputs applied are, `nu` of them; `None` without input limits, or where no gains were found.
    pub applied: Option<Vec<AppliedInput>>,
    /// Proof of stability; `None` before [`Report::certify`] and for a loop that has not [`Report::converged`].
    pub certificate: Option<Certificate>,
}

impl Report {
    /// Solves the design with `method` and judges the outcome.
    ///
    /// The shortest lengths are looked for with the in-flight recursion whatever the method; it is the fast one. Preview
    /// gains and the event trigger come from it too: the coupled one has no such form of them.
    pub fn new(design: &Design, method: Method) -> Self {
        let problem = LoopProblem::of(design);
        let start = Start::of(&problem);
        let solution = start.solve(method).for_acknowledgements(design, &problem);
        let n_min = stability::shortest_admissible_length(&problem);
        let n_crit = critical_length(&problem, &start, &solution);
        let needs_more = method == Method::Coupled && (design.tracking.is_some() || design.event.is_some());
        let in_flight = needs_more.then(|| start.solve(Method::InFlight));
        let steady = in_flight.as_ref().unwrap_or(&solution);
        let estimation = Estimation::of(design, &solution);
        let unacknowledged = if_linear(design, &problem, &solution);
        let schedules = schedules(design, &problem, &estimation);
        let found = scheduled(design, &problem, &estimation.error_covariance());
        let not_scheduled = found.as_ref().err().copied();
        let scheduled = found.ok().flatten();
        let emitted_rate = match &scheduled {
            Some(found) => found.schedule.emitted_rate(design.controller.scalar),
            None => emitted_rate(design, &problem, &solution, unacknowledged.as_ref()),
        };
        let estimation = match &scheduled {
            Some(Scheduled { schedule, .. }) => {
                let weight = schedule.error_weight(&problem) / schedule.period as f64;
                estimation.of_schedule(schedule.control_cost(&design.plant.process_noise), &weight)
            }
            None => estimation,
        };
        let on_channel = channels::control(design, &problem, &solution);
        let costs = design.controller.input_limits.as_ref().and_then(|_| applied_costs(&problem, &solution));
        Self {
            on_channel,
            preview: PreviewGains::of(design, steady),
            trigger: design
                .event
                .filter(|_| scheduled.is_none() && not_scheduled.is_none())
                .and_then(|_| trigger_tables(&problem, steady)),
            schedules,
            emitted_rate,
            failed_conditions: condition::failed(
                design,
                &problem,
                (&solution, unacknowledged.as_ref()),
                emitted_rate,
                estimation.sight(),
                on_channel,
                (n_crit, || shortest_unacknowledged(design)),
            )
            .into_iter()
            .chain(not_scheduled.filter(|_| solution.is_stabilising()).map(FailedCondition::NotScheduled))
            .collect(),
            accepts_undecided_stability: false,
            transition_matrix: age_transitions(&problem.link, problem.length),
            open_loop_modulus: stability::open_loop_modulus(&problem.a),
            dry_growth: stability::dry_growth(&problem, problem.length),
            sight_growth: stability::sight_growth(
                &design.plant,
                &design.network.sensor_to_controller.delays,
                design.controller.measurement_buffer,
            ),
            applied: costs
                .filter(|_| scheduled.is_none())
                .map(|costs| AppliedInput::all(design, &estimation, &costs)),
            scheduled,
            estimation,
            warnings: [warnings::of_design(design), warnings::of_loop(design, &solution)].concat(),
            design: design.clone(),
            method,
            solution,
            n_min,
            n_crit,
            task: None,
            margins: None,
            margins_not_given: None,
            channel: None,
            certificate: None,
            unacknowledged,
        }
    }

    /// Adds the margins if the loop has [`Report::converged`]. Dense: slow for long sequences.
    pub fn find_margins(&mut self) {
        if self.design.estimator() == Merging::Linear {
            self.margins_not_given = Some(NotGiven::Unacknowledged);
        } else if self.scheduled.is_some() {
            self.margins_not_given = Some(NotGiven::EventTrigger);
        } else if self.converged() {
            self.margins = margins(&self.design, &self.solution);
        }
    }

    /// Adds a certificate for the numbers that are emitted if the loop has [`Report::converged`]. Dense: slow for long sequences.
    ///
    /// # Errors
    /// The loop is stable by its figures, but rounding does not let it be proved; or there are no acknowledgements and the law is
    /// made for that.
    pub fn certify(&mut self) -> Result<(), NotCertified> {
        if self.design.estimator() == Merging::Linear {
            return Err(NotCertified::Unacknowledged);
        }
        if self.scheduled.is_some() {
            return Err(NotCertified::Scheduled);
        }
        if self.converged() {
            let gains = self.solution.emitted_gains(self.design.controller.scalar);
            self.certificate =
                Some(certify_gains(&LoopProblem::of(&self.design), &gains, self.emitted_rate)?);
        }
        Ok(())
    }

    /// Nothing if the design follows no reference or its preview gains were found, otherwise why they were not.
    ///
    /// # Errors
    /// The preview that the design asks for is too long.
    pub fn require_preview(&self) -> Result<(), PreviewTooLong> {
        match self.preview {
            Some(Err(too_long)) => Err(too_long),
            Some(Ok(_)) | None => Ok(()),
        }
    }

    /// Numbers of the preview gains that the device needs: an event trigger needs more of them.
    pub fn preview_floats(&self) -> Option<usize> {
        let gains = self.preview.as_ref()?.as_ref().ok()?;
        Some(if self.trigger.is_some() { gains.floats() } else { gains.sequence.len() })
    }

    /// Long-run average cost per step with the state known, `tr(P W)`; infinite if the recursion did not converge.
    pub fn control_cost(&self) -> f64 {
        if let Some(found) = &self.scheduled {
            return found.schedule.control_cost(&self.design.plant.process_noise);
        }
        match self.solution.outcome {
            Outcome::Converged => self.solution.control_cost(&self.design.plant.process_noise),
            Outcome::Unstable | Outcome::Undecided => f64::INFINITY,
        }
    }

    /// The law that the device computes with.
    pub fn law(&self) -> &Law {
        match (&self.unacknowledged, &self.scheduled) {
            (Some(found), _) => &found.law,
            (None, Some(found)) => &found.schedule.law,
            (None, None) => &self.solution.law,
        }
    }

    /// Factor by which second moments change per cycle: with the state known, or without acknowledgements of the whole loop.
    pub fn mean_square_rate(&self) -> f64 {
        match (&self.unacknowledged, &self.scheduled) {
            (Some(found), _) => found.rate,
            (None, Some(found)) => found.schedule.mean_square_rate,
            (None, None) => self.solution.mean_square_rate,
        }
    }

    /// Steps in which the closed loop's second moments fall to 1/e, `-1 / ln(rate)`; `None` if they do not fall.
    pub fn time_constant(&self) -> Option<f64> {
        let rate = self.mean_square_rate();
        (rate < 1.0).then(|| -1.0 / rate.ln())
    }

    /// Expected inputs that the law takes, `n_v`.
    pub fn in_flight(&self) -> usize {
        self.solution.law.default_input.in_flight(self.solution.law.length)
    }
}

/// What packets at fixed times cost.
fn schedules(design: &Design, problem: &LoopProblem, estimation: &Estimation) -> Option<Schedules> {
    let event = design.event.filter(|_| design.tracking.is_none())?;
    Schedules::of(problem, event.send_cost, &design.plant.process_noise, &estimation.error_covariance())
}
