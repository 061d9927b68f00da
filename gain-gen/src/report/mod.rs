//! What a design comes to: gains, the stability verdict and the figures behind it.
//!
//! [`Report`] holds them all; `text` and `json` only write them down, and so does [`crate::emit`].
//! `condition` says which condition for stability fails, `figure` how numbers are spelled for people.

mod condition;
mod figure;
mod json;
mod text;

use crate::certificate::{Certificate, NotCertified, certify};
use crate::design::{Design, DeviceScalar};
use crate::estimation::Estimation;
use crate::margins::{Margins, margins};
use crate::solve::{
    FiniteHorizon, LoopProblem, Method, Outcome, Solution, age_transitions, finite_horizon, solve,
};
use crate::stability;
use nalgebra::DMatrix;
use slqg::DefaultInput;

pub use condition::FailedCondition;
pub(crate) use figure::{counted, figure, grouped};
pub(crate) use json::{Document, line_per_field, rows};

/// Whether the closed loop is mean-square stable with the optimal gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It is.
    Stable,
    /// It is not, and so with no other gains of this sequence length and default input.
    Unstable,
    /// Neither shown within the iterations allowed.
    Undecided,
}

impl Verdict {
    /// As in reports and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Unstable => "unstable",
            Self::Undecided => "undecided",
        }
    }
}

/// A design, its solution and everything that is told about it.
#[derive(Debug, Clone)]
pub struct Report {
    /// The design the figures are for.
    pub design: Design,
    /// The recursion that computed the gains.
    pub method: Method,
    /// Gains and how the recursion ended.
    pub solution: Solution,
    /// Conditions for stability that do not hold; empty iff the verdict is [`Verdict::Stable`].
    pub failed_conditions: Vec<FailedCondition>,
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
    /// Time-varying gains for a task of finite length; `None` before [`Report::find_task`].
    pub task: Option<FiniteHorizon>,
    /// Distances to instability; `None` before [`Report::find_margins`] and for a loop that is not stable.
    pub margins: Option<Margins>,
    /// Proof of stability; `None` before [`Report::certify`] and for a loop that is not stable.
    pub certificate: Option<Certificate>,
}

impl Report {
    /// Solves the design with `method` and judges the outcome.
    ///
    /// The shortest lengths are looked for with the in-flight recursion whatever the method; it is the fast one.
    pub fn new(design: &Design, method: Method) -> Self {
        let problem = LoopProblem::of(design);
        let solution = solve(&problem, method);
        let n_min = stability::shortest_admissible_length(&problem);
        let n_crit = stability::critical_length(&problem);
        Self {
            failed_conditions: condition::failed(design, &problem, &solution, n_crit),
            transition_matrix: age_transitions(&problem.link, problem.length),
            open_loop_modulus: stability::open_loop_modulus(&problem.a),
            dry_growth: stability::dry_growth(&problem, problem.length),
            sight_growth: stability::sight_growth(
                &design.plant,
                &design.network.sensor_to_controller,
                design.controller.measurement_buffer,
            ),
            estimation: Estimation::of(design, &solution),
            design: design.clone(),
            method,
            solution,
            n_min,
            n_crit,
            task: None,
            margins: None,
            certificate: None,
        }
    }

    /// Adds the gains of a task of `cycles` cycles, at least one, that ends with the terminal weight.
    pub fn find_task(&mut self, cycles: usize) {
        let problem = LoopProblem::of(&self.design);
        self.task = Some(finite_horizon(&problem, &self.design.cost.terminal, cycles));
    }

    /// Expected cost of the task with the state known; `None` before [`Report::find_task`].
    pub fn task_cost(&self) -> Option<f64> {
        let plant = &self.design.plant;
        let task = self.task.as_ref()?;
        Some(task.control_cost(&plant.initial_mean, &plant.initial_covariance, &plant.process_noise))
    }

    /// Adds the margins if the verdict is [`Verdict::Stable`]. Dense: slow for long sequences.
    pub fn find_margins(&mut self) {
        if self.verdict() == Verdict::Stable {
            self.margins = margins(&LoopProblem::of(&self.design), &self.solution);
        }
    }

    /// Adds a certificate if the verdict is [`Verdict::Stable`]. Dense: slow for long sequences.
    ///
    /// # Errors
    /// The loop is stable by its figures, but rounding does not let it be proved.
    pub fn certify(&mut self) -> Result<(), NotCertified> {
        if self.verdict() == Verdict::Stable {
            self.certificate = Some(certify(&LoopProblem::of(&self.design), &self.solution)?);
        }
        Ok(())
    }

    /// Whether the closed loop is stable: the recursion's outcome, and whether measurements come often enough.
    pub fn verdict(&self) -> Verdict {
        if self.failed_conditions.is_empty() {
            Verdict::Stable
        } else if self
            .failed_conditions
            .iter()
            .all(|failed| matches!(failed, FailedCondition::Undecided { .. }))
        {
            Verdict::Undecided
        } else {
            Verdict::Unstable
        }
    }

    /// Nothing if the loop is stable, otherwise the error that says why it is not.
    ///
    /// # Errors
    /// The verdict is not [`Verdict::Stable`].
    pub fn require_stable(&self) -> Result<(), NotStabilised> {
        if self.failed_conditions.is_empty() {
            return Ok(());
        }
        Err(NotStabilised {
            name: self.design.name.clone(),
            length: self.design.controller.sequence_length,
            default_input: self.design.controller.default_input,
            verdict: self.verdict(),
            conditions: self.failed_conditions.clone(),
        })
    }

    /// Long-run average cost per step with the state known, `tr(P W)`; infinite if the recursion did not converge.
    pub fn control_cost(&self) -> f64 {
        match self.solution.outcome {
            Outcome::Converged => self.solution.control_cost(&self.design.plant.process_noise),
            Outcome::Unstable | Outcome::Undecided => f64::INFINITY,
        }
    }

    /// Steps in which the closed loop's second moments fall to 1/e, `-1 / ln(rate)`; `None` if they do not fall.
    pub fn time_constant(&self) -> Option<f64> {
        let rate = self.solution.mean_square_rate;
        (rate < 1.0).then(|| -1.0 / rate.ln())
    }

    /// Expected inputs that the law takes, `n_v`.
    pub fn in_flight(&self) -> usize {
        self.solution.law.default_input.in_flight(self.solution.law.length)
    }
}

/// A loop that is not shown to be stable cannot be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "{name:?} with N = {length} and default input {} {}: {}",
    default_input_name(*default_input),
    match verdict { Verdict::Undecided => "is undecided", _ => "cannot be stabilised" },
    spelled(conditions)
)]
pub struct NotStabilised {
    /// Name of the design.
    pub name: String,
    /// Inputs per sequence, `N`.
    pub length: usize,
    /// What the actuator applies when its buffer has run out.
    pub default_input: DefaultInput,
    /// Unstable or undecided.
    pub verdict: Verdict,
    /// Why; not empty.
    pub conditions: Vec<FailedCondition>,
}

fn spelled(conditions: &[FailedCondition]) -> String {
    conditions.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n  ")
}

/// As in design files, on the command line and in JSON.
pub(crate) const fn default_input_name(default_input: DefaultInput) -> &'static str {
    match default_input {
        DefaultInput::Zero => "zero",
        DefaultInput::Hold => "hold",
    }
}

/// As in design files and in Rust.
pub(crate) const fn scalar_name(scalar: DeviceScalar) -> &'static str {
    match scalar {
        DeviceScalar::F32 => "f32",
        DeviceScalar::F64 => "f64",
    }
}
