//! From the recursion's start to what it comes to.

use super::super::{
    LoopProblem, Outcome, Solution, Start,
    flat::Flat,
    iterate::{Ending, Recursion, iterate},
    law::Law,
    network_free::NetworkFree,
};
use super::{InFlightRecursion, recursion, shorter::from_shorter};
use nalgebra::DMatrix;

/// Error of the gains up to which they are good enough as `f64` has them.
const GOOD: f64 = 1e-10;
/// Changes of units: they follow a cost-to-go that grows without bound no further.
const MOST_RESCALED: usize = 4;

/// Whether the recursion converges: the cost is bounded, and so is every state that shows in it.
pub(in super::super) fn converges(start: &Start) -> bool {
    in_scale(start, false, |_, _, _, ending| ending.outcome == Outcome::Converged)
}

/// The start at its fixed point, in the design's units.
pub(in super::super) fn solve(start: &Start) -> Solution {
    in_scale(start, true, |start, flat, recursion, ending| {
        start.coordinates.restore(solution(start, flat, recursion, &ending), &flat.dimensions)
    })
}

/// Iterates, in other units where the network makes the cost much larger than it is without one, and hands over how it ended.
fn in_scale<R>(
    start: &Start,
    is_timed: bool,
    work: impl FnOnce(&Start, &Flat, &mut InFlightRecursion<'_, '_>, Ending) -> R,
) -> R {
    let mut rescaled: Option<Start> = None;
    let mut iterations = 0;
    for count in 0.. {
        let start = rescaled.as_ref().unwrap_or(start);
        let flat = Flat::new(&start.problem);
        let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
        let mut recursion = recursion(start, &flat, &mut workspace);
        recursion.is_timed = is_timed;
        if !is_timed {
            // Whether it converges is for plain steps to show.
            recursion.acceleration = None;
        }
        recursion.may_rescale = count < MOST_RESCALED;
        let mut ending = ending(start, &mut recursion);
        iterations += ending.iterations;
        if ending.outcome != Outcome::Undecided || !recursion.is_out_of_scale() {
            ending.iterations = iterations;
            return work(start, &flat, &mut recursion, ending);
        }
        let states = flat.dimensions.states;
        let cost = DMatrix::from_row_slice(states, states, recursion.synthesis.cost_to_go());
        rescaled = Some(start.measured_by(&cost));
    }
    unreachable!("the last attempt asks for no other units")
}

/// The solution without a network, where the problem has none.
fn exact(start: &Start) -> Option<&NetworkFree> {
    start.free.as_ref().filter(|_| start.problem.is_network_free())
}

/// How the iteration ends.
fn ending(start: &Start, recursion: &mut InFlightRecursion<'_, '_>) -> Ending {
    if let Some(free) = exact(start) {
        // Already there: the step says how well the solution fits its equation.
        let radius = if recursion.is_timed { free.exact_radius() } else { free.radius };
        return Ending {
            outcome: Outcome::Converged,
            iterations: 1,
            policy_iterations: 0,
            residual: recursion.step(),
            mean_square_rate: radius.powi(2),
            gain_error: free.error,
        };
    }
    if let Some(value) = recursion.is_timed.then(|| from_shorter(start)).flatten() {
        recursion.synthesis.value_mut().copy_from_slice(&value);
        recursion.may_be_astray = true;
    }
    let ending = iterate(recursion, start.cost_scale(), start.runs_dry());
    if ending.outcome == Outcome::Converged || !recursion.may_be_astray {
        return ending;
    }
    // What came from elsewhere may have led away from where costs are. Plain steps from the start do not.
    recursion.begin(start);
    (recursion.acceleration, recursion.may_be_astray) = (None, false);
    iterate(recursion, start.cost_scale(), start.runs_dry())
}

/// What the recursion has come to, in the start's coordinates.
fn solution(
    start: &Start,
    flat: &Flat,
    recursion: &mut InFlightRecursion<'_, '_>,
    ending: &Ending,
) -> Solution {
    let problem: &LoopProblem = &start.problem;
    let refined = if ending.outcome == Outcome::Converged && ending.gain_error > GOOD {
        recursion.refined(flat).filter(|refined| refined.error < ending.gain_error)
    } else {
        None
    };

    let (states, inputs) = (flat.dimensions.states, flat.dimensions.inputs);
    let mut law = Law::from_gains(problem, recursion.synthesis.gains(), problem.arrival_table());
    let mut cost_to_go = DMatrix::from_row_slice(states, states, recursion.synthesis.cost_to_go());
    let mut value = recursion.synthesis.value().to_vec();
    let mut gain_error = ending.gain_error;
    if let Some(refined) = refined {
        law = Law::from_gains(problem, &refined.gains, problem.arrival_table());
        cost_to_go = DMatrix::from_row_slice(states, states, &refined.value[..states * states]);
        (value, gain_error) = (refined.value, refined.error);
    }
    if let Some(free) = exact(start) {
        // To the last digit, which a step in `f64` need not keep. Nothing else is ever applied.
        law.lx.fill(0.0);
        law.m.fill(0.0);
        law.lx.rows_mut(0, inputs).copy_from(&free.gain);
        value.fill(0.0);
        value[..states * states].copy_from_slice(free.cost_to_go.as_slice());
        cost_to_go = free.cost_to_go.clone();
    }
    Solution {
        outcome: ending.outcome,
        iterations: ending.iterations,
        policy_iterations: ending.policy_iterations,
        residual: ending.residual,
        mean_square_rate: ending.mean_square_rate,
        gain_error,
        coupled_gains: None,
        value: Some(value),
        slowest: recursion.slowest.take(),
        start: start.clone(),
        law,
        cost_to_go,
        unknown_weight: 0.0,
    }
}
