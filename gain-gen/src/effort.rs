//! What solving a design takes, told before it is begun: memory and processor time, by its sizes.
//!
//! Memory is that of tables with `N (N nu)^2` numbers, of which there are about a dozen; time is that of the steps that fill
//! them, and of the estimator's figures. Both are fitted to measured runs and right within a factor of two for these;
//! `docs/accuracy.md` has the table, with a run that was not waited for.

use crate::design::Design;
use std::fmt::{self, Display, Formatter};

/// Bytes per number of a table, for all tables together.
const BYTES: f64 = 96.0;
/// Bytes of a solution of any size.
const LEAST_BYTES: f64 = 1e7;
/// Seconds for each number of a table and each pair of states.
const SECONDS: f64 = 2.5e-8;
/// Seconds for each delay of the link to the actuator, for each pair of inputs of a sequence and the third power of the states.
const SECONDS_OF_DELAYS: f64 = 2.6e-9;

/// Memory that is not taken unasked.
const MOST_BYTES: f64 = 2e9;
/// Processor time that is not taken unasked.
const MOST_SECONDS: f64 = 1800.0;
/// Memory that is worth a word.
const MUCH_MEMORY: f64 = 5e8;
/// Processor time that is worth a word.
const MUCH_TIME: f64 = 30.0;

/// What solving takes, estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Most memory at a time.
    pub bytes: f64,
    /// Processor time, of one core of a machine of these years.
    pub seconds: f64,
}

impl Effort {
    /// For sequences of these lengths, one after the other.
    pub fn of(design: &Design, lengths: &[usize]) -> Self {
        let (states, inputs) = (design.plant.states() as f64, design.plant.inputs() as f64);
        let numbers = |length: usize| (length as f64).powi(3) * inputs * inputs;
        let largest = lengths.iter().map(|&length| numbers(length)).fold(0.0, f64::max);
        let delays = design.network.controller_to_actuator.delays.probabilities().len() as f64;
        let of_delays =
            |length: usize| SECONDS_OF_DELAYS * states.powi(3) * (length * length) as f64 * delays;
        let seconds = |length: usize| SECONDS * states * states * numbers(length) + of_delays(length);
        let seconds = lengths.iter().map(|&length| seconds(length)).sum();
        Self { bytes: LEAST_BYTES + BYTES * largest, seconds }
    }

    /// Whether people want to know before they wait.
    pub fn is_much(&self) -> bool {
        self.bytes > MUCH_MEMORY || self.seconds > MUCH_TIME
    }

    /// Whether it is more than is taken unasked.
    pub fn is_too_much(&self) -> bool {
        self.bytes > MOST_BYTES || self.seconds > MOST_SECONDS
    }
}

impl Display for Effort {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (time, unit) = match self.seconds {
            seconds if seconds < 120.0 => (seconds, "s"),
            seconds if seconds < 7200.0 => (seconds / 60.0, "min"),
            seconds => (seconds / 3600.0, "h"),
        };
        write!(
            f,
            "about {:.1} GB of memory and {time:.0} {unit} of processor time, give or take a factor of three",
            self.bytes / 1e9
        )
    }
}
