//! The core's in-flight recursion iterated to its fixed point: THEORY 4 and 5 in `f64`.

use super::{
    LoopProblem, Solution,
    iterate::{Recursion, iterate},
    law::Law,
    spectral::spectral_radius,
};
use crate::stability;
use nalgebra::DMatrix;
use slqg::synthesis::{Dimensions, Problem, Synthesis};

/// A problem's matrices as the row-major slices the core takes.
struct Flat {
    dimensions: Dimensions,
    a: Vec<f64>,
    b: Vec<f64>,
    q: Vec<f64>,
    r: Vec<f64>,
    survival: Vec<f64>,
}

impl Flat {
    fn new(problem: &LoopProblem) -> Self {
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
            survival: problem.survival(),
        }
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
}

fn row_major(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

struct InFlightRecursion<'p, 'w> {
    synthesis: Synthesis<'p, 'w, f64>,
    problem: Problem<'p, f64>,
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
        let Dimensions { states, inputs, .. } = self.problem.dimensions;
        let (no_q, no_r) = (vec![0.0; states * states], vec![0.0; inputs * inputs]);
        let mut workspace = vec![0.0; self.problem.dimensions.workspace_len()];
        let mut homogeneous = synthesis(Problem { q: &no_q, r: &no_r, ..self.problem }, &mut workspace);
        homogeneous.set_gains(self.synthesis.gains());
        // Start inside the cone of costs: x^T x, which every mode of the plant shows in.
        homogeneous.restart(&row_major(&DMatrix::identity(states, states)));
        let start = homogeneous.value().to_vec();
        spectral_radius(&start, |from, to| {
            homogeneous.value_mut().copy_from_slice(from);
            homogeneous.fixed_step();
            to.copy_from_slice(homogeneous.value());
        })
    }
}

fn synthesis<'p, 'w>(problem: Problem<'p, f64>, workspace: &'w mut [f64]) -> Synthesis<'p, 'w, f64> {
    Synthesis::new(problem, workspace).expect("slices and workspace are made to the problem's dimensions")
}

pub(super) fn solve(problem: &LoopProblem) -> Solution {
    let flat = Flat::new(problem);
    let mut workspace = vec![0.0; flat.dimensions.workspace_len()];
    let mut recursion =
        InFlightRecursion { synthesis: synthesis(flat.problem(), &mut workspace), problem: flat.problem() };
    recursion.synthesis.restart(&flat.q);
    let ending = iterate(&mut recursion, problem.stage_cost_scale(), stability::runs_dry(problem));

    let (rows, columns) = (flat.dimensions.sequence_rows(), flat.dimensions.gain_columns());
    let states = flat.dimensions.states;
    let gains = DMatrix::from_row_slice(rows, columns, recursion.synthesis.gains());
    let law = Law {
        length: problem.length,
        default_input: problem.default_input,
        lx: gains.columns(0, states).into_owned(),
        m: gains.columns(states, columns - states).into_owned(),
        arrival: problem.arrival_table(),
    };
    Solution {
        outcome: ending.outcome,
        iterations: ending.iterations,
        residual: ending.residual,
        mean_square_rate: ending.mean_square_rate,
        coupled_gains: None,
        law,
        cost_to_go: DMatrix::from_row_slice(states, states, recursion.synthesis.cost_to_go()),
    }
}
