//! What became of a bit that flipped.

use crate::closed_loop::Run;

/// What became of it, the mildest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Every input is the same, to the bit.
    Masked,
    /// The node has told that it is lost, and done what it does then.
    Detected,
    /// Inputs differ, and are again what they would have been.
    Degraded,
    /// The program has failed or says nothing more: the watchdog resets the board.
    Stopped,
    /// The rod has fallen, and nobody was told.
    Lost,
    /// Inputs are wrong for good, and nobody was told.
    Silent,
}

pub(crate) const ALL: [(Outcome, &str); 6] = [
    (Outcome::Masked, "masked"),
    (Outcome::Detected, "detected"),
    (Outcome::Degraded, "degraded"),
    (Outcome::Stopped, "stopped"),
    (Outcome::Lost, "lost"),
    (Outcome::Silent, "silent"),
];

/// Cycles at the end of a run in which inputs must be as they would have been.
const END: usize = 50;
/// By how much of their root mean square they may differ.
const TOLERANCE: f64 = 1e-3;

impl Outcome {
    /// Of a run, beside the one without a fault.
    pub(crate) fn of(run: &Run, undisturbed: &Run, is_told: bool) -> Self {
        let is_same =
            run.inputs.iter().zip(&undisturbed.inputs).all(|(one, other)| one.to_bits() == other.to_bits());
        if run.has_stopped {
            Self::Stopped
        } else if is_told || run.other_is_lost {
            Self::Detected
        } else if run.has_fallen {
            Self::Lost
        } else if is_same {
            Self::Masked
        } else if is_as_before(&run.inputs, &undisturbed.inputs) {
            Self::Degraded
        } else {
            Self::Silent
        }
    }
}

fn is_as_before(inputs: &[f32], undisturbed: &[f32]) -> bool {
    let count = undisturbed.len() as f64;
    let square = undisturbed.iter().map(|input| f64::from(*input).powi(2)).sum::<f64>() / count;
    let last = inputs.iter().zip(undisturbed).skip(inputs.len().saturating_sub(END));
    let most = last.map(|(one, other)| (f64::from(*one) - f64::from(*other)).abs()).fold(0.0, f64::max);
    most <= TOLERANCE * square.sqrt()
}
