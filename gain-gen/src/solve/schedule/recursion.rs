//! One period as a step of an iteration: a cycle that sends, then cycles that do not.
//!
//! The cost-to-go at hand is that of the cycle after a packet. Whatever asks for a rate gets that of a whole period.

use super::super::{
    LoopProblem,
    evaluation::solve_like,
    flat::{Flat, synthesis},
    iterate::Recursion,
    krylov::norm,
    spectral::{FILTER, dominant},
};
use nalgebra::DMatrix;
use slqg::synthesis::{Dimensions, Problem, Synthesis};

/// What the recursion's steps work in.
pub(super) struct Workspaces {
    /// Survival over a link on which nothing arrives.
    never: Vec<f64>,
    no_q: Vec<f64>,
    no_r: Vec<f64>,
    sending: Vec<f64>,
    quiet: Vec<f64>,
    sending_map: Vec<f64>,
    quiet_map: Vec<f64>,
}

impl Workspaces {
    pub(super) fn new(problem: &LoopProblem, dimensions: &Dimensions) -> Self {
        let workspace = || vec![0.0; dimensions.workspace_len()];
        Self {
            never: vec![1.0; problem.length],
            no_q: vec![0.0; problem.q.len()],
            no_r: vec![0.0; problem.r.len()],
            sending: workspace(),
            quiet: workspace(),
            sending_map: workspace(),
            quiet_map: workspace(),
        }
    }
}

/// The recursion over a period.
pub(super) struct Periodic<'p> {
    period: usize,
    dimensions: Dimensions,
    /// The step that sends; it holds the cost-to-go.
    sending: Synthesis<'p, 'p, f64>,
    /// The step that does not: its gains are zero, and nothing would arrive.
    quiet: Synthesis<'p, 'p, f64>,
    /// The same without stage cost.
    sending_map: Synthesis<'p, 'p, f64>,
    quiet_map: Synthesis<'p, 'p, f64>,
}

impl<'p> Periodic<'p> {
    pub(super) fn new(flat: &'p Flat, workspaces: &'p mut Workspaces, period: usize) -> Self {
        let Workspaces { never, no_q, no_r, sending, quiet, sending_map, quiet_map } = workspaces;
        let problem = flat.problem();
        let free = Problem { q: no_q, r: no_r, ..problem };
        Self {
            period,
            dimensions: flat.dimensions,
            sending: synthesis(problem, sending),
            quiet: synthesis(Problem { survival: never, ..problem }, quiet),
            sending_map: synthesis(free, sending_map),
            quiet_map: synthesis(Problem { survival: never, ..free }, quiet_map),
        }
    }

    /// Sets the gains of the cycles that send, `[Lx M]` by rows.
    pub(super) fn set_gains(&mut self, gains: &[f64]) {
        self.sending.set_gains(gains);
    }

    /// Begins with a cost of the state.
    pub(super) fn begin(&mut self, cost: &DMatrix<f64>) {
        self.sending.restart(cost.as_slice());
    }

    /// Takes one more step, and keeps the cost-to-go of each of its cycles: by cycles to the next packet.
    pub(super) fn values(&mut self) -> Vec<Vec<f64>> {
        let mut values = Vec::with_capacity(self.period);
        self.sending.optimal_step();
        for _ in 1..self.period {
            values.push(self.sending.value().to_vec());
            self.quiet.fixed_step_of(self.sending.value_mut());
        }
        values.push(self.sending.value().to_vec());
        values
    }

    /// Calls `work` with the map of a period with the present gains, on costs-to-go without stage cost.
    fn with_map<R>(&mut self, work: impl FnOnce(&mut dyn FnMut(&mut [f64])) -> R) -> R {
        self.sending_map.set_gains(self.sending.gains());
        let Self { sending_map, quiet_map, period, .. } = self;
        work(&mut |value| {
            sending_map.fixed_step_of(value);
            (1..*period).for_each(|_| quiet_map.fixed_step_of(value));
        })
    }

    /// Makes of a cost-to-go after a packet that of one cycle of sending earlier, as far as cycles that send nothing lead.
    fn pass_quiet_cycles(&mut self) {
        (1..self.period).for_each(|_| self.quiet.fixed_step_of(self.sending.value_mut()));
    }

    /// The largest relative change over `P`, `S`, `Y` and all the `N_t` together.
    fn change(&self, before: &[f64]) -> f64 {
        let (states, in_flight) = (self.dimensions.states, self.dimensions.in_flight_rows());
        let (mut before, mut after) = (before, self.sending.value());
        let mut largest = 0.0_f64;
        let triangle = in_flight * (in_flight + 1) / 2;
        for part in [states * states, states * in_flight, triangle, usize::MAX] {
            let (old, old_rest) = before.split_at(part.min(before.len()));
            let (new, new_rest) = after.split_at(part.min(after.len()));
            (before, after) = (old_rest, new_rest);
            let size: f64 = new.iter().map(|entry| entry.abs()).sum();
            let difference: f64 = new.iter().zip(old).map(|(new, old)| (new - old).abs()).sum();
            // What has overflowed must not look settled.
            if !(size.is_finite() && difference.is_finite()) {
                return f64::INFINITY;
            }
            largest = largest.max(if size > 0.0 { difference / size } else { difference });
        }
        largest
    }
}

impl Recursion for Periodic<'_> {
    fn step(&mut self) -> f64 {
        let before = self.sending.value().to_vec();
        self.sending.optimal_step();
        self.pass_quiet_cycles();
        self.change(&before)
    }

    fn size(&self) -> f64 {
        self.sending.cost_to_go().iter().step_by(self.dimensions.states + 1).sum()
    }

    fn rate(&mut self) -> f64 {
        let states = self.dimensions.states;
        let mut start = vec![0.0; self.dimensions.value_len()];
        start[..states * states].copy_from_slice(DMatrix::<f64>::identity(states, states).as_slice());
        self.with_map(|map| dominant(&start, FILTER, [1; 3], map)).radius
    }

    fn evaluate(&mut self, accuracy: f64) -> bool {
        let before = self.sending.value().to_vec();
        self.sending.fixed_step();
        self.pass_quiet_cycles();
        let after = self.sending.value().to_vec();
        let residual: Vec<f64> = after.iter().zip(&before).map(|(after, before)| after - before).collect();
        let correction = self.with_map(|map| solve_like(&residual, norm(&after), accuracy, |_| (), map));
        let found = correction.is_some();
        let changes = correction.unwrap_or(residual);
        let values = before.iter().zip(changes).map(|(value, change)| value + change);
        self.sending.value_mut().iter_mut().zip(values).for_each(|(place, value)| *place = value);
        found
    }

    fn gains(&mut self) -> Vec<f64> {
        self.sending.gains().to_vec()
    }

    fn fall_back(&mut self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        self.dimensions.in_flight() / self.period + 1
    }
}
