//! Estimation of the plant's state, and of what the actuator played, from what comes late, out of order or not at all.
//!
//! [`ModeFilter`] is one estimator for the whole range of acknowledgements. Where every age is acknowledged in time it is
//! the Kalman filter; where none is, an interacting-multiple-model filter over the ages. What the plant is like is in
//! [`Model`]; what its states mean, only the design knows.
//!
//! | file | what lives there |
//! |---|---|
//! | `model` | the plant's constants |
//! | `factored` | a covariance that rounding cannot make indefinite |
//! | `prepared` | what is computed of the model once; when an estimate is of no use any more, and what it begins anew with |
//! | `plausibility` | when a measurement is not believed, and when it is the estimate that is not |
//! | `estimate` | one Gaussian estimate: prediction, update, merging |
//! | `memory` | what is remembered of each cycle, in memory that is lent |
//! | `surroundings` | the loop around: how ages move from cycle to cycle, and which inputs they mean |
//! | `step` | one cycle of the filter: hypotheses apart, measured, merged |
//! | `mode_filter` | the memory: what is late is put where it belongs, and filtered again; in `filtered` what it has come to |

mod estimate;
mod factored;
mod memory;
mod mode_filter;
mod model;
mod plausibility;
mod prepared;
mod step;
mod surroundings;

pub use estimate::Estimate;
pub use memory::{Cycle, Remembered, estimates_len};
pub use mode_filter::{ModeFilter, RejectedMeasurement};
pub use model::{MOST_STATES, Model};
pub use plausibility::{Plausibility, Standing};
pub use surroundings::Surroundings;

/// Which hypotheses about the ages an estimator keeps apart while no acknowledgement decides between them. THEORY 8.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Merging {
    /// None: one Kalman filter, told the mean and the covariance of what may have been applied.
    #[default]
    Single,
    /// The age in the last cycle: interacting multiple models.
    Imm,
    /// The ages in the last two cycles, merged after the measurement: generalised pseudo-Bayesian of second order.
    Gpb2,
    /// None, and no ages either: no acknowledgement ever comes. One Kalman filter, told the mean of what may have been applied;
    /// the model's process noise contains its covariance, which no data change. THEORY 14. A feature of that name: without it a
    /// design with it makes no controller, and the others are smaller.
    Linear,
}

impl Merging {
    /// Whether it is [`Merging::Linear`], and this program can do with it.
    pub(crate) const fn is_linear(self) -> bool {
        cfg!(feature = "linear") && matches!(self, Self::Linear)
    }

    /// Estimates that are kept at once for sequences of `length` inputs.
    pub const fn estimates(self, length: usize) -> usize {
        match self {
            Self::Single | Self::Linear => 1,
            Self::Imm | Self::Gpb2 => length + 1,
        }
    }

    /// As in design files and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Imm => "imm",
            Self::Gpb2 => "gpb2",
            Self::Linear => "linear",
        }
    }
}
