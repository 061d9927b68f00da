//! A cost-to-go to begin with, from sequences of three quarters of the length, which begin likewise: a step for them takes less
//! than half of the work, and what the last quarter of the inputs adds is little.

use super::super::{Start, flat::Flat, iterate::Recursion};
use super::recursion;
use slqg::{DefaultInput, synthesis::Dimensions};

/// Inputs in flight for each state from which on it is worth while: where there are fewer, the states take most of a step.
const MANY: usize = 3;
/// Relative change of the cost-to-go down to which it is iterated: about what the longer sequences change of it.
const CLOSE: f64 = 1e-8;
/// Steps, at most. A loop that forgets more slowly gains nothing from a start that is close.
const MOST: usize = 40;

/// The cost-to-go of the start's problem, but for inputs beyond a shorter sequence, which it takes for zeros: as the core lays it
/// out. `None` where it is not worth while, or not found.
pub(super) fn from_shorter(start: &Start) -> Option<Vec<f64>> {
    let length = start.problem.length;
    let flat = Flat::new(&start.with_length((3 * length).div_ceil(4)).problem);
    let is_many = flat.dimensions.in_flight_rows() >= MANY * flat.dimensions.states;
    // A held input is not zero beyond the shorter sequence.
    if !is_many || flat.dimensions.length == length || start.problem.default_input == DefaultInput::Hold {
        return None;
    }
    let shorter = start.with_length(flat.dimensions.length);
    let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
    let mut recursion = recursion(&shorter, &flat, &mut workspace);
    if let Some(value) = from_shorter(&shorter) {
        recursion.synthesis.value_mut().copy_from_slice(&value);
    }
    (0..MOST).find(|_| recursion.step() <= CLOSE)?;
    Some(lengthened(recursion.synthesis.value(), &flat.dimensions, length))
}

/// A cost-to-go of these dimensions as one for sequences of `length` inputs, at least as many.
fn lengthened(value: &[f64], dimensions: &Dimensions, length: usize) -> Vec<f64> {
    let Dimensions { states, inputs, .. } = *dimensions;
    let longer = Dimensions { length, ..*dimensions };
    let (short, long) = (dimensions.in_flight_rows(), longer.in_flight_rows());
    let triangle = |size: usize| size * (size + 1) / 2;
    let mut result = Vec::with_capacity(longer.value_len());
    let (p, rest) = value.split_at(states * states);
    let (s, mut triangles) = rest.split_at(states * short);
    result.extend_from_slice(p);
    for state in 0..states {
        result.extend_from_slice(&s[state * short..][..short]);
        result.resize(result.len() + long - short, 0.0);
    }
    // The first rows of a triangle are a triangle. `Y` has all inputs in flight, `N_t` those from `t` on.
    for first in std::iter::once(0).chain((0..long).step_by(inputs)) {
        let (entries, later) = triangles.split_at(triangle(short.saturating_sub(first)).min(triangles.len()));
        triangles = later;
        result.extend_from_slice(entries);
        result.resize(result.len() + triangle(long - first) - entries.len(), 0.0);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Design;
    use crate::solve::{LoopProblem, Method, solve};

    const DOUBLE_INTEGRATOR: &str = include_str!("../../../../designs/double_integrator.toml");

    #[test]
    fn a_cost_to_go_begins_with_that_of_a_shorter_sequence() {
        let design = Design::parse(DOUBLE_INTEGRATOR, "double_integrator.toml").unwrap();
        let problem = LoopProblem::of(&design).with_length(16);
        let begun = from_shorter(&Start::of(&problem)).expect("worth while");
        let start = Start::of(&problem);
        let flat = Flat::new(&start.problem);
        assert_eq!(begun.len(), flat.dimensions.value_len());
        let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
        let mut synthesis = flat.synthesis(&mut workspace);
        synthesis.value_mut().copy_from_slice(&begun);
        // The first step changes the state's cost by no more than longer sequences do.
        let before = synthesis.cost_to_go().to_vec();
        synthesis.optimal_step();
        let change = synthesis.cost_to_go().iter().zip(&before).map(|(new, old)| (new - old).abs());
        let short = solve(&problem.with_length(12), Method::InFlight).cost_to_go;
        let long = solve(&problem, Method::InFlight).cost_to_go;
        let gained = (short - long).amax().max(1e-6);
        assert!(change.fold(0.0, f64::max) < gained);
    }

    #[test]
    fn every_part_of_a_cost_to_go_stays_where_it_is() {
        let dimensions = Dimensions { states: 1, inputs: 2, length: 2, default_input: DefaultInput::Zero };
        let value: Vec<f64> = (1..=dimensions.value_len()).map(|number| number as f64).collect();
        // P, S of 2, Y and N_0 of 3 each.
        assert_eq!(value.len(), 9);
        let longer = lengthened(&value, &dimensions, 3);
        let expected = [
            &[1.0, 2.0, 3.0, 0.0, 0.0][..],
            &[4.0, 5.0, 6.0],
            &[0.0; 7],
            &[7.0, 8.0, 9.0],
            &[0.0; 7],
            &[0.0; 3],
        ];
        assert_eq!(longer, expected.concat());
    }
}
