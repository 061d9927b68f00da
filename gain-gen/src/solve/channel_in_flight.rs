//! The in-flight recursion over a channel that comes and goes: one cost-to-go for each state of the channel.
//!
//! Given the states in which packets were sent their delays are independent, so a step of THEORY 4 goes through with an
//! expectation over the channel's next state around it. The step itself is the core's, with the link of each state:
//! of size `O(S N^2)` where `correlated` has a cost for each of `O(S^N)` modes.

use super::{
    LoopProblem, Outcome, Start,
    channel_law::ChannelLaw,
    coupled::solve_semidefinite,
    flat::Flat,
    iterate::{Recursion, iterate},
    spectral::spectral_radius,
};
use crate::design::{DelayDistribution, MarkovLink};
use nalgebra::DMatrix;
use slqg::synthesis::Synthesis;
use std::cell::RefCell;

/// Gains that know the channel's state one cycle late, and how their iteration ended.
#[derive(Debug, Clone)]
pub struct ChannelSolution {
    /// How the iteration ended.
    pub outcome: Outcome,
    /// Backward steps taken.
    pub iterations: usize,
    /// Relative residual of the fixed-point equation at the last step.
    pub residual: f64,
    /// Spectral radius of the closed loop's second moments; below 1 iff mean-square stable.
    pub mean_square_rate: f64,
    /// The law.
    pub law: ChannelLaw,
    /// `P` by state of the channel in the cycle before, `nx x nx`.
    pub cost_to_go: Vec<DMatrix<f64>>,
    shares: Vec<f64>,
}

impl ChannelSolution {
    /// Long-run average cost per step if the state is known: `sum_s share(s) tr(P(s) W)`.
    pub fn control_cost(&self, process_noise: &DMatrix<f64>) -> f64 {
        let of_state = |cost: &DMatrix<f64>| cost.component_mul(process_noise).sum();
        self.shares.iter().zip(&self.cost_to_go).map(|(share, cost)| share * of_state(cost)).sum()
    }
}

/// Solves for a controller that learns the state of `channel` one cycle late. The problem's own link does not matter.
pub fn solve_channel(problem: &LoopProblem, channel: &MarkovLink) -> ChannelSolution {
    let network_free = Start::of(problem);
    let (coordinates, problem) = (&network_free.coordinates, &network_free.problem);
    let links: Vec<Flat> = (0..channel.states())
        .map(|state| Flat::with_survival(problem, survival(problem, channel.delays(state))))
        .collect();
    let dimensions = links[0].dimensions;
    let mut workspaces = vec![vec![0.0; dimensions.workspace_len()]; links.len()];
    let mut costless = vec![vec![0.0; dimensions.workspace_len()]; links.len()];
    let no_cost = LoopProblem { q: &problem.q * 0.0, r: &problem.r * 0.0, ..problem.clone() };
    let without_cost: Vec<Flat> =
        links.iter().map(|link| Flat::with_survival(&no_cost, link.survival().to_vec())).collect();
    let start = {
        let mut first = links[0].synthesis(&mut workspaces[0]);
        first.restart(network_free.cost_to_go().as_slice());
        first.value().to_vec()
    };
    let mut recursion = ChannelRecursion {
        channel,
        steps: links.iter().zip(&mut workspaces).map(|(link, workspace)| link.synthesis(workspace)).collect(),
        homogeneous: RefCell::new(
            without_cost
                .iter()
                .zip(&mut costless)
                .map(|(link, workspace)| link.synthesis(workspace))
                .collect(),
        ),
        values: vec![start; links.len()],
        gains: vec![vec![0.0; dimensions.sequence_rows() * dimensions.gain_columns()]; links.len()],
    };
    let ending = iterate(&mut recursion, network_free.cost_scale(), false);
    let (rows, states) = (dimensions.sequence_rows(), dimensions.states);
    let gains = recursion
        .gains
        .iter()
        .map(|gains| {
            let mut gain = DMatrix::from_row_slice(rows, gains.len() / rows, gains);
            coordinates.restore_gain(&mut gain);
            gain
        })
        .collect();
    let cost_to_go = recursion
        .values
        .iter()
        .map(|value| coordinates.cost(&DMatrix::from_row_slice(states, states, &value[..states * states])))
        .collect();
    ChannelSolution {
        outcome: ending.outcome,
        iterations: ending.iterations,
        residual: ending.residual,
        mean_square_rate: ending.mean_square_rate,
        law: ChannelLaw::new(problem, gains, links.iter().map(|link| link.survival().to_vec()).collect()),
        cost_to_go,
        shares: channel.shares().to_vec(),
    }
}

/// P(delay > d) for d = 0..N-1 in one state of the channel.
fn survival(problem: &LoopProblem, delays: Option<&DelayDistribution>) -> Vec<f64> {
    match delays {
        Some(delays) => LoopProblem { link: delays.clone(), ..problem.clone() }.survival(),
        None => vec![1.0; problem.length],
    }
}

struct ChannelRecursion<'p, 'w> {
    channel: &'p MarkovLink,
    /// The core's recursion with the link of each state.
    steps: Vec<Synthesis<'p, 'w, f64>>,
    /// The same without stage cost.
    homogeneous: RefCell<Vec<Synthesis<'p, 'w, f64>>>,
    /// Cost-to-go by state of the channel in the cycle before.
    values: Vec<Vec<f64>>,
    /// `[Lx M]` likewise, row-major.
    gains: Vec<Vec<f64>>,
}

impl ChannelRecursion<'_, '_> {
    /// `-Rbar(s)^# [Gx Gv](s)` with the expectations over the next state.
    fn improve_gains(&mut self) {
        for (step, value) in self.steps.iter_mut().zip(&self.values) {
            step.value_mut().copy_from_slice(value);
            step.look_ahead();
        }
        let rows = self.steps[0].dimensions().sequence_rows();
        for (state, gains) in self.gains.iter_mut().enumerate() {
            let mut quadratic = DMatrix::zeros(rows, rows);
            gains.fill(0.0);
            for (next, step) in self.steps.iter().enumerate() {
                let probability = self.channel.transition(state, next);
                quadratic += DMatrix::from_row_slice(rows, rows, step.sequence_cost()) * probability;
                gains.iter_mut().zip(step.coupling()).for_each(|(gain, entry)| *gain -= probability * entry);
            }
            let columns = gains.len() / rows;
            solve_semidefinite(&quadratic, gains, columns);
        }
    }
}

/// One cycle back with the gains held: for each state the expectation over the next one of the core's step.
fn back(
    channel: &MarkovLink,
    steps: &mut [Synthesis<'_, '_, f64>],
    gains: &[Vec<f64>],
    values: &[Vec<f64>],
) -> Vec<Vec<f64>> {
    let expected = |(state, gains): (usize, &Vec<f64>)| {
        let mut sum = vec![0.0; values[0].len()];
        for (next, step) in steps.iter_mut().enumerate() {
            let probability = channel.transition(state, next);
            if probability > 0.0 {
                step.value_mut().copy_from_slice(&values[next]);
                step.set_gains(gains);
                step.fixed_step();
                sum.iter_mut().zip(step.value()).for_each(|(sum, entry)| *sum += probability * entry);
            }
        }
        sum
    };
    gains.iter().enumerate().map(expected).collect()
}

impl Recursion for ChannelRecursion<'_, '_> {
    fn step(&mut self) -> f64 {
        self.improve_gains();
        let next = back(self.channel, &mut self.steps, &self.gains, &self.values);
        let entries = || next.iter().flatten().zip(self.values.iter().flatten());
        let difference: f64 = entries().map(|(new, old)| (new - old).abs()).sum();
        let size: f64 = entries().map(|(new, _)| new.abs()).sum();
        self.values = next;
        difference / size
    }

    fn size(&self) -> f64 {
        let states = self.steps[0].dimensions().states;
        self.values[0][..states * states].iter().step_by(states + 1).sum()
    }

    /// Plain value iteration.
    fn evaluate(&mut self, _accuracy: f64) -> bool {
        false
    }

    fn gains(&mut self) -> Vec<f64> {
        self.gains.concat()
    }

    fn fall_back(&mut self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        self.steps[0].dimensions().in_flight() + 1
    }

    fn rate(&mut self) -> f64 {
        let states = self.steps[0].dimensions().states;
        let mut start = vec![0.0; self.values[0].len()];
        start[..states * states].iter_mut().step_by(states + 1).for_each(|entry| *entry = 1.0);
        let length = start.len();
        let mut steps = self.homogeneous.borrow_mut();
        spectral_radius(&start.repeat(self.values.len()), [1, 4, 4], |from, to| {
            let values: Vec<Vec<f64>> = from.chunks_exact(length).map(<[f64]>::to_vec).collect();
            let next = back(self.channel, &mut steps, &self.gains, &values);
            for (value, to) in next.iter().zip(to.chunks_exact_mut(length)) {
                to.copy_from_slice(value);
            }
        })
    }
}
