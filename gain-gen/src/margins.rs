//! How much worse link and plant may be than the design says before the loop is unstable.
//!
//! The controller stays as designed: its gains and its table of arrival probabilities. The state is known. Each margin
//! changes one thing and asks for the mean-square rate of what results, over all ages of the actuator's buffer, since
//! with a table that is not the link's the in-flight form does not apply. Dense, so slow for long sequences.
//!
//! A margin is the distance to the *nearest* change that destabilises. The search walks outwards in steps and then
//! narrows the step in which the rate passes 1; an unstable interval narrower than a step could be walked over.

use crate::design::DelayDistribution;
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
/// Width to which the place where the rate passes 1 is narrowed.
const WIDTH: f64 = 1e-9;
/// Narrowing steps at most; halving alone needs 30.
const NARROWINGS: usize = 60;

/// Distances to instability, one change at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
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
pub fn margins(problem: &LoopProblem, solution: &Solution) -> Option<Margins> {
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
    Some(Margins {
        extra_loss: nominal.extra_loss(&designed, rate),
        extra_delay,
        rate_beyond_extra_delay,
        input_gain_min: boundary(1.0, rate, |at| (at - GAIN_STEP).max(0.0), 0.0, with_gain),
        input_gain_max: boundary(
            1.0,
            rate,
            |at| (at * GAIN_FACTOR).min(LARGEST_INPUT_GAIN),
            LARGEST_INPUT_GAIN,
            with_gain,
        ),
    })
}

/// The link on which every packet comes `steps` later than on `link`.
pub fn delayed(link: &DelayDistribution, steps: usize) -> DelayDistribution {
    let mut probabilities = vec![0.0; steps];
    probabilities.extend_from_slice(link.probabilities());
    DelayDistribution::new(probabilities).expect("a distribution that starts later is a distribution")
}

/// The link on which, of the packets that arrive on `link`, a `fraction` below 1 is lost in addition.
///
/// # Panics
/// If the fraction is not within 0 and 1, or nothing is left.
pub fn thinned(link: &DelayDistribution, fraction: f64) -> DelayDistribution {
    let probabilities =
        link.probabilities().iter().map(|probability| probability * (1.0 - fraction)).collect();
    DelayDistribution::new(probabilities).expect("something still arrives")
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
        boundary(0.0, rate, |at| (at + LOSS_STEP).min(1.0), 1.0, with_loss)
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

/// The last point, walking from `start` with `next` to `end`, up to which the rate is below 1; `end` itself if it stays
/// there. The rate at the point returned is below 1.
fn boundary(
    start: f64,
    rate: f64,
    next: impl Fn(f64) -> f64,
    end: f64,
    mut rate_at: impl FnMut(f64) -> f64,
) -> f64 {
    let (mut inside, mut inside_rate) = (start, rate);
    while inside != end {
        let outside = next(inside);
        let outside_rate = rate_at(outside);
        if outside_rate >= 1.0 {
            return narrowed((inside, inside_rate - 1.0), (outside, outside_rate - 1.0), rate_at);
        }
        (inside, inside_rate) = (outside, outside_rate);
    }
    end
}

/// Where the rate passes 1 between a stable and an unstable point, each with its rate less 1: from the stable side.
///
/// Secants, with the weight of an end that stays halved (the Illinois rule), so that both ends close in.
fn narrowed(mut inside: (f64, f64), mut outside: (f64, f64), mut rate_at: impl FnMut(f64) -> f64) -> f64 {
    let mut last_was_inside = None;
    for _ in 0..NARROWINGS {
        if (outside.0 - inside.0).abs() <= WIDTH * inside.0.abs().max(1.0) {
            break;
        }
        let middle = (inside.0 * outside.1 - outside.0 * inside.1) / (outside.1 - inside.1);
        let excess = rate_at(middle) - 1.0;
        let is_inside = excess < 0.0;
        if is_inside {
            inside = (middle, excess);
        } else {
            outside = (middle, excess);
        }
        if last_was_inside == Some(is_inside) {
            let stayed = if is_inside { &mut outside } else { &mut inside };
            stayed.1 *= 0.5;
        }
        last_was_inside = Some(is_inside);
    }
    inside.0
}
