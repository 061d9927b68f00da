//! Margins of the loop whose state is known: the law by itself.
//!
//! Each changes one thing and asks for the mean-square rate of what results. For another link that is over all ages of the
//! actuator's buffer, since with a table that is not the link's the in-flight form does not apply: dense, so slow for long
//! sequences.

use super::change::Change;
use super::delayed;
use super::loop_rate::LoopAsRun;
use super::search::{WIDTH, boundary};
use crate::design::Design;
use crate::solve::{
    ClosedLoop, LoopProblem, Mode, ModeChain, Solution, age_transitions, modes, rough_radius,
};
use crate::stability::open_loop_modulus;
use crate::units::Units;
use nalgebra::DMatrix;
use slqg::DefaultInput;

/// Steps in which loss is searched.
const LOSS_STEP: f64 = 1.0 / 8.0;
/// Factor between the input gains tried above 1.
const GAIN_FACTOR: f64 = 1.25;
/// Steps in which input gains below 1 are searched.
const GAIN_STEP: f64 = 1.0 / 8.0;
/// Largest input gain tried.
pub const LARGEST_INPUT_GAIN: f64 = 100.0;

/// States up to which all second moments are gone through at once.
const MOST_STATES: usize = 16;

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

/// The margins of the design's loop with the gains of `solution`; `None` if it is not mean-square stable as it is.
pub fn state_known(design: &Design, solution: &Solution) -> Option<StateKnown> {
    let units = Units::of(&design.plant);
    let (plant, law) = (units.plant(&design.plant), units.law(&solution.law));
    let problem = &LoopProblem { a: plant.a.clone(), b: plant.b.clone(), ..LoopProblem::of(design) };
    let gains = law.mode_gains();
    let nominal = Loop { problem, modes: modes(problem), gains: &gains };
    let designed = age_transitions(&problem.link, problem.length);
    let rate = nominal.rate(&designed);
    if rate.is_nan() || rate >= 1.0 {
        return None;
    }
    let (extra_delay, rate_beyond_extra_delay) = nominal.extra_delay().unzip();
    let around = LoopAsRun::state_known(&plant, &law, &problem.survival());
    let with_gain = |factor: f64| around.rate(Change::InputGain, factor);
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

    /// Whether an input is applied in the cycle it is sent for or never, so that nothing is under way; and few states, for
    /// all second moments to be in one matrix.
    fn has_no_memory(&self) -> bool {
        let is_short = self.problem.length == 1 && self.problem.default_input == DefaultInput::Zero;
        is_short && self.problem.a.nrows() <= MOST_STATES
    }

    /// The rate where packets arrive with probability `arrives`: that of `X -> q F' X F + (1 - q) A' X A` on symmetric `X`, with
    /// `F = A + B L`. Eigenvalues that crowd at the unit circle do not matter to it.
    fn rate_without_memory(&self, arrives: f64) -> f64 {
        let a = &self.problem.a;
        let closed = a + &self.problem.b * self.gains[0].columns(0, a.nrows());
        let moments = moments_map(&closed) * arrives + moments_map(a) * (1.0 - arrives);
        rough_radius(&moments)
    }

    /// Where nothing arrives in time: that of the plant left alone. An input that is held stays.
    fn silent_rate(&self) -> f64 {
        let alone = open_loop_modulus(&self.problem.a).powi(2);
        match self.problem.default_input {
            DefaultInput::Zero => alone,
            DefaultInput::Hold => alone.max(1.0),
        }
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
        let arrives = self.problem.link.arrival(0);
        let with_loss = |fraction: f64| match fraction {
            1.0 => self.silent_rate(),
            _ if self.has_no_memory() => self.rate_without_memory(arrives * (1.0 - fraction)),
            _ => self.rate(&(designed * (1.0 - fraction) + &silent * fraction)),
        };
        boundary(0.0, rate, |at| (at + LOSS_STEP).min(1.0), 1.0, WIDTH, with_loss)
    }

    /// Steps, and the rate with one more; `None` if any delay may come.
    fn extra_delay(&self) -> Option<(usize, f64)> {
        let length = self.problem.length;
        // From N steps on nothing arrives in time, and still later changes nothing.
        (0..length).find_map(|steps| {
            let link = delayed(&self.problem.link, steps + 1);
            let rate = match link.arrival(length - 1) {
                0.0 => self.silent_rate(),
                _ => self.rate(&age_transitions(&link, length)),
            };
            (rate >= 1.0).then_some((steps, rate))
        })
    }
}

/// `X -> F' X F` for symmetric `X`, over its upper triangle.
fn moments_map(f: &DMatrix<f64>) -> DMatrix<f64> {
    let size = f.nrows();
    let places: Vec<(usize, usize)> = (0..size).flat_map(|j| (0..=j).map(move |i| (i, j))).collect();
    DMatrix::from_fn(places.len(), places.len(), |row, column| {
        let ((i, j), (k, l)) = (places[row], places[column]);
        let once = f[(k, i)] * f[(l, j)];
        if k == l { once } else { once + f[(l, i)] * f[(k, j)] }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::{Method, solve};

    #[test]
    fn without_memory_the_rate_is_that_over_all_ages() {
        let text = include_str!("../../../designs/double_integrator.toml");
        let mut design = Design::parse(text, "double_integrator.toml").expect("a design");
        design.set_sequence_length(1);
        let problem = LoopProblem::of(&design);
        let gains = solve(&problem, Method::InFlight).mode_gains().into_owned();
        let around = Loop { problem: &problem, modes: modes(&problem), gains: &gains };
        assert!(around.has_no_memory());
        let dense = around.rate(&age_transitions(&problem.link, 1));
        let found = around.rate_without_memory(problem.link.arrival(0));
        assert!((found - dense).abs() < 1e-9, "{found} {dense}");
    }
}
