//! Why a format does not take a design.

use slqg::{blob::EncodeError, estimator::MOST_STATES};

/// Why a format does not take a design.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EmitError {
    /// A number is beyond what the device's scalar can hold.
    #[error("{table}: found {value:e}, which {scalar} cannot hold; {advice}")]
    OutOfRange {
        /// The table with the number.
        table: &'static str,
        /// The number.
        value: f64,
        /// The scalar's name.
        scalar: &'static str,
        /// What to do.
        advice: &'static str,
    },
    /// No device runs a controller with so many states.
    #[error(
        "plant: found {states} states; {format} is for devices, whose controller takes up to {MOST_STATES}: reduce the model, \
         or write json, or c for the law alone"
    )]
    TooManyStates {
        /// States found.
        states: usize,
        /// The format asked for.
        format: &'static str,
    },
    /// The law is beyond what a blob can hold.
    #[error("blob: {0}")]
    Blob(EncodeError),
    /// Time-varying gains have no such format.
    #[error("--horizon: time-varying gains are written as rust or json, not as {format}")]
    TimeVarying {
        /// The format asked for.
        format: &'static str,
    },
    /// The device would follow no reference, or send in every cycle, and nobody would be told.
    #[error("{key}: {format} carries the law alone: {missing} would be missing; write rust or json")]
    LawAlone {
        /// The part of the design.
        key: &'static str,
        /// The format asked for.
        format: &'static str,
        /// What it would leave out.
        missing: &'static str,
    },
    /// C needs a header by that name.
    #[error("--output: found {path:?} for C; {advice}")]
    HeaderName {
        /// The file named.
        path: String,
        /// What to do.
        advice: String,
    },
}
