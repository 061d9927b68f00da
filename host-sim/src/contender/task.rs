//! The controller of a task that ends with the run: one law, and one feedforward, for each cycle.

use super::{Contender, ContenderError};
use gain_gen::{
    design::Design,
    solve::{LoopProblem, Tracked, finite_horizon, tracking_task},
};

impl Contender {
    /// Gives it the optimal laws of a task of `steps` cycles. They exist whether or not the loop can be stabilised.
    pub(super) fn make_task(
        &mut self,
        problem: &LoopProblem,
        design: &Design,
        steps: usize,
    ) -> Result<(), ContenderError> {
        self.learn_reference(design, steps)?;
        let task = match Tracked::of(design) {
            Some(tracked) => tracking_task(problem, &tracked, &self.reference),
            None => finite_horizon(problem, &design.cost.terminal, steps),
        };
        self.laws = task.laws;
        self.feedforward = task.tracked.map(|tracked| tracked.feedforward).unwrap_or_default();
        Ok(())
    }
}
