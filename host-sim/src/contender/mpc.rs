//! Sequence-based model predictive control: plan as if the network were not there, send the whole plan. Thesis (2.4), (2.5).
//!
//! The plan begins when its sequence is expected to be there. Until then the plant gets what is expected of the sequences
//! in flight, and that is what the sequence repeats for those cycles. Without input limits the plan is linear in the
//! estimate and in `vbar`: tables. With limits it is a quadratic program in every cycle, solved in [`crate::decision`].

use super::{Contender, ContenderError, nominal::Prediction, steady::without_network};
use gain_gen::{
    design::{DelayDistribution, Design},
    solve::{Law, LoopProblem, Method, finite_horizon, solve},
};
use nalgebra::DMatrix;

/// Planned cycles for each input of a sequence.
const HORIZON: usize = 4;
/// Fewest planned cycles.
const SHORTEST_HORIZON: usize = 20;

/// The problem that is solved in every cycle where inputs are limited.
///
/// `min sum_{t=d}^{d+H-1} (x_t' Q x_t + u_t' R u_t) + x_{d+H}' P x_{d+H}`, with `u_t` within the limits, `x_d` predicted
/// from the estimate with the inputs expected in flight.
#[derive(Debug, Clone)]
pub struct Constrained {
    /// Plant, weights `Q` and `R`, link and sequences.
    pub problem: LoopProblem,
    /// `P`, `nx x nx`: what LQG without limits costs from the end of the plan on.
    pub terminal: DMatrix<f64>,
    /// (least, greatest), one pair per input, in the input's unit.
    pub limits: Vec<(f64, f64)>,
    /// `H`, in cycles.
    pub horizon: usize,
    /// `d`: cycles until the sequence is expected to be there.
    pub delay: usize,
}

/// Cycles until a sequence of `length` inputs is expected to be there: by then half of the packets have arrived. At most
/// `length - 1`, for later there is nothing left of it.
fn expected_delay(link: &DelayDistribution, length: usize) -> usize {
    (0..length - 1).find(|&delay| link.arrival(delay) >= 0.5).unwrap_or(length - 1)
}

/// The law that sends `gain` times what is expected in flight, without a state.
fn of_expected(problem: &LoopProblem, gain: f64) -> Law {
    let rows = problem.length * problem.b.ncols();
    let expected = problem.default_input.in_flight(problem.length) * problem.b.ncols();
    Law {
        length: problem.length,
        default_input: problem.default_input,
        lx: DMatrix::zeros(rows, problem.a.nrows()),
        m: DMatrix::identity(rows, expected) * gain,
        arrival: problem.arrival_table(),
    }
}

impl Contender {
    /// Gives it its plan, as tables or as a problem.
    pub(super) fn plan_ahead(
        &mut self,
        problem: &LoopProblem,
        design: &Design,
    ) -> Result<(), ContenderError> {
        self.must_see(design)?;
        let alone = without_network(problem);
        let lqg = solve(&alone, Method::InFlight);
        if !lqg.is_stabilising() {
            return Err(self.unstable());
        }
        let horizon = (HORIZON * problem.length).max(SHORTEST_HORIZON);
        let delay = expected_delay(&problem.link, problem.length);
        let Some(limits) = &design.controller.input_limits else {
            let plan = finite_horizon(&alone, &lqg.cost_to_go, horizon);
            self.laws = vec![unconstrained(problem, &plan.laws, delay)];
            return Ok(());
        };
        self.laws = vec![of_expected(problem, 0.0)];
        self.constrained = Some(Constrained {
            problem: problem.clone(),
            terminal: lqg.cost_to_go,
            limits: limits.clone(),
            horizon,
            delay,
        });
        Ok(())
    }
}

/// The plan whose cycles have the feedback `plan`, after `delay` cycles of what is in flight.
fn unconstrained(problem: &LoopProblem, plan: &[Law], delay: usize) -> Law {
    let prediction = Prediction {
        problem,
        feedback: |ahead: usize| plan[ahead.saturating_sub(delay)].lx.clone(),
        own_part: |ahead| if ahead < delay { 0.0 } else { 1.0 },
        preview: None,
        most_samples: 0,
    };
    let (mut law, _) = prediction.law();
    let repeated = delay * law.inputs();
    law.lx.rows_mut(0, repeated).fill(0.0);
    law.m.rows_mut(0, repeated).copy_from(&of_expected(problem, 1.0).m.rows(0, repeated));
    law
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sequence_is_expected_when_half_of_the_packets_have_arrived() {
        let delay = |probabilities: &[f64], length| {
            expected_delay(&DelayDistribution::new(probabilities.to_vec()).unwrap(), length)
        };
        assert_eq!(delay(&[0.7, 0.3], 4), 0);
        assert_eq!(delay(&[0.2, 0.2, 0.2, 0.2], 4), 2);
        assert_eq!(delay(&[0.2, 0.2, 0.2, 0.2], 2), 1, "never later than there is an input for");
        assert_eq!(delay(&[0.2, 0.2], 4), 3);
        assert_eq!(delay(&[0.2, 0.2], 1), 0);
    }
}
