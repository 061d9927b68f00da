//! Time-varying gains for a task that ends after a known number of cycles: THEORY 4 without waiting for convergence.
//!
//! They exist whether or not the loop can be stabilised for ever.

use super::{LoopProblem, in_flight::Flat, law::Law};
use nalgebra::{DMatrix, DVector};

/// The optimal laws of a task of `K` cycles.
#[derive(Debug, Clone)]
pub struct FiniteHorizon {
    /// The law of each cycle `k = 0..K-1`.
    pub laws: Vec<Law>,
    /// `P_k` for `k = 0..=K`, the last one being the terminal weight; `nx x nx` each.
    pub cost_to_go: Vec<DMatrix<f64>>,
}

impl FiniteHorizon {
    /// Expected cost of the task with the state known, from a state with this mean and covariance and nothing in flight:
    /// thesis (3.33) without the estimation error.
    pub fn control_cost(
        &self,
        initial_mean: &DVector<f64>,
        initial_covariance: &DMatrix<f64>,
        process_noise: &DMatrix<f64>,
    ) -> f64 {
        let first = &self.cost_to_go[0];
        let start = initial_mean.dot(&(first * initial_mean)) + first.component_mul(initial_covariance).sum();
        let noise = self.cost_to_go[1..].iter().map(|cost| cost.component_mul(process_noise).sum());
        start + noise.sum::<f64>()
    }
}

/// The optimal laws of `steps` cycles with the terminal cost `x_K^T Q_K x_K`; `terminal` is `Q_K`, `nx x nx`.
pub fn finite_horizon(problem: &LoopProblem, terminal: &DMatrix<f64>, steps: usize) -> FiniteHorizon {
    let flat = Flat::new(problem);
    let states = problem.a.nrows();
    let arrival = problem.arrival_table();
    let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
    let mut synthesis = flat.synthesis(&mut workspace);
    synthesis.restart(terminal.as_slice());
    let mut laws = Vec::with_capacity(steps);
    let mut cost_to_go = vec![terminal.clone()];
    for _ in 0..steps {
        synthesis.optimal_step();
        laws.push(Law::from_gains(problem, synthesis.gains(), arrival.clone()));
        cost_to_go.push(DMatrix::from_row_slice(states, states, synthesis.cost_to_go()));
    }
    laws.reverse();
    cost_to_go.reverse();
    FiniteHorizon { laws, cost_to_go }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        design::Design,
        solve::{Method, solve},
    };

    fn pendulum() -> Design {
        Design::parse(include_str!("../../../designs/pendulum.toml"), "pendulum.toml").expect("a design")
    }

    #[test]
    fn a_long_task_begins_with_the_steady_state_law() {
        let problem = LoopProblem::of(&pendulum());
        let task = finite_horizon(&problem, &problem.q, 1500);
        let steady = solve(&problem, Method::InFlight).law;
        assert!((&task.laws[0].lx - &steady.lx).amax() < 1e-9 * steady.lx.amax());
        assert!((&task.laws[0].m - &steady.m).amax() < 1e-9 * steady.m.amax());
    }

    #[test]
    fn the_last_cycle_without_terminal_cost_does_nothing() {
        let problem = LoopProblem::of(&pendulum());
        let task = finite_horizon(&problem, &DMatrix::zeros(4, 4), 3);
        assert_eq!(task.laws[2].lx.amax(), 0.0, "an input costs, and nothing is left to gain");
        assert!(task.laws[0].lx.amax() > 0.0);
        assert_eq!(task.cost_to_go[2], problem.q);
    }

    #[test]
    fn a_task_has_laws_where_no_loop_could_be_stabilised() {
        let text = include_str!("../../../designs/critical.toml");
        let design = Design::parse(text, "critical.toml").expect("a design");
        let problem = LoopProblem::of(&design).with_length(1);
        let task = finite_horizon(&problem, &problem.q, 20);
        let plant = &design.plant;
        let cost = task.control_cost(&plant.initial_mean, &plant.initial_covariance, &plant.process_noise);
        assert!(cost.is_finite() && cost > 0.0);
    }
}
