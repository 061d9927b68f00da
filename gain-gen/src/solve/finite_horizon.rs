//! Time-varying gains for a task that ends after a known number of cycles: THEORY 4 without waiting for convergence.
//!
//! They exist whether or not the loop can be stabilised for ever.

use super::{
    LoopProblem,
    flat::Flat,
    law::Law,
    tracking::{TaskReference, Tracked, TrackedTask},
};
use nalgebra::{DMatrix, DVector};
use slqg::synthesis::Synthesis;

/// The optimal laws of a task of `K` cycles.
#[derive(Debug, Clone)]
pub struct FiniteHorizon {
    /// The law of each cycle `k = 0..K-1`.
    pub laws: Vec<Law>,
    /// `P_k` for `k = 0..=K`, the last one being the terminal weight; `nx x nx` each.
    pub cost_to_go: Vec<DMatrix<f64>>,
    /// What the reference adds; `None` if none is followed.
    pub tracked: Option<TrackedTask>,
}

impl FiniteHorizon {
    /// Expected cost of the task with the state known, from a state with this mean and covariance and nothing in flight:
    /// thesis (3.33), and Theorem 4.1 d) where a reference is followed, without the estimation error.
    pub fn control_cost(
        &self,
        initial_mean: &DVector<f64>,
        initial_covariance: &DMatrix<f64>,
        process_noise: &DMatrix<f64>,
    ) -> f64 {
        let first = &self.cost_to_go[0];
        let start = initial_mean.dot(&(first * initial_mean)) + first.component_mul(initial_covariance).sum();
        let noise = self.cost_to_go[1..].iter().map(|cost| cost.component_mul(process_noise).sum());
        let tracked = self.tracked.as_ref();
        let reference = tracked.map_or(0.0, |task| task.constant - 2.0 * task.state.dot(initial_mean));
        start + noise.sum::<f64>() + reference
    }
}

/// The optimal laws of `steps` cycles with the terminal cost `x_K^T Q_K x_K`; `terminal` is `Q_K`, `nx x nx`.
pub fn finite_horizon(problem: &LoopProblem, terminal: &DMatrix<f64>, steps: usize) -> FiniteHorizon {
    let mut laws = Backwards::new(problem, terminal, steps);
    let flat = Flat::new(problem);
    let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
    let mut synthesis = flat.synthesis(&mut workspace);
    synthesis.restart(terminal.as_slice());
    for _ in 0..steps {
        laws.step(&mut synthesis);
    }
    laws.finish(None)
}

/// The optimal laws and feedforwards of a task whose output follows `reference`, `z_k` for `k = 0..=K`.
pub fn tracking_task(problem: &LoopProblem, tracked: &Tracked, reference: &[DVector<f64>]) -> FiniteHorizon {
    let terminal = tracked.z.tr_mul(&(&tracked.terminal_weight * &tracked.z));
    let mut laws = Backwards::new(problem, &terminal, reference.len() - 1);
    let flat = Flat::new(problem);
    let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
    let mut synthesis = flat.synthesis(&mut workspace);
    synthesis.restart(terminal.as_slice());
    let task =
        TaskReference::new(problem, tracked, reference).run(&mut synthesis, |synthesis| laws.step(synthesis));
    laws.finish(Some(task))
}

/// Laws and costs-to-go, from the last to the first.
struct Backwards<'p> {
    problem: &'p LoopProblem,
    arrival: Vec<f64>,
    laws: Vec<Law>,
    cost_to_go: Vec<DMatrix<f64>>,
}

impl<'p> Backwards<'p> {
    fn new(problem: &'p LoopProblem, terminal: &DMatrix<f64>, steps: usize) -> Self {
        let mut cost_to_go = Vec::with_capacity(steps + 1);
        cost_to_go.push(terminal.clone());
        Self { problem, arrival: problem.arrival_table(), laws: Vec::with_capacity(steps), cost_to_go }
    }

    fn step(&mut self, synthesis: &mut Synthesis<'_, '_, f64>) {
        let states = self.problem.a.nrows();
        synthesis.optimal_step();
        self.laws.push(Law::from_gains(self.problem, synthesis.gains(), self.arrival.clone()));
        self.cost_to_go.push(DMatrix::from_row_slice(states, states, synthesis.cost_to_go()));
    }

    fn finish(mut self, tracked: Option<TrackedTask>) -> FiniteHorizon {
        self.laws.reverse();
        self.cost_to_go.reverse();
        FiniteHorizon { laws: self.laws, cost_to_go: self.cost_to_go, tracked }
    }
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
