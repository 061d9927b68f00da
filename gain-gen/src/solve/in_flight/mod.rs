//! The core's in-flight recursion iterated to its fixed point: THEORY 4 and 5 in `f64`.
//!
//! | file | what lives there |
//! |---|---|
//! | `solution` | from a start to what the recursion comes to |
//! | `shorter` | a cost-to-go to begin with, from shorter sequences |
//! | `rate` | the mean-square rate of a law |

mod rate;
mod shorter;
mod solution;

use super::{
    Start,
    acceleration::Acceleration,
    evaluation::solve_like,
    flat::{Flat, synthesis},
    iterate::Recursion,
    krylov::norm,
    refined::{Refined, refined},
    sums::{StateLoop, Sums},
};
use nalgebra::DMatrix;
use rate::{alike, lasting};
use slqg::{
    DefaultInput,
    synthesis::{Dimensions, Problem, Synthesis},
};

pub(super) use rate::rate_of;
pub(super) use solution::{converges, solve};

pub(super) struct InFlightRecursion<'p, 'w> {
    pub(super) synthesis: Synthesis<'p, 'w, f64>,
    problem: Problem<'p, f64>,
    /// The loop without a network.
    free: Option<StateLoop>,
    /// Its costs, which a slow plant's differ little from.
    sums: Option<Sums>,
    /// Whether the plant decays when left alone, or sent zeros.
    decays: bool,
    /// Whether other units may be asked for.
    may_rescale: bool,
    /// Whether it matters how fast a loop that is stable forgets.
    is_timed: bool,
    /// Cost of the state, `nx x nx`, in which what the loop without a network forgets last stands out.
    lasting: DMatrix<f64>,
    /// The cost-to-go at some step before.
    remembered: Option<Vec<f64>>,
    /// A cost-to-go of length 1 that is forgotten last, or nearly so.
    slowest: Option<Vec<f64>>,
    /// The last steps, while they are combined.
    acceleration: Option<Acceleration>,
    /// Whether the cost-to-go comes from combined steps or from another problem: it may be where costs are not.
    may_be_astray: bool,
}

/// Accuracy of a correction to a cost-to-go of twice the precision.
const CORRECTION: f64 = 1e-6;
/// Cost of a state, in units in which it is 1 without a network, that calls for other units.
const OUT_OF_SCALE: f64 = 1e4;

/// Times that a sequence could pass in the plain steps which a combination of steps is to spare.
const MEMORIES: usize = 2;

/// A linear map of costs-to-go in place.
type Map<'m> = dyn FnMut(&mut [f64]) + 'm;

impl InFlightRecursion<'_, '_> {
    /// Calls `work` with the linear map of THEORY 5, the step with the present gains and without stage cost, acting on
    /// costs-to-go as the core lays them out: their independent numbers, and the symmetric `P` as a whole. The second
    /// argument makes of what a step takes off a cost-to-go about this cost-to-go.
    fn with_map<R>(&mut self, work: impl FnOnce(&mut Map<'_>, &dyn Fn(&mut [f64])) -> R) -> R {
        let gains = self.synthesis.gains().to_vec();
        self.with_map_of(&gains, work)
    }

    /// The same with these gains, `[Lx M]` by rows.
    fn with_map_of<R>(&self, gains: &[f64], work: impl FnOnce(&mut Map<'_>, &dyn Fn(&mut [f64])) -> R) -> R {
        let Dimensions { states, inputs, .. } = self.problem.dimensions;
        let (no_q, no_r) = (vec![0.0; states * states], vec![0.0; inputs * inputs]);
        let mut workspace = vec![0.0; self.problem.dimensions.workspace_len()];
        let mut homogeneous = synthesis(Problem { q: &no_q, r: &no_r, ..self.problem }, &mut workspace);
        homogeneous.set_gains(gains);
        work(&mut |value| homogeneous.fixed_step_of(value), &|value| alike(&self.sums, states, value))
    }

    /// Begins with the start's cost-to-go.
    fn begin(&mut self, start: &Start) {
        let begun = start.begun.as_ref().unwrap_or(start.cost_to_go());
        self.synthesis.restart(begun.as_slice());
        (self.remembered, self.slowest) = (None, None);
    }

    /// The fixed point near the present cost-to-go in twice the precision.
    fn refined(&self, flat: &Flat) -> Option<Refined> {
        refined(flat, self.synthesis.value(), |gains, residual| {
            self.with_map_of(gains, |map, alike| solve_like(residual, norm(residual), CORRECTION, alike, map))
        })
    }
}

impl Recursion for InFlightRecursion<'_, '_> {
    fn step(&mut self) -> f64 {
        let Some(acceleration) = &mut self.acceleration else { return self.synthesis.optimal_step() };
        self.may_be_astray |= acceleration.is_under_way();
        acceleration.improve(self.synthesis.value_mut());
        let residual = self.synthesis.optimal_step();
        acceleration.take(self.synthesis.value(), residual);
        residual
    }

    fn size(&self) -> f64 {
        let states = self.problem.dimensions.states;
        self.synthesis.cost_to_go().iter().step_by(states + 1).sum()
    }

    fn rate(&mut self) -> f64 {
        self.find_rate()
    }

    fn settled_rate(&mut self) -> f64 {
        if self.is_timed || self.may_be_astray { self.rate() } else { 0.0 }
    }

    fn memory(&self) -> usize {
        self.problem.dimensions.in_flight() + 1
    }

    fn evaluate(&mut self, accuracy: f64) -> bool {
        self.acceleration.iter_mut().for_each(Acceleration::clear);
        // One step with the gains held tells how far the cost-to-go is from being theirs.
        let before = self.synthesis.value().to_vec();
        self.synthesis.fixed_step();
        let after = self.synthesis.value().to_vec();
        let residual: Vec<f64> = after.iter().zip(&before).map(|(after, before)| after - before).collect();
        let correction =
            self.with_map(|map, alike| solve_like(&residual, norm(&after), accuracy, alike, map));
        let found = correction.is_some();
        let value = before.iter().zip(correction.unwrap_or(residual)).map(|(value, change)| value + change);
        let value: Vec<f64> = value.collect();
        self.synthesis.value_mut().copy_from_slice(&value);
        found
    }

    fn remember(&mut self) {
        self.remembered = Some(self.synthesis.value().to_vec());
    }

    fn is_out_of_scale(&self) -> bool {
        let states = self.problem.dimensions.states;
        let costs = self.synthesis.cost_to_go().iter().step_by(states + 1);
        self.may_rescale && costs.fold(0.0, |largest: f64, cost| largest.max(*cost)) > OUT_OF_SCALE
    }

    /// A plant that decays is stabilised by sending zeros.
    fn fall_back(&mut self) -> bool {
        if self.decays {
            let dimensions = self.problem.dimensions;
            self.synthesis.set_gains(&vec![0.0; dimensions.sequence_rows() * dimensions.gain_columns()]);
        }
        self.decays
    }

    fn gains(&mut self) -> Vec<f64> {
        self.synthesis.gains().to_vec()
    }

    fn walk(&mut self) {
        self.acceleration = None;
    }
}

/// The recursion from the start on.
pub(super) fn recursion<'p, 'w>(
    start: &Start,
    flat: &'p Flat,
    workspace: &'w mut [f64],
) -> InFlightRecursion<'p, 'w> {
    let problem = &start.problem;
    let free = start.free.as_ref().map(|free| {
        let closed = &problem.a + &problem.b * &free.gain;
        StateLoop::new(closed, free.radius)
    });
    let mut recursion = InFlightRecursion {
        synthesis: flat.synthesis(workspace),
        problem: flat.problem(),
        sums: free.as_ref().and_then(StateLoop::sums),
        free,
        lasting: lasting(problem, start.free.as_ref()),
        remembered: None,
        slowest: None,
        acceleration: None,
        may_be_astray: false,
        decays: start.open_loop_modulus < 1.0
            && (problem.default_input == DefaultInput::Zero || !start.runs_dry()),
        may_rescale: false,
        is_timed: true,
    };
    recursion.begin(start);
    let Dimensions { states, .. } = flat.dimensions;
    let in_flight = flat.dimensions.in_flight_rows();
    let counted = states * (states + in_flight) + in_flight * (in_flight + 1) / 2;
    // After a combination, inputs that are hardly ever applied take as many steps as there are until their gains stand still.
    let worth = (MEMORIES * recursion.memory()) as f64;
    recursion.acceleration = Some(Acceleration::new(counted, worth));
    recursion
}
