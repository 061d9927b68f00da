//! The core's in-flight recursion iterated to its fixed point: THEORY 4 and 5 in `f64`.

use super::{
    LoopProblem, Solution,
    evaluation::solve_correction,
    iterate::{Recursion, iterate},
    krylov::norm,
    law::Law,
    packing::Packing,
    spectral::spectral_radius,
};
use crate::stability;
use nalgebra::DMatrix;
use slqg::synthesis::{Dimensions, Problem, Synthesis};

/// A problem's matrices as the row-major slices the core takes.
pub(super) struct Flat {
    pub(super) dimensions: Dimensions,
    a: Vec<f64>,
    b: Vec<f64>,
    q: Vec<f64>,
    r: Vec<f64>,
    survival: Vec<f64>,
}

impl Flat {
    pub(super) fn new(problem: &LoopProblem) -> Self {
        Self::with_survival(problem, problem.survival())
    }

    /// The same over a link with this survival function, `N` values.
    pub(super) fn with_survival(problem: &LoopProblem, survival: Vec<f64>) -> Self {
        Self {
            dimensions: Dimensions {
                states: problem.a.nrows(),
                inputs: problem.b.ncols(),
                length: problem.length,
                default_input: problem.default_input,
            },
            a: row_major(&problem.a),
            b: row_major(&problem.b),
            q: row_major(&problem.q),
            r: row_major(&problem.r),
            survival,
        }
    }

    /// P(delay > d) for d = 0..N-1.
    pub(super) fn survival(&self) -> &[f64] {
        &self.survival
    }

    /// `Q`, by rows.
    pub(super) fn state_weight(&self) -> &[f64] {
        &self.q
    }

    fn problem(&self) -> Problem<'_, f64> {
        Problem {
            dimensions: self.dimensions,
            a: &self.a,
            b: &self.b,
            q: &self.q,
            r: &self.r,
            survival: &self.survival,
        }
    }

    /// The core's recursion at the fixed point `value`, after one more step: gains, expected costs and cost-to-go belong
    /// together.
    pub(super) fn at<R>(&self, value: &[f64], work: impl FnOnce(&mut Synthesis<'_, '_, f64>) -> R) -> R {
        let mut workspace = vec![0.0; self.dimensions.workspace_len()];
        let mut synthesis = self.synthesis(&mut workspace);
        synthesis.value_mut().copy_from_slice(value);
        synthesis.optimal_step();
        work(&mut synthesis)
    }

    /// The core's recursion for this problem; `workspace` must be of its dimensions' length.
    pub(super) fn synthesis<'w>(&self, workspace: &'w mut [f64]) -> Synthesis<'_, 'w, f64> {
        synthesis(self.problem(), workspace)
    }
}

/// A matrix as the core takes it.
pub(super) fn row_major(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

struct InFlightRecursion<'p, 'w> {
    synthesis: Synthesis<'p, 'w, f64>,
    problem: Problem<'p, f64>,
    packing: Packing,
}

/// Most steps that the search for the rate takes in one.
const LONGEST_STRIDE: usize = 16;

/// Accuracy of the cost of given gains, relative to the cost.
const EVALUATION: f64 = 1e-14;

impl InFlightRecursion<'_, '_> {
    /// Calls `work` with the linear map of THEORY 5, the step with the present gains and without stage cost, acting on
    /// packed costs-to-go.
    fn with_map<R>(&self, work: impl FnOnce(&mut dyn FnMut(&[f64], &mut [f64])) -> R) -> R {
        let Dimensions { states, inputs, .. } = self.problem.dimensions;
        let (no_q, no_r) = (vec![0.0; states * states], vec![0.0; inputs * inputs]);
        let mut workspace = vec![0.0; self.problem.dimensions.workspace_len()];
        let mut homogeneous = synthesis(Problem { q: &no_q, r: &no_r, ..self.problem }, &mut workspace);
        homogeneous.set_gains(self.synthesis.gains());
        work(&mut |from, to| {
            self.packing.unpack(from, homogeneous.value_mut());
            homogeneous.fixed_step();
            self.packing.pack_into(homogeneous.value(), to);
        })
    }
}

impl Recursion for InFlightRecursion<'_, '_> {
    fn step(&mut self) -> f64 {
        self.synthesis.optimal_step()
    }

    fn size(&self) -> f64 {
        let states = self.problem.dimensions.states;
        self.synthesis.cost_to_go().iter().step_by(states + 1).sum()
    }

    fn rate(&self) -> f64 {
        // Start inside the cone of costs: x^T x, which every mode of the plant shows in.
        let states = self.problem.dimensions.states;
        let stride = (self.problem.dimensions.length / 4).clamp(1, LONGEST_STRIDE);
        let mut start = vec![0.0; self.problem.dimensions.value_len()];
        start[..states * states].iter_mut().step_by(states + 1).for_each(|entry| *entry = 1.0);
        self.with_map(|map| spectral_radius(&self.packing.pack(&start), [1, stride, stride], map))
    }

    fn memory(&self) -> usize {
        self.problem.dimensions.in_flight() + 1
    }

    fn evaluate(&mut self) -> bool {
        // One step with the gains held tells how far the cost-to-go is from being theirs.
        let before = self.packing.pack(self.synthesis.value());
        self.synthesis.fixed_step();
        let after = self.packing.pack(self.synthesis.value());
        let residual: Vec<f64> = after.iter().zip(&before).map(|(after, before)| after - before).collect();
        let correction = self.with_map(|map| solve_correction(&residual, norm(&after), EVALUATION, map));
        let found = correction.is_some();
        let value = before.iter().zip(correction.unwrap_or(residual)).map(|(value, change)| value + change);
        let value: Vec<f64> = value.collect();
        self.packing.unpack(&value, self.synthesis.value_mut());
        found
    }
}

fn synthesis<'p, 'w>(problem: Problem<'p, f64>, workspace: &'w mut [f64]) -> Synthesis<'p, 'w, f64> {
    Synthesis::new(problem, workspace).expect("slices and workspace are made to the problem's dimensions")
}

pub(super) fn solve(problem: &LoopProblem) -> Solution {
    let flat = Flat::new(problem);
    let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
    let mut recursion = InFlightRecursion {
        synthesis: flat.synthesis(&mut workspace),
        problem: flat.problem(),
        packing: Packing::new(&flat.dimensions),
    };
    recursion.synthesis.restart(&flat.q);
    let ending = iterate(&mut recursion, problem.stage_cost_scale(), stability::runs_dry(problem));

    let states = flat.dimensions.states;
    let law = Law::from_gains(problem, recursion.synthesis.gains(), problem.arrival_table());
    Solution {
        outcome: ending.outcome,
        iterations: ending.iterations,
        policy_iterations: ending.policy_iterations,
        residual: ending.residual,
        mean_square_rate: ending.mean_square_rate,
        coupled_gains: None,
        value: Some(recursion.synthesis.value().to_vec()),
        law,
        cost_to_go: DMatrix::from_row_slice(states, states, recursion.synthesis.cost_to_go()),
    }
}
