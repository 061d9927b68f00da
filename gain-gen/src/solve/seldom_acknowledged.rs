//! Gains where acknowledgements come late or are lost: between those that know every age and those that know none. THEORY 14.
//!
//! With an age that is known the gains of the recursion are the optimum; with none, those of the Riccati equation in `vbar` nearly
//! are. Between the two, what is optimal depends on all that was sent. A mixture of the two laws comes close to the best mixture
//! for each probability, on both networks of the evaluation and for every length.

use super::{
    LoopProblem, Solution,
    in_flight::rate_of,
    unacknowledged::{law_for_none, share_known},
};
use crate::design::{Acknowledgement, Design};
use slqg::estimator::Merging;

/// Power of the probability that an age is not known which is the weight of the law that knows none: by trial. With 1 the loops with
/// few and large inputs get too cautious, with 2 those with many unknown ages too bold.
const POWER: f64 = 1.5;
/// Inputs in a sequence, at most: longer ones take minutes, and what their last inputs are worth is close to nothing.
const LONGEST: usize = 24;
/// Weight below which the mixture is not worth its name.
const NOTHING: f64 = 1e-6;

impl Solution {
    /// The solution with the law for the design's acknowledgements. Its cost-to-go stays that of the optimum with instant ones.
    ///
    /// It is the same where all come in time, where the estimator is the linear one ([`super::unacknowledged`] has its law), where
    /// the design has what needs the law for known ages ([`Design::check_uncertain`]), for more than 24 inputs, and where the mixture does not stabilise.
    pub fn for_acknowledgements(self, design: &Design, problem: &LoopProblem) -> Self {
        let weight = weight(design);
        let is_long = problem.length > LONGEST;
        let needs_none = is_long || weight <= NOTHING || design.estimator() == Merging::Linear;
        if needs_none || design.check_uncertain().is_err() || !self.is_stabilising() {
            return self;
        }
        let Some(unknown) = law_for_none(design, problem, &self) else { return self };
        let mut law = self.law.clone();
        law.lx = &law.lx * (1.0 - weight) + unknown.lx * weight;
        law.m = &law.m * (1.0 - weight) + unknown.m * weight;
        let rate = rate_of(&self.start, &law, &self.cost_to_go, self.slowest.as_ref());
        if rate >= 1.0 {
            return self;
        }
        Self { law, mean_square_rate: rate, unknown_weight: weight, coupled_gains: None, ..self }
    }
}

/// Weight of the law that knows no age.
fn weight(design: &Design) -> f64 {
    let known = match &design.network.acknowledgement {
        Acknowledgement::Instant => 1.0,
        Acknowledgement::None => 0.0,
        Acknowledgement::Over(link) => share_known(&link.delays, design.controller.measurement_buffer),
    };
    (1.0 - known).max(0.0).powf(POWER)
}
