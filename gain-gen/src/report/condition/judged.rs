//! Which conditions fail or are open for a design, its gains and its links.

use super::{FailedCondition, NotKnown};
use crate::channels::ControlOnChannel;
use crate::design::{Acknowledgement, Behaviour, Design, Link};
use crate::estimation::{EstimationVerdict, OnChannel, Sight};
use crate::saturation;
use crate::solve::{LoopProblem, Outcome, Solution, Unacknowledged};
use crate::stability::{self, Growth, growth};
use slqg::estimator::Merging;

/// Keys of the links in the design file.
const ACTUATOR: &str = "network.controller_to_actuator";
const SENSOR: &str = "network.sensor_to_controller";
/// Distance of a rate on a channel from 1 that is not rounding.
const CLEAR: f64 = 1e-7;

/// The conditions that fail or are open, those of the theorems first.
pub(crate) fn failed(
    design: &Design,
    problem: &LoopProblem,
    (solution, unacknowledged): (&Solution, Option<&Unacknowledged>),
    emitted_rate: f64,
    sight: Sight,
    on_channel: Option<ControlOnChannel>,
    (critical, shortest): (Option<usize>, impl FnOnce() -> Option<usize>),
) -> Vec<FailedCondition> {
    let network = &design.network;
    let control = control(problem, solution, critical)
        .map(|failed| averaged(ACTUATOR, &network.controller_to_actuator, failed));
    let conditions = [
        control,
        estimation(design, sight),
        rounding(solution, emitted_rate),
        acknowledgement(design, solution, unacknowledged, shortest),
        control_dependence(design, on_channel),
        sensor_dependence(design),
        limits(design, solution),
    ];
    conditions.into_iter().flatten().collect()
}

/// The condition, which is one of independent packets, as it stands for what this link is.
fn averaged(key: &'static str, link: &Link, failed: FailedCondition) -> FailedCondition {
    match is_independent(link) || failed.is_open() {
        true => failed,
        false => FailedCondition::Averaged { key, condition: Box::new(failed) },
    }
}

fn is_independent(link: &Link) -> bool {
    link.behaviour == Behaviour::Independent && link.duplicates == 0.0
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
    let Sight { arrival, limit, verdict, channel } = sight;
    if let Some(OnChannel { verdict, loss_growth: growth, rate }) = channel {
        return match verdict {
            EstimationVerdict::Stable => None,
            EstimationVerdict::Unstable => Some(FailedCondition::LostInARow { growth }),
            EstimationVerdict::Open => {
                Some(FailedCondition::Dependent { key: SENSOR, reason: NotKnown::Between { growth, rate } })
            }
        };
    }
    let failed = match verdict {
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
    };
    failed.map(|failed| averaged(SENSOR, &design.network.sensor_to_controller, failed))
}

fn rounding(solution: &Solution, rate: f64) -> Option<FailedCondition> {
    let is_stable = rate < 1.0;
    (solution.is_stabilising() && !is_stable).then_some(FailedCondition::Rounded { rate })
}

fn acknowledgement(
    design: &Design,
    solution: &Solution,
    unacknowledged: Option<&Unacknowledged>,
    shortest: impl FnOnce() -> Option<usize>,
) -> Option<FailedCondition> {
    if design.estimator() == Merging::Linear {
        return match unacknowledged {
            Some(found) if found.is_exact => None,
            Some(found) => {
                let Unacknowledged { hears, late_rate, .. } = *found;
                Some(FailedCondition::HeardLate { hears, late_rate })
            }
            // Of a loop that is unstable in any case that is told already.
            None if solution.is_stabilising() => Some(FailedCondition::NoLinearLaw { shortest: shortest() }),
            None => None,
        };
    }
    let in_time = match &design.network.acknowledgement {
        Acknowledgement::Instant => 1.0,
        Acknowledgement::None => 0.0,
        Acknowledgement::Over(link) => link.delays.arrival(0),
    };
    (in_time < 1.0).then_some(FailedCondition::Unacknowledged { in_time })
}

/// What the link to the actuator does to the loop, where its packets are not independent with the delays that gains are for.
fn control_dependence(design: &Design, on_channel: Option<ControlOnChannel>) -> Option<FailedCondition> {
    let dependent = |reason| Some(FailedCondition::Dependent { key: ACTUATOR, reason });
    if let Some(reason) = unknown(&design.network.controller_to_actuator) {
        return dependent(reason);
    }
    if design.estimator() == Merging::Linear && !is_independent(&design.network.controller_to_actuator) {
        return dependent(NotKnown::Unacknowledged);
    }
    match on_channel? {
        _ if design.event.is_some() => dependent(NotKnown::EventTrigger),
        ControlOnChannel::TooLarge => dependent(NotKnown::TooLarge),
        ControlOnChannel::Rate { rate, .. } if rate < 1.0 - CLEAR => None,
        ControlOnChannel::Rate { rate, .. } if rate > 1.0 + CLEAR => {
            Some(FailedCondition::OnChannel { rate })
        }
        ControlOnChannel::Rate { rate, .. } => dependent(NotKnown::Near { rate }),
    }
}

/// The same of the sensor's link where nothing at all is known of it; the rest is a matter of `estimation`.
fn sensor_dependence(design: &Design) -> Option<FailedCondition> {
    let reason = unknown(&design.network.sensor_to_controller)?;
    Some(FailedCondition::Dependent { key: SENSOR, reason })
}

/// Why nothing is known of how packets on this link depend on each other.
fn unknown(link: &Link) -> Option<NotKnown> {
    match link.behaviour {
        Behaviour::Independent | Behaviour::Markov(_) => None,
        Behaviour::Recorded(_) => Some(NotKnown::Recorded),
        Behaviour::Bus => Some(NotKnown::Bus),
    }
}

/// A plant that comes back by itself stays bounded under inputs that are, whatever the controller does.
fn limits(design: &Design, solution: &Solution) -> Option<FailedCondition> {
    let growth = growth(&design.plant);
    if design.controller.input_limits.is_none() || growth == Growth::Decays {
        return None;
    }
    let reason = match (growth, solution.is_stabilising()) {
        (Growth::OnTheLimit, true) if design.estimator() != Merging::Linear => {
            Some(saturation::pushed_back(design, &solution.law).err()?)
        }
        _ => None,
    };
    let modulus = stability::open_loop_modulus(&design.plant.a);
    Some(FailedCondition::Limited { modulus, growth, reason })
}
