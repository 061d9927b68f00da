//! What sending is worth by the thesis' own matrices: (5.8)-(5.12), (5.14), (5.15) with their misprints mended.
//!
//! One cost matrix for each age and for each history of decisions, `2^(N-1)` of them, with `n = nx + nu N (N-1) / 2` rows.
//! It is what [`slqg::event`] is checked against, and shares nothing with it but the rank-revealing solve.

use super::{
    LoopProblem, Start,
    coupled::{CoupledRecursion, settle},
    iterate::Recursion,
};
use nalgebra::{DMatrix, DVector};

/// An event-triggered loop in steady state whose later packets go out in every p-th cycle; in every one as the thesis has it.
pub struct Rollout {
    /// The problem, in the coordinates in which it is solved.
    start: Start,
    /// Cost-to-go once every packet that may be under way was sent as the schedule has it, by cycles to the next packet and by
    /// age; for p = 1 `Kbar(i)` of Corollary 5.1. In these coordinates.
    scheduled: Vec<Vec<DMatrix<f64>>>,
}

/// What is known when it is decided.
#[derive(Debug, Clone)]
pub struct Situation {
    /// Estimate of the state, `nx`.
    pub state: DVector<f64>,
    /// `rho`, thesis (3.26), and with hold the input applied last. What stands for packets never sent does not count.
    pub sent: DVector<f64>,
    /// Whether the packet of age `a = 1..N-1` was sent.
    pub was_sent: Vec<bool>,
    /// Age acknowledged for the cycle before; `N` for an empty buffer.
    pub age: usize,
}

impl Rollout {
    /// Solves the coupled recursion; `None` unless it converges.
    pub fn new(problem: &LoopProblem) -> Option<Self> {
        let start = Start::of(problem);
        let (recursion, ending) = settle(&start);
        let converged = ending.outcome == super::Outcome::Converged;
        converged.then_some(Self { start, scheduled: vec![recursion.cost_to_go] })
    }

    /// The same where later packets go out in every `period`-th cycle.
    pub fn over_schedule(problem: &LoopProblem, period: usize) -> Option<Self> {
        let start = Start::of(problem);
        let (scheduled, _) = settle_schedule(&start.problem, period, 1e-15)?;
        Some(Self { start, scheduled })
    }

    /// `C(not send) - C(send)` without the cost of the packet, given that every later one is sent: thesis Lemma 5.1.
    pub fn benefit(&self, situation: &Situation) -> f64 {
        self.savings(situation)[0]
    }

    /// `C(wait) - C(send)` without the cost of packets and without what does not depend on the situation, for waiting `s = 1..p` cycles.
    pub fn savings(&self, situation: &Situation) -> Vec<f64> {
        let nx = self.start.problem.a.nrows();
        let mut augmented = DVector::zeros(nx + situation.sent.len());
        augmented.rows_mut(0, nx).copy_from(&situation.state);
        augmented.rows_mut(nx, situation.sent.len()).copy_from(&situation.sent);
        self.start.coordinates.express_augmented(&mut augmented);
        let cost = |wait: usize| {
            let cost = self.cost_to_go(&situation.was_sent, wait);
            augmented.dot(&(&cost[situation.age] * &augmented))
        };
        let now = cost(0);
        (1..=self.scheduled.len()).map(|wait| cost(wait) - now).collect()
    }

    /// `K_k(i)` for this history and a first packet after `wait` cycles, by the last `N` steps of (5.12).
    fn cost_to_go(&self, was_sent: &[bool], wait: usize) -> Vec<DMatrix<f64>> {
        let problem = &self.start.problem;
        let (length, period) = (problem.length, self.scheduled.len());
        let mut recursion = CoupledRecursion::new(problem, &problem.q);
        // From cycle k + N on, no packet whose sending is in doubt is of use.
        let ahead = (wait + length * period - length) % period;
        recursion.cost_to_go.clone_from(&self.scheduled[ahead]);
        for ahead in (0..length).rev() {
            let is_sent = |age: usize| match ahead.checked_sub(age) {
                Some(cycle) => cycle >= wait && (cycle - wait).is_multiple_of(period),
                None => was_sent.get(age - ahead - 1).copied().unwrap_or(true),
            };
            recursion.chain.transitions = transitions(problem, is_sent);
            recursion.step();
        }
        recursion.cost_to_go
    }
}

/// A packet in every p-th cycle by the thesis' matrices, with the age chain of each cycle of a period: the reference for
/// [`super::schedule()`].
pub struct ScheduleReference {
    /// State block of the cost-to-go with an empty buffer and nothing under way, by cycles to the next packet, `nx x nx`.
    pub cost_to_go: Vec<DMatrix<f64>>,
    /// `Lx` of the cycles that send, `(N nu) x nx`.
    pub lx: DMatrix<f64>,
}

impl ScheduleReference {
    /// Iterates until a period changes nothing to `accuracy`, relative; `None` if that takes too long.
    pub fn new(problem: &LoopProblem, period: usize, accuracy: f64) -> Option<Self> {
        let (states, empty) = (problem.a.nrows(), problem.length);
        let (costs, gains) = settle_schedule(problem, period, accuracy)?;
        let of_state = |cost: &Vec<DMatrix<f64>>| cost[empty].view((0, 0), (states, states)).into_owned();
        Some(Self {
            cost_to_go: costs.iter().map(of_state).collect(),
            lx: gains[empty].columns(0, states).into_owned(),
        })
    }
}

/// Costs-to-go by cycles to the next packet and by age, and the gains of the cycles that send by age.
type Settled = (Vec<Vec<DMatrix<f64>>>, Vec<DMatrix<f64>>);

fn settle_schedule(problem: &LoopProblem, period: usize, accuracy: f64) -> Option<Settled> {
    /// Periods after which it has not settled.
    const MOST: usize = 20_000;
    let mut recursion = CoupledRecursion::new(problem, &problem.q);
    let mut before = recursion.cost_to_go[problem.length].clone();
    for _ in 0..MOST {
        let (mut costs, mut gains) = (Vec::new(), Vec::new());
        for ahead in 0..period {
            recursion.chain.transitions = transitions(problem, |age| (age + ahead).is_multiple_of(period));
            recursion.step();
            if ahead == 0 {
                gains.clone_from(&recursion.gains);
            }
            costs.push(recursion.cost_to_go.clone());
        }
        let after = &costs[period - 1][problem.length];
        if (after - &before).amax() <= accuracy * after.amax() {
            return Some((costs, gains));
        }
        before.copy_from(after);
    }
    None
}

/// (5.8): transition probabilities of the age where a packet of age `a` was sent iff `is_sent(a)`.
fn transitions(problem: &LoopProblem, is_sent: impl Fn(usize) -> bool) -> DMatrix<f64> {
    let length = problem.length;
    let survival = problem.survival();
    // P(arrives now | not earlier), q-check of (3.21).
    let arrives = |age: usize| {
        let before = if age == 0 { 1.0 } else { survival[age - 1] };
        if is_sent(age) && before > 0.0 { (before - survival[age]) / before } else { 0.0 }
    };
    let none_up_to = |age: usize| (0..=age).map(|a| 1.0 - arrives(a)).product::<f64>();
    DMatrix::from_fn(length + 1, length + 1, |from, to| {
        if to < length && to <= from {
            arrives(to) * (0..to).map(|age| 1.0 - arrives(age)).product::<f64>()
        } else if to == from + 1 || (to == length && from == length) {
            none_up_to(from.min(length - 1))
        } else {
            0.0
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{design::DelayDistribution, solve::age_transitions};
    use slqg::DefaultInput;

    #[test]
    fn the_age_of_a_loop_that_always_sends_is_the_usual_chain() {
        let problem = LoopProblem {
            a: DMatrix::identity(1, 1),
            b: DMatrix::identity(1, 1),
            q: DMatrix::identity(1, 1),
            r: DMatrix::identity(1, 1),
            link: DelayDistribution::new(vec![0.3, 0.25, 0.2, 0.1]).expect("a distribution"),
            length: 3,
            default_input: DefaultInput::Zero,
        };
        let always = transitions(&problem, |_| true);
        assert!((always - age_transitions(&problem.link, 3)).amax() < 1e-15);
        let never = transitions(&problem, |_| false);
        assert_eq!(never, DMatrix::from_fn(4, 4, |i, j| f64::from(u8::from(j == (i + 1).min(3)))));
    }
}
