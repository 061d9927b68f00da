//! How large the inputs are that a loop applies: their variances in steady state, as costs that weigh nothing else.

use super::{LoopProblem, Solution, Start, flat::Flat, in_flight::recursion, iterate::Recursion};
use nalgebra::DMatrix;

/// Accuracy of a variance, relative to itself.
const ACCURACY: f64 = 1e-10;

/// What the square of each input costs as the actuator applies it, for the gains of `solution`: `P_i`, `nx x nx`, for each of the
/// `nu` inputs, the cost-to-go for `Q = 0` and `R = e_i e_i'`. With the state known and noise of covariance `W` the long-run mean
/// square is `tr(P_i W)`. THEORY 5. `None` unless the loop is stable and the costs are found.
pub fn applied_costs(problem: &LoopProblem, solution: &Solution) -> Option<Vec<DMatrix<f64>>> {
    if !solution.is_stabilising() {
        return None;
    }
    let start = solution.start.measured_by_given(&solution.cost_to_go);
    let law = start.coordinates.express_law(&solution.law);
    let (states, inputs) = problem.b.shape();
    let gains = law.by_rows();
    let of_input = |input: usize| {
        let unit = |i, j| if (i, j) == (input, input) { 1.0 } else { 0.0 };
        let weighed = LoopProblem {
            q: DMatrix::zeros(states, states),
            r: DMatrix::from_fn(inputs, inputs, unit),
            ..problem.clone()
        };
        let start = Start {
            coordinates: start.coordinates.clone(),
            problem: start.coordinates.express(&weighed),
            free: start.free.clone(),
            begun: None,
            open_loop_modulus: start.open_loop_modulus,
        };
        let flat = Flat::new(&start.problem);
        let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
        let mut recursion = recursion(&start, &flat, &mut workspace);
        recursion.synthesis.restart(&vec![0.0; states * states]);
        recursion.synthesis.set_gains(&gains);
        recursion.evaluate(ACCURACY).then(|| {
            let cost = DMatrix::from_row_slice(states, states, recursion.synthesis.cost_to_go());
            start.coordinates.cost(&cost)
        })
    };
    (0..inputs).map(of_input).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::{DelayDistribution, Design};
    use crate::solve::{Method, solve};
    use slqg::DefaultInput;

    #[test]
    fn over_a_perfect_link_the_mean_square_is_that_of_the_state_under_its_gain() {
        let problem = LoopProblem {
            a: DMatrix::from_element(1, 1, 1.2),
            b: DMatrix::from_element(1, 1, 0.5),
            q: DMatrix::from_element(1, 1, 1.0),
            r: DMatrix::from_element(1, 1, 2.0),
            link: DelayDistribution::new(vec![1.0]).expect("a distribution"),
            length: 1,
            default_input: DefaultInput::Zero,
        };
        let solution = solve(&problem, Method::InFlight);
        let noise = DMatrix::from_element(1, 1, 0.09);
        let (gain, closed) = (solution.law.lx[0], 1.2 + 0.5 * solution.law.lx[0]);
        let expected = gain * gain * 0.09 / (1.0 - closed * closed);
        let found =
            [applied_costs(&problem, &solution).expect("a stable loop")[0].component_mul(&noise).sum()];
        assert!((found[0] - expected).abs() < 1e-9 * expected, "{} {expected}", found[0]);
    }

    #[test]
    fn what_inputs_cost_is_a_part_of_the_cost() {
        let text = include_str!("../../../designs/pendulum.toml");
        let design = Design::parse(text, "pendulum.toml").expect("a design");
        let problem = LoopProblem::of(&design);
        let solution = solve(&problem, Method::InFlight);
        let noise = &design.plant.process_noise;
        let inputs = applied_costs(&problem, &solution).expect("a stable loop")[0].component_mul(noise).sum();
        let cost = solution.control_cost(noise);
        assert!(inputs > 0.0 && inputs * problem.r[(0, 0)] < cost, "{inputs} {cost}");
    }
}
