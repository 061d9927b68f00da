//! The core's in-flight recursion iterated to its fixed point: THEORY 4 and 5 in `f64`.

use super::{
    LoopProblem, NetworkFree, Outcome, Solution, Start,
    evaluation::solve_like,
    flat::{Flat, synthesis},
    iterate::{Ending, Recursion, iterate},
    krylov::norm,
    law::Law,
    radius::radius,
    refined::{Refined, refined},
    spectral::{BEYOND, CLEARLY_UNSTABLE, NEAR_ONE, RESOLVENT, largest_real_near_one, settled_radius},
    sums::{StateLoop, Sums},
};
use crate::{extended::widened, stability};
use nalgebra::DMatrix;
use slqg::{
    DefaultInput,
    synthesis::{Dimensions, Problem, Synthesis},
};

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
}

/// Most steps that the search for the rate takes in one.
const LONGEST_STRIDE: usize = 16;

/// Error of the gains up to which they are good enough as `f64` has them.
const GOOD: f64 = 1e-10;
/// Accuracy of a correction to a cost-to-go of twice the precision.
const CORRECTION: f64 = 1e-6;
/// Part of `x^T x` in the direction from which the rate is looked for: every mode of the plant shows in it.
const SEED: f64 = 1e-3;
/// Plain applications before the rate is looked for: cheaper than a basis vector each, and what decays fast needs none.
const FILTER: usize = 8;
/// Cost of a state, in units in which it is 1 without a network, that calls for other units.
const OUT_OF_SCALE: f64 = 1e4;
/// Changes of units: they follow a cost-to-go that grows without bound no further.
const MOST_RESCALED: usize = 4;
/// Squarings after which a loop's power shows what lasts: 2^6 cycles.
const SQUARINGS: usize = 6;

impl InFlightRecursion<'_, '_> {
    /// How the cost-to-go has changed since it was remembered, scaled to length 1; `None` if it has not.
    fn moved(&self) -> Option<Vec<f64>> {
        let mut moved = self.synthesis.value().to_vec();
        let remembered = self.remembered.as_ref()?;
        moved.iter_mut().zip(remembered).for_each(|(now, before)| *now -= before);
        let length = norm(&moved);
        (length > 0.0 && length.is_finite()).then(|| moved.iter().map(|entry| entry / length).collect())
    }

    /// Calls `work` with the linear map of THEORY 5, the step with the present gains and without stage cost, acting on
    /// costs-to-go as the core lays them out: their independent numbers, and the symmetric `P` as a whole. The second
    /// argument gives about the cost-to-go whose step takes `stage` off it.
    fn with_map<R>(
        &mut self,
        work: impl FnOnce(&mut dyn FnMut(&[f64], &mut [f64]), &dyn Fn(&[f64]) -> Vec<f64>) -> R,
    ) -> R {
        let gains = self.synthesis.gains().to_vec();
        self.with_map_of(&gains, work)
    }

    /// The same with these gains, `[Lx M]` by rows.
    fn with_map_of<R>(
        &self,
        gains: &[f64],
        work: impl FnOnce(&mut dyn FnMut(&[f64], &mut [f64]), &dyn Fn(&[f64]) -> Vec<f64>) -> R,
    ) -> R {
        let Dimensions { states, inputs, .. } = self.problem.dimensions;
        let (no_q, no_r) = (vec![0.0; states * states], vec![0.0; inputs * inputs]);
        let mut workspace = vec![0.0; self.problem.dimensions.workspace_len()];
        let mut homogeneous = synthesis(Problem { q: &no_q, r: &no_r, ..self.problem }, &mut workspace);
        homogeneous.set_gains(gains);
        let mut map = |from: &[f64], to: &mut [f64]| {
            homogeneous.value_mut().copy_from_slice(from);
            homogeneous.fixed_step();
            to.copy_from_slice(homogeneous.value());
        };
        work(&mut map, &|stage| alike(&self.sums, states, stage))
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
        self.synthesis.optimal_step()
    }

    fn size(&self) -> f64 {
        let states = self.problem.dimensions.states;
        self.synthesis.cost_to_go().iter().step_by(states + 1).sum()
    }

    fn rate(&mut self) -> f64 {
        let Dimensions { states, length, default_input, .. } = self.problem.dimensions;
        if self.synthesis.gains().iter().all(|gain| *gain == 0.0) && default_input == DefaultInput::Zero {
            // Nothing is ever applied.
            return radius(&widened(&DMatrix::from_row_slice(states, states, self.problem.a))).powi(2);
        }
        let stride = (length / 4).clamp(1, LONGEST_STRIDE);
        // Inside the cone of costs, where the rate is an eigenvalue: near what grows most without a network, and near what
        // the recursion was slow to find.
        let mut start = vec![0.0; self.problem.dimensions.value_len()];
        start[..states * states].copy_from_slice(self.lasting.as_slice());
        if let Some(moved) = self.moved() {
            start.iter_mut().zip(moved).for_each(|(start, moved)| *start += moved);
        }
        let (found, settled) =
            self.with_map(|map, _| settled_radius(&start, FILTER, [1, stride, stride], map));
        if (settled && found < NEAR_ONE) || found > CLEARLY_UNSTABLE {
            return found;
        }
        // Many eigenvalues are about as large. The rate is the one that is real and nearest to a number beyond them all.
        let growth = if found < NEAR_ONE { BEYOND * found } else { 1.0 };
        let sums = self.free.as_ref().and_then(|free| free.discounted(growth));
        let nearest = largest_real_near_one(&start, |residual| {
            self.with_map(|map, _| {
                let alike = |stage: &[f64]| alike(&sums, states, stage);
                solve_like(residual, norm(residual), RESOLVENT, alike, |from, to| {
                    map(from, to);
                    to.iter_mut().for_each(|entry| *entry /= growth);
                })
            })
        });
        nearest.map_or(found, |nearest| growth * nearest)
    }

    fn settled_rate(&mut self) -> f64 {
        if self.is_timed { self.rate() } else { 0.0 }
    }

    fn memory(&self) -> usize {
        self.problem.dimensions.in_flight() + 1
    }

    fn evaluate(&mut self, accuracy: f64) -> bool {
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
}

/// About the cost-to-go whose step takes `stage` off it, by the costs of a loop that is alike.
fn alike(sums: &Option<Sums>, states: usize, stage: &[f64]) -> Vec<f64> {
    match sums {
        Some(sums) => sums.of_value(states, stage),
        None => stage.to_vec(),
    }
}

/// `x^T x` some cycles later without a network, scaled, and a little of what it is now.
fn lasting(problem: &LoopProblem, free: Option<&NetworkFree>) -> DMatrix<f64> {
    let one = DMatrix::identity(problem.a.nrows(), problem.a.nrows());
    let Some(free) = free else { return one };
    let mut power = &problem.a + &problem.b * &free.gain;
    for _ in 0..SQUARINGS {
        power = &power * &power;
        let size = power.amax();
        if size == 0.0 || !size.is_finite() {
            return one;
        }
        power /= size;
    }
    let later = power.tr_mul(&power);
    &later / later.amax() + one * SEED
}

/// Mean-square rate of any law, made with the link's own arrival probabilities, for the problem, whose cost-to-go is about `cost`,
/// `nx x nx`. THEORY 5.
pub(super) fn rate_of(problem: &LoopProblem, law: &Law, cost: &DMatrix<f64>) -> f64 {
    let start = Start::of(problem).measured_by_given(cost);
    let law = start.coordinates.express_law(law);
    let flat = Flat::new(&start.problem);
    let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
    let mut recursion = recursion(&start, &flat, &mut workspace);
    recursion.synthesis.set_gains(&law.by_rows());
    recursion.rate()
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
        decays: stability::open_loop_modulus(&problem.a) < 1.0
            && (problem.default_input == DefaultInput::Zero || !stability::runs_dry(problem)),
        may_rescale: false,
        is_timed: true,
    };
    let begun = start.begun.as_ref().unwrap_or(start.cost_to_go());
    recursion.synthesis.restart(begun.as_slice());
    recursion
}

/// Whether the recursion converges: the cost is bounded, and so is every state that shows in it.
pub(super) fn converges(start: &Start) -> bool {
    in_scale(start, false, |_, _, _, ending| ending.outcome == Outcome::Converged)
}

/// The start at its fixed point, in the design's units.
pub(super) fn solve(start: &Start) -> Solution {
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

/// How the iteration ends.
fn ending(start: &Start, recursion: &mut InFlightRecursion<'_, '_>) -> Ending {
    match start.free.as_ref().filter(|_| start.problem.is_network_free()) {
        // Already there: the step says how well the solution fits its equation.
        Some(free) => Ending {
            outcome: Outcome::Converged,
            iterations: 1,
            policy_iterations: 0,
            residual: recursion.step(),
            mean_square_rate: free.radius.powi(2),
            gain_error: free.error,
        },
        None => iterate(recursion, start.cost_scale(), stability::runs_dry(&start.problem)),
    }
}

/// What the recursion has come to, in the start's coordinates.
fn solution(
    start: &Start,
    flat: &Flat,
    recursion: &mut InFlightRecursion<'_, '_>,
    ending: &Ending,
) -> Solution {
    let problem = &start.problem;
    let free = start.free.as_ref().filter(|_| problem.is_network_free());
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
    if let Some(free) = free {
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
        law,
        cost_to_go,
    }
}
