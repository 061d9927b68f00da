//! Which condition for stability fails or is open, with its figures, and the error that says so.
//!
//! How each is told is in `sentence`.

mod sentence;

use super::Verdict;
use crate::design::{Acknowledgement, Behaviour, Design};
use crate::estimation::{EstimationVerdict, Sight};
use crate::solve::{LoopProblem, Outcome, Solution};
use crate::stability::{self, Growth, growth};
use slqg::DefaultInput;

/// A condition for stability that does not hold, or is not shown to. `Display` is a sentence with the figures and a way
/// out.
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
    /// The error of the estimate grows without bound, although Theorem 3.4 a) does not say so: modes come round together.
    ErrorGrows {
        /// `q_arr`: probability that a measurement arrives within the buffer.
        arrival: f64,
        /// `q_lim`: above it the error stays bounded.
        limit: f64,
    },
    /// Rounding leaves it open whether the error of the estimate stays bounded.
    ErrorOpen {
        /// `q_arr`: probability that a measurement arrives within the buffer.
        arrival: f64,
        /// `q_lim`: above it the error stays bounded.
        limit: f64,
    },
    /// Rounding to the device's scalar takes the loop's stability, which it has with exact gains.
    Rounded {
        /// Mean-square rate with the numbers that are emitted, not below 1.
        rate: f64,
    },
    /// The estimator does not always know what was applied: nothing proves that the loop with it is stable.
    Unacknowledged {
        /// Probability that an acknowledgement is there before the next cycle; 0 where there are none.
        in_time: f64,
    },
    /// Packets on a link are not independent, and gains, filter and theorems take them as such.
    Dependent {
        /// The link's key in the design file.
        key: &'static str,
    },
    /// Inputs have limits and the plant does not come back by itself: nothing proves that the loop is stable.
    Limited {
        /// Largest modulus of the eigenvalues of `A`, per step.
        modulus: f64,
        /// [`Growth::OnTheLimit`] or [`Growth::Grows`].
        growth: Growth,
    },
}

impl FailedCondition {
    /// Whether it is not known to fail, only not shown to hold.
    pub const fn is_open(&self) -> bool {
        match self {
            Self::Undecided { .. }
            | Self::ErrorOpen { .. }
            | Self::Unacknowledged { .. }
            | Self::Dependent { .. }
            | Self::Limited { .. } => true,
            Self::RunsDry { .. }
            | Self::NoFixedPoint { .. }
            | Self::LosesSight { .. }
            | Self::ErrorGrows { .. }
            | Self::Rounded { .. } => false,
        }
    }

    /// Whether it is one of the three that every report tells with its figures.
    pub(super) const fn is_numbered(&self) -> bool {
        matches!(
            self,
            Self::RunsDry { .. }
                | Self::NoFixedPoint { .. }
                | Self::Undecided { .. }
                | Self::LosesSight { .. }
        )
    }

    /// Whether it is about the loop of the theorems: gains with the state known, and the filter.
    pub const fn is_of_theorems(&self) -> bool {
        !matches!(
            self,
            Self::Rounded { .. }
                | Self::Unacknowledged { .. }
                | Self::Dependent { .. }
                | Self::Limited { .. }
        )
    }
}

/// The conditions that fail or are open, those of the theorems first.
pub(crate) fn failed(
    design: &Design,
    problem: &LoopProblem,
    solution: &Solution,
    emitted_rate: f64,
    sight: Sight,
    critical: Option<usize>,
) -> Vec<FailedCondition> {
    let conditions = [
        control(problem, solution, critical),
        estimation(design, sight),
        rounding(solution, emitted_rate),
        acknowledgement(design),
        dependence(design),
        limits(design),
    ];
    conditions.into_iter().flatten().collect()
}

/// Where Theorem 3.4 b) fails the recursion must diverge; that is not told twice.
fn control(problem: &LoopProblem, solution: &Solution, critical: Option<usize>) -> Option<FailedCondition> {
    let rate = solution.mean_square_rate;
    match solution.outcome {
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
    }
}

fn estimation(design: &Design, sight: Sight) -> Option<FailedCondition> {
    let (plant, link) = (&design.plant, &design.network.sensor_to_controller.delays);
    let buffer = design.controller.measurement_buffer;
    let Sight { arrival, limit, verdict } = sight;
    match verdict {
        EstimationVerdict::Stable => None,
        EstimationVerdict::Open => Some(FailedCondition::ErrorOpen { arrival, limit }),
        EstimationVerdict::Unstable if stability::loses_sight(plant, link, buffer) => {
            Some(FailedCondition::LosesSight {
                growth: stability::sight_growth(plant, link, buffer),
                buffer,
                shortest: (0..=link.largest_delay())
                    .find(|&steps| !stability::loses_sight(plant, link, steps)),
            })
        }
        EstimationVerdict::Unstable => Some(FailedCondition::ErrorGrows { arrival, limit }),
    }
}

fn rounding(solution: &Solution, rate: f64) -> Option<FailedCondition> {
    let is_stable = rate < 1.0;
    (solution.is_stabilising() && !is_stable).then_some(FailedCondition::Rounded { rate })
}

fn acknowledgement(design: &Design) -> Option<FailedCondition> {
    let in_time = match &design.network.acknowledgement {
        Acknowledgement::Instant => 1.0,
        Acknowledgement::None => 0.0,
        Acknowledgement::Over(link) => link.delays.arrival(0),
    };
    (in_time < 1.0).then_some(FailedCondition::Unacknowledged { in_time })
}

/// The first link that is not one of independent delays.
fn dependence(design: &Design) -> Option<FailedCondition> {
    let network = &design.network;
    let links = [
        ("network.controller_to_actuator", &network.controller_to_actuator),
        ("network.sensor_to_controller", &network.sensor_to_controller),
    ];
    let dependent = links.into_iter().find(|(_, link)| !matches!(link.behaviour, Behaviour::Independent));
    dependent.map(|(key, _)| FailedCondition::Dependent { key })
}

/// A plant that comes back by itself stays bounded under inputs that are, whatever the controller does.
fn limits(design: &Design) -> Option<FailedCondition> {
    let growth = growth(&design.plant);
    let is_open = design.controller.input_limits.is_some() && growth != Growth::Decays;
    let modulus = stability::open_loop_modulus(&design.plant.a);
    is_open.then_some(FailedCondition::Limited { modulus, growth })
}

/// A loop that is not shown to be stable.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "{name:?} with N = {length} and default input {} {}: {}",
    default_input.name(),
    match verdict { Verdict::Undecided => "is not shown to be stable", _ => "cannot be stabilised" },
    sentence::spelled(conditions)
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
