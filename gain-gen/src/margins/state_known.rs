//! Margins of the loop whose state is known: the law by itself.
//!
//! Each changes one thing and asks for the mean-square rate of what results, over all ages of the actuator's buffer, since
//! with a table that is not the link's the in-flight form does not apply. Dense, so slow for long sequences.

use super::delayed;
use super::search::{WIDTH, boundary};
use crate::solve::{
    ClosedLoop, LoopProblem, Mode, ModeChain, Solution, age_transitions, mean_square_rate, modes,
};
use nalgebra::DMatrix;

/// Steps in which loss is searched.
const LOSS_STEP: f64 = 1.0 / 8.0;
/// Factor between the input gains tried above 1.
const GAIN_FACTOR: f64 = 1.25;
/// Steps in which input gains below 1 are searched.
const GAIN_STEP: f64 = 1.0 / 8.0;
/// Largest input gain tried.
pub const LARGEST_INPUT_GAIN: f64 = 100.0;

/// Distances to instability with the state known, one change at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StateKnown {
    /// Fraction of the packets that would arrive which may be lost in addition; 1 if all may.
    pub extra_loss: f64,
    /// Steps by which every packet may come later than designed; `None` if it does not matter whether any comes.
    pub extra_delay: Option<usize>,
    /// Mean-square rate with one step of delay more; `None` if any delay may come.
    pub rate_beyond_extra_delay: Option<f64>,
    /// Factor on `B` above which the loop is stable; 0 if it needs no input.
    pub input_gain_min: f64,
    /// Factor on `B` below which the loop is stable; [`LARGEST_INPUT_GAIN`] if none up to that destabilises.
    pub input_gain_max: f64,
}

/// The margins of the problem's loop with the gains of `solution`; `None` if it is not mean-square stable as it is.
pub fn state_known(problem: &LoopProblem, solution: &Solution) -> Option<StateKnown> {
    let gains = solution.mode_gains();
    let nominal = Loop { problem, modes: modes(problem), gains: &gains };
    let designed = age_transitions(&problem.link, problem.length);
    let rate = nominal.rate(&designed);
    if rate.is_nan() || rate >= 1.0 {
        return None;
    }
    let (extra_delay, rate_beyond_extra_delay) = nominal.extra_delay().unzip();
    let with_gain =
        |factor: f64| mean_square_rate(&LoopProblem { b: &problem.b * factor, ..problem.clone() }, &gains);
    Some(StateKnown {
        extra_loss: nominal.extra_loss(&designed, rate),
        extra_delay,
        rate_beyond_extra_delay,
        input_gain_min: boundary(1.0, rate, |at| (at - GAIN_STEP).max(0.0), 0.0, WIDTH, with_gain),
        input_gain_max: boundary(
            1.0,
            rate,
            |at| (at * GAIN_FACTOR).min(LARGEST_INPUT_GAIN),
            LARGEST_INPUT_GAIN,
            WIDTH,
            with_gain,
        ),
    })
}

/// The plant with its gains, for links that differ.
struct Loop<'a> {
    problem: &'a LoopProblem,
    modes: Vec<Mode>,
    gains: &'a [DMatrix<f64>],
}

impl Loop<'_> {
    fn rate(&self, transitions: &DMatrix<f64>) -> f64 {
        let chain = ModeChain::of_ages(transitions.clone());
        ClosedLoop { modes: &self.modes, chain: &chain, gains: self.gains }.rate()
    }

    /// Transitions of the age are linear in the arrival probabilities: between the designed ones and those of a link
    /// on which nothing arrives.
    fn extra_loss(&self, designed: &DMatrix<f64>, rate: f64) -> f64 {
        let length = self.problem.length;
        let silent =
            DMatrix::from_fn(
                length + 1,
                length + 1,
                |from, to| {
                    if to == (from + 1).min(length) { 1.0 } else { 0.0 }
                },
            );
        let with_loss = |fraction: f64| self.rate(&(designed * (1.0 - fraction) + &silent * fraction));
        boundary(0.0, rate, |at| (at + LOSS_STEP).min(1.0), 1.0, WIDTH, with_loss)
    }

    /// Steps, and the rate with one more; `None` if any delay may come.
    fn extra_delay(&self) -> Option<(usize, f64)> {
        let length = self.problem.length;
        // From N steps on nothing arrives in time, and still later changes nothing.
        (0..length).find_map(|steps| {
            let rate = self.rate(&age_transitions(&delayed(&self.problem.link, steps + 1), length));
            (rate >= 1.0).then_some((steps, rate))
        })
    }
}
