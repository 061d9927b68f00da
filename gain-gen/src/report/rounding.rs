//! What it costs that values are counted in steps: the errors of rounding, and those of inputs in units of the cost.

use super::Report;
use crate::solve::Outcome;

/// Standard deviation of an error that is anywhere within half a step with equal probability: `step/sqrt(12)`.
pub(super) fn deviation(step: f64) -> f64 {
    step / 12_f64.sqrt()
}

impl Report {
    /// What the rounding of inputs adds to the long-run cost per step, `sum_i (R + B'PB)_ii step_i^2/12`: an estimate. `None`
    /// where they are not rounded, or the recursion did not converge.
    ///
    /// An error `e` of the applied input costs `e'Re` in its own cycle; then it has moved the state by `Be`, just as process
    /// noise would, which costs `e'B'PBe` in all cycles to come. Errors of rounding are taken to be independent of each other
    /// and of the state, as they nearly are while inputs move by many steps.
    pub fn rounding_cost(&self) -> Option<f64> {
        let inputs = self.design.steps()?.inputs;
        if self.solution.outcome != Outcome::Converged || self.scheduled.is_some() {
            return None;
        }
        let b = &self.design.plant.b;
        let weight = &self.design.cost.r + b.transpose() * &self.solution.cost_to_go * b;
        let of_input = |(weight, &step): (&f64, &f64)| weight * deviation(step).powi(2);
        Some(weight.diagonal().iter().zip(&inputs.steps).map(of_input).sum())
    }
}
