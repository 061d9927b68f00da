//! Which condition for stability fails or is open, with its figures, and the error that says so.
//!
//! Which of them do is decided in `judged`, how each is told is in `sentence`.

mod judged;
mod sentence;

use super::Verdict;
use crate::saturation::NotShown;
use crate::solve::NotScheduled;
use crate::stability::Growth;
use slqg::DefaultInput;

pub(crate) use judged::failed;

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
    /// Without acknowledgements no law was found that keeps second moments bounded.
    NoLinearLaw {
        /// The shortest length for which one was.
        shortest: Option<usize>,
    },
    /// Without acknowledgements: measurements come late or not at all, and not as the rate takes it.
    HeardLate {
        /// Probability that the newest measurement, and all before, are taken to be known.
        hears: f64,
        /// Factor by which second moments change if they come as late in the mean as over the link, where no law was found for that.
        late_rate: Option<f64>,
    },
    /// No law with a packet in every p-th cycle was shown to stabilise the loop.
    NotScheduled(NotScheduled),
    /// Packets on a link are not independent, and what that does to the loop is not known.
    Dependent {
        /// The link's key in the design file.
        key: &'static str,
        /// Why it is not.
        reason: NotKnown,
    },
    /// On the channel of the link to the actuator the loop is unstable with its gains, which are made for the average link.
    OnChannel {
        /// Mean-square rate on the channel, above 1.
        rate: f64,
    },
    /// Measurements are lost in a row for so long that no filter can follow the plant.
    LostInARow {
        /// Growth of the squared error meanwhile, per cycle, above 1.
        growth: f64,
    },
    /// A condition that fails for independent packets, and the link's are not.
    Averaged {
        /// The link's key in the design file.
        key: &'static str,
        /// What fails.
        condition: Box<FailedCondition>,
    },
    /// Inputs have limits and the plant does not come back by itself: nothing proves that the loop is stable.
    Limited {
        /// Largest modulus of the eigenvalues of `A`, per step.
        modulus: f64,
        /// [`Growth::OnTheLimit`] or [`Growth::Grows`].
        growth: Growth,
        /// Why the plant on the limit is not shown to stay bounded.
        reason: Option<NotShown>,
    },
}

/// Why it is not known what packets that are not independent do to the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NotKnown {
    /// The link is what a log recorded.
    Recorded,
    /// The link goes over a bus.
    Bus,
    /// The chain of age and channel is too large for its rate to be computed.
    TooLarge,
    /// The law for a loop without acknowledgements takes them as independent.
    Unacknowledged,
    /// An event trigger weighs packets as if they were independent.
    EventTrigger,
    /// The rate on the channel is 1 within rounding.
    Near {
        /// That rate.
        rate: f64,
    },
    /// Losses in a row are short enough, and no estimator was found that shows the error to stay bounded.
    Between {
        /// Growth of the squared error while measurements are lost in a row, per cycle.
        growth: f64,
        /// Mean-square rate of the best estimator found.
        rate: Option<f64>,
    },
}

impl FailedCondition {
    /// Whether it is not known to fail, only not shown to hold.
    pub const fn is_open(&self) -> bool {
        match self {
            Self::Undecided { .. }
            | Self::ErrorOpen { .. }
            | Self::Unacknowledged { .. }
            | Self::NoLinearLaw { .. }
            | Self::HeardLate { .. }
            | Self::NotScheduled(_)
            | Self::Dependent { .. }
            | Self::Averaged { .. }
            | Self::Limited { .. } => true,
            Self::RunsDry { .. }
            | Self::NoFixedPoint { .. }
            | Self::LosesSight { .. }
            | Self::ErrorGrows { .. }
            | Self::OnChannel { .. }
            | Self::LostInARow { .. }
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
                | Self::NoLinearLaw { .. }
                | Self::HeardLate { .. }
                | Self::NotScheduled(_)
                | Self::Dependent { .. }
                | Self::OnChannel { .. }
                | Self::Limited { .. }
        )
    }

    /// Whether no gains came out, so that there is no loop to be written.
    pub(super) fn leaves_no_gains(&self) -> bool {
        match self {
            Self::RunsDry { .. }
            | Self::NoFixedPoint { .. }
            | Self::NoLinearLaw { .. }
            | Self::NotScheduled(_) => true,
            Self::Averaged { condition, .. } => condition.leaves_no_gains(),
            _ => false,
        }
    }
}

/// A loop that is not shown to be stable.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "{name:?} with N = {length} and default input {} {}: {}",
    default_input.name(),
    match verdict {
        Verdict::Undecided => "is not shown to be stable",
        _ if conditions.iter().any(|condition| matches!(condition, FailedCondition::OnChannel { .. })) => "is not stable",
        _ => "cannot be stabilised",
    },
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
