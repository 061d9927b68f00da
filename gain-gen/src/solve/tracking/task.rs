//! The feedforward of a task that ends, and what the reference adds to its cost.

use super::{Tracked, unit};
use crate::solve::{LoopProblem, flat::Flat};
use nalgebra::{DMatrix, DVector};
use slqg::synthesis::{LinearCost, Synthesis};

/// The feedforward of a task, and what the reference adds to its expected cost.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedTask {
    /// `Uff` of each cycle `k = 0..K-1`, `N nu` each.
    pub feedforward: Vec<DVector<f64>>,
    /// `sx_0`, `nx`: the start enters the cost by `- 2 sx_0^T E[x_0]`.
    pub state: DVector<f64>,
    /// `s_0`, thesis (4.13).
    pub constant: f64,
    /// What the task costs more if in each cycle the reference of that cycle is taken for all that is to come.
    pub surprise: f64,
}

/// The linear parts of a task's cost-to-go, backwards beside the recursion: for the reference as it is, and for one that
/// stands still, by tracked output.
pub(in crate::solve) struct TaskReference<'r> {
    tracked: &'r Tracked,
    r: &'r DMatrix<f64>,
    /// `z_k` for `k = 0..=K`.
    reference: &'r [DVector<f64>],
    workspaces: Vec<Vec<f64>>,
}

impl<'r> TaskReference<'r> {
    pub(in crate::solve) fn new(
        problem: &'r LoopProblem,
        tracked: &'r Tracked,
        reference: &'r [DVector<f64>],
    ) -> Self {
        let length = Flat::new(problem).dimensions.linear_workspace_len();
        Self { tracked, r: &problem.r, reference, workspaces: vec![vec![0.0; length]; 1 + tracked.outputs()] }
    }

    /// Runs `step`, which takes the recursion one cycle back, for every cycle from the last to the first.
    pub(in crate::solve) fn run<'s, 'p: 's, 'w: 's>(
        &mut self,
        synthesis: &mut Synthesis<'p, 'w, f64>,
        mut step: impl FnMut(&mut Synthesis<'p, 'w, f64>),
    ) -> TrackedTask {
        let Self { tracked, r, reference, workspaces } = self;
        let dimensions = synthesis.dimensions();
        let outputs = tracked.outputs();
        let last = reference.last().expect("a task has an end");
        let terminal = |z: &DVector<f64>| tracked.z.tr_mul(&(&tracked.terminal_weight * z));
        let mut costs: Vec<_> =
            workspaces.iter_mut().map(|workspace| LinearCost::new(&dimensions, workspace)).collect();
        let (known, still) = costs.split_first_mut().expect("one for the reference");
        known.restart(terminal(last).as_slice(), last.dot(&(&tracked.terminal_weight * last)));
        for (output, cost) in still.iter_mut().enumerate() {
            cost.restart(terminal(&unit(outputs, output)).as_slice(), 0.0);
        }
        let steps = reference.len() - 1;
        let mut feedforward = Vec::with_capacity(steps);
        let mut surprise = 0.0;
        for now in reference[..steps].iter().rev() {
            step(synthesis);
            known.step_back(synthesis, tracked.stage(r, now).borrow());
            let chosen = DVector::from_column_slice(known.feedforward());
            let mut unaware = -&chosen;
            for (output, cost) in still.iter_mut().enumerate() {
                cost.step_back(synthesis, tracked.stage(r, &unit(outputs, output)).borrow());
                unaware.axpy(now[output], &DVector::from_column_slice(cost.feedforward()), 1.0);
            }
            let rows = chosen.len();
            let quadratic = DMatrix::from_row_slice(rows, rows, synthesis.sequence_cost());
            surprise += unaware.dot(&(quadratic * &unaware));
            feedforward.push(chosen);
        }
        feedforward.reverse();
        let state = DVector::from_column_slice(known.state());
        TrackedTask { feedforward, state, constant: known.constant(), surprise }
    }
}
