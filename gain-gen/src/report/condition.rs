//! Which condition for stability fails, with its figures and what would mend it, and the error that says so.

use super::figure::figure;
use super::{Verdict, default_input_name};
use crate::design::Design;
use crate::solve::{LoopProblem, Outcome, Solution};
use crate::stability;
use slqg::DefaultInput;

/// A condition for stability that does not hold. `Display` is a sentence with the figures and a way out.
#[derive(Debug, Clone, PartialEq)]
pub enum FailedCondition {
    /// Thesis Theorem 3.4 b): the actuator's buffer runs dry too often for any controller.
    RunsDry {
        /// `(1 - Q(N-1)) |lambda_max(A)|^2`, above 1.
        growth: f64,
        /// Shortest length for which it is not, if there is one.
        shortest: Option<usize>,
    },
    /// Thesis Theorem 3.3 b), decided by the recursion: no gains of this length stabilise the loop.
    NoFixedPoint {
        /// Mean-square rate of the gains the diverging recursion tends to, per step.
        rate: f64,
        /// Shortest length that stabilises, if one was found.
        critical: Option<usize>,
    },
    /// Neither convergence nor divergence was shown.
    Undecided {
        /// Steps the recursion was given.
        iterations: usize,
        /// Mean-square rate after them, per step.
        rate: f64,
        /// Relative residual of the fixed-point equation after them.
        residual: f64,
    },
    /// Thesis Theorem 3.4 a): too few measurements arrive within the buffer for any filter.
    LosesSight {
        /// `(1 - q_arr) |lambda_max(A)|^2`, at least 1.
        growth: f64,
        /// `N^B`, in steps.
        buffer: usize,
        /// Shortest buffer for which it is below 1, in steps, if there is one.
        shortest: Option<usize>,
    },
}

impl core::fmt::Display for FailedCondition {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::RunsDry { growth, shortest } => {
                let growth = figure(*growth);
                write!(f, "Theorem 3.4 b): (1 - Q(N-1)) |lambda_max(A)|^2 = {growth} > 1: ")?;
                write!(f, "the actuator's buffer runs dry too often; ")?;
                match shortest {
                    Some(length) => write!(f, "the shortest length not ruled out is N = {length}"),
                    None => f.write_str("every length is ruled out: the link loses too many packets"),
                }
            }
            Self::NoFixedPoint { rate, critical } => {
                let rate = figure(*rate);
                write!(f, "Theorem 3.3 b): the recursion does not converge; ")?;
                write!(f, "mean-square rate of the best gains {rate} >= 1; ")?;
                match critical {
                    Some(length) => write!(f, "the shortest length that stabilises is N_crit = {length}"),
                    None => f.write_str("no length that stabilises was found"),
                }
            }
            Self::Undecided { iterations, rate, residual } => {
                let (rate, residual) = (figure(*rate), figure(*residual));
                write!(f, "Theorem 3.3 b): neither convergence nor divergence within {iterations} steps; ")?;
                write!(f, "mean-square rate {rate}, residual {residual}: too close to the limit of stability")
            }
            Self::LosesSight { growth, buffer, shortest } => {
                let growth = figure(*growth);
                write!(
                    f,
                    "Theorem 3.4 a): (1 - q_arr) |lambda_max(A)|^2 = {growth} >= 1: too few measurements "
                )?;
                write!(f, "arrive within the buffer of N^B = {buffer} steps; ")?;
                match shortest {
                    Some(steps) => write!(f, "the shortest buffer not ruled out is N^B = {steps}"),
                    None => f.write_str("every buffer is ruled out: the link loses too many packets"),
                }
            }
        }
    }
}

/// The conditions that fail. Where Theorem 3.4 b) fails the recursion must diverge; that is not told twice.
pub(super) fn failed(
    design: &Design,
    problem: &LoopProblem,
    solution: &Solution,
    critical: Option<usize>,
) -> Vec<FailedCondition> {
    let rate = solution.mean_square_rate;
    let control = match solution.outcome {
        Outcome::Converged => None,
        _ if stability::runs_dry(problem) => Some(FailedCondition::RunsDry {
            growth: stability::dry_growth(problem, problem.length),
            shortest: stability::shortest_admissible_length(problem),
        }),
        Outcome::Unstable => Some(FailedCondition::NoFixedPoint { rate, critical }),
        Outcome::Undecided => {
            let Solution { iterations, residual, .. } = *solution;
            Some(FailedCondition::Undecided { iterations, rate, residual })
        }
    };
    let (plant, link) = (&design.plant, &design.network.sensor_to_controller.delays);
    let buffer = design.controller.measurement_buffer;
    let estimation = stability::loses_sight(plant, link, buffer).then(|| FailedCondition::LosesSight {
        growth: stability::sight_growth(plant, link, buffer),
        buffer,
        shortest: (0..=link.largest_delay()).find(|&steps| !stability::loses_sight(plant, link, steps)),
    });
    control.into_iter().chain(estimation).collect()
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
