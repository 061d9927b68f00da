//! How a length that a design leaves open was chosen; by what, [`crate::lengths`] says.

use crate::figure::figure;
use slqg::DefaultInput;

/// How a length that the design leaves open was chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LengthChoice {
    /// By what part more than the limit the chosen length may cost; above 0, below 1.
    pub tolerance: f64,
    /// The default input it was chosen for.
    pub default_input: DefaultInput,
    /// The length chosen, `N`.
    pub length: usize,
    /// What the limit is that the length was compared with.
    pub limit: LongSequences,
}

/// The cost of long sequences, per step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LongSequences {
    /// Sequences of half of `length` inputs cost the same up to a tenth of the tolerance.
    Settled {
        /// Inputs per sequence.
        length: usize,
        /// `tr(P W)`.
        cost: f64,
    },
    /// Not shown to have settled: that of the longest sequences there are.
    Capped {
        /// Inputs per sequence: 128.
        length: usize,
        /// `tr(P W)`.
        cost: f64,
    },
    /// No length stabilises the loop. What is chosen holds the longest delay, if a sequence can.
    NoneStabilises,
}

/// `chosen: within 1 % of the cost of long sequences`.
impl core::fmt::Display for LengthChoice {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let tolerance = figure(100.0 * self.tolerance);
        match self.limit {
            LongSequences::Settled { .. } => {
                write!(f, "chosen: within {tolerance} % of the cost of long sequences")
            }
            LongSequences::Capped { length, .. } => {
                write!(f, "chosen: within {tolerance} % of the cost of N = {length}, the longest allowed; ")?;
                f.write_str("longer ones might cost less")
            }
            LongSequences::NoneStabilises => f.write_str("chosen: no length stabilises"),
        }
    }
}
