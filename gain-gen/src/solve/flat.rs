//! A problem as the core takes it: row-major slices, and a workspace.

use super::LoopProblem;
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
            dimensions: dimensions(problem),
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

    /// The problem as the core takes it.
    pub(super) fn problem(&self) -> Problem<'_, f64> {
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

    /// The core's recursion for this problem; `workspace` must be of its dimensions' length, and zero.
    pub(super) fn synthesis<'w>(&self, workspace: &'w mut [f64]) -> Synthesis<'_, 'w, f64> {
        synthesis(self.problem(), workspace)
    }
}

/// A problem's sizes.
pub(super) fn dimensions(problem: &LoopProblem) -> Dimensions {
    Dimensions {
        states: problem.a.nrows(),
        inputs: problem.b.ncols(),
        length: problem.length,
        default_input: problem.default_input,
    }
}

/// A matrix as the core takes it.
pub(crate) fn row_major(matrix: &DMatrix<f64>) -> Vec<f64> {
    matrix.transpose().as_slice().to_vec()
}

/// The core's recursion for a problem and a workspace of its dimensions' length, all zeros.
pub(super) fn synthesis<'p, 'w>(
    problem: Problem<'p, f64>,
    workspace: &'w mut [f64],
) -> Synthesis<'p, 'w, f64> {
    // Fresh memory is zero already: nothing is there to be resumed.
    Synthesis::resume(problem, workspace).expect("slices and workspace are made to the problem's dimensions")
}

/// Multiplies `(P, S, Y, N_t)`, as the core lays them out, by a factor for the row and one for the column of each entry: those of
/// the states, `nx`, and of the inputs in flight, `n_v nu`.
pub(super) fn scale_value(value: &mut [f64], inputs: usize, states: &[f64], in_flight: &[f64]) {
    let mut rest = value;
    let mut scale_row = |row: &f64, columns: &[f64]| {
        let (entries, later) = std::mem::take(&mut rest).split_at_mut(columns.len());
        rest = later;
        entries.iter_mut().zip(columns).for_each(|(entry, column)| *entry *= row * column);
    };
    for columns in [states, in_flight] {
        states.iter().for_each(|row| scale_row(row, columns));
    }
    // `Y` has all inputs in flight, `N_t` those from `t` on.
    for first in std::iter::once(0).chain((0..in_flight.len()).step_by(inputs)) {
        (first..in_flight.len()).for_each(|row| scale_row(&in_flight[row], &in_flight[first..=row]));
    }
}
