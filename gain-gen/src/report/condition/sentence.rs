//! What people are told of a condition: a sentence with the figures and a way out.

use super::{FailedCondition, NotKnown};
use crate::report::figure::{figure, percent};
use crate::solve::{LONGEST_TRIED, NotScheduled};
use crate::stability::Growth;
use core::fmt::{self, Display, Formatter};

impl Display for FailedCondition {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
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
            Self::ErrorGrows { arrival, limit } => {
                let (arrival, limit) = (percent(*arrival), percent(*limit));
                write!(
                    f,
                    "estimation: the error of the estimate grows without bound: q_arr = {arrival} of the "
                )?;
                write!(
                    f,
                    "measurements count, and more than q_lim = {limit} must; measure more outputs, lose "
                )?;
                f.write_str("fewer measurements or wait for them longer (controller.measurement_buffer)")
            }
            Self::ErrorOpen { arrival, limit } => {
                let (arrival, limit) = (percent(*arrival), percent(*limit));
                write!(
                    f,
                    "estimation: q_arr = {arrival} of the measurements count, which rounding does not tell "
                )?;
                write!(
                    f,
                    "from the limit q_lim = {limit}: whether the error of the estimate stays bounded is not "
                )?;
                f.write_str("decided; above the limit it does")
            }
            Self::Rounded { rate } => write!(
                f,
                "controller.scalar: the gains rounded to f32 have the mean-square rate {} >= 1, the exact ones are \
                 stable: the loop is too close to the limit of stability; choose \"f64\"",
                figure(*rate)
            ),
            Self::Unacknowledged { in_time } => {
                f.write_str("network.acknowledgement: ")?;
                match *in_time {
                    0.0 => f.write_str("none comes in time")?,
                    share => write!(f, "{} come in time", percent(share))?,
                }
                f.write_str(
                    ": the theorems are about a filter that knows what was applied; of one that has to guess it, \
                     nothing shows that its second moments stay bounded. Rate and costs are those of the loop \
                     with instant acknowledgements; host-sim run shows the loop as it is",
                )
            }
            Self::NoLinearLaw { shortest } => {
                f.write_str(
                    "network.acknowledgement: without any, no law was found that keeps second moments bounded; ",
                )?;
                match shortest {
                    Some(length) => write!(f, "the shortest length for which one was found is N = {length}"),
                    None => write!(f, "none was found for any longer one up to {LONGEST_TRIED} either"),
                }?;
                f.write_str(
                    ". With controller.estimator = \"single\" the law for known ages runs all the same",
                )
            }
            Self::HeardLate { late_rate: Some(rate), .. } => write!(
                f,
                "network.sensor_to_controller: measurements come late or not at all, and for such no law was found: rate and cost \
                 are those of a loop that hears of all of them at once. Of one that hears of all or none, as late in the mean \
                 as over this link, second moments change by the factor {} per step; host-sim run shows the loop as it is",
                figure(*rate)
            ),
            Self::HeardLate { hears, late_rate: None } => write!(
                f,
                "network.sensor_to_controller: measurements come late or not at all. Without acknowledgements rate and cost \
                 are those of a loop that in each cycle hears of all of them with probability {}, and of none otherwise: as \
                 late in the mean as over this link, and not the same; host-sim run shows the loop as it is",
                figure(*hears)
            ),
            Self::NotScheduled(NotScheduled { period: Some(period) }) => write!(
                f,
                "event.base: with a packet in every {period}. cycle alone no gains were shown to stabilise the loop; give a smaller \
                 number, or \"auto\""
            ),
            Self::NotScheduled(NotScheduled { period: None }) => f.write_str(
                "event.base: no gains for packets at fixed times were shown to stabilise the loop",
            ),
            Self::Dependent { key, reason } => {
                write!(f, "{key}: packets on this link are not independent of each other: {reason}. ")?;
                f.write_str(
                    "Gains, rate and costs take the packets as independent; host-sim run shows the loop as it is",
                )
            }
            Self::OnChannel { rate } => write!(
                f,
                "network.controller_to_actuator: on the channel of this link the loop has the mean-square rate {} > 1 with \
                 these gains, which take its packets as independent; --method coupled shows what gains that know the \
                 channel do",
                figure(*rate)
            ),
            Self::LostInARow { growth } => write!(
                f,
                "network.sensor_to_controller: while measurements are lost in a row the squared error grows by {} > 1 per \
                 cycle, the chance of another loss counted in: no filter can follow the plant",
                figure(*growth)
            ),
            Self::Averaged { key, condition } => write!(
                f,
                "{key}: packets on this link are not independent of each other; if they were, this would fail: {condition}",
            ),
            Self::Limited { modulus, growth: Growth::Grows, .. } => write!(
                f,
                "controller.input_limits: |lambda_max(A)| = {} > 1: from some states no input within the limits leads \
                 back, and noise reaches one of them sooner or later. Gains, rate and costs are those of the loop \
                 before it gets to its limits; host-sim run counts how often it is lost",
                figure(*modulus)
            ),
            Self::Limited { reason, .. } => {
                f.write_str(
                    "controller.input_limits: |lambda_max(A)| = 1, on the limit of stability: under limits ",
                )?;
                f.write_str("nothing shows that the second moments of the state stay bounded")?;
                if let Some(reason) = reason {
                    write!(f, ", as {reason}")?;
                }
                f.write_str(
                    ". Gains, rate and costs are those of the loop before it gets to its limits; host-sim run counts how \
                     often it is lost",
                )
            }
        }
    }
}

impl Display for NotKnown {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Recorded => {
                f.write_str("a log is finite, and nothing is known of what follows it")
            }
            Self::Bus => f.write_str(
                "what the other traffic on the bus leaves them depends on its phases, and no chain of few states has them",
            ),
            Self::TooLarge => f.write_str(
                "the chain of the buffer's age and the channel's states is too large for its rate to be computed; shorten \
                 the sequences",
            ),
            Self::Unacknowledged => {
                f.write_str("the rate of the law without acknowledgements takes them as if they were")
            }
            Self::EventTrigger => f.write_str("the event trigger weighs them as if they were"),
            Self::Near { rate } => {
                write!(f, "on the channel the mean-square rate is {}, too close to 1 to be told from it", figure(*rate))
            }
            Self::Between { growth, rate } => {
                write!(f, "while measurements are lost in a row the squared error grows by {} < 1 per ", figure(*growth))?;
                f.write_str("cycle, which is needed for it to stay bounded, and no estimator was found that shows it to")?;
                match rate {
                    Some(rate) => write!(f, " (the best has the mean-square rate {})", figure(*rate)),
                    None => Ok(()),
                }
            }
        }
    }
}

pub(super) fn spelled(conditions: &[FailedCondition]) -> String {
    conditions.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n  ")
}
