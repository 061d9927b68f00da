//! Gains over the reference samples to come, in steady state, and how many of them matter.

use super::{NEGLIGIBLE, OwnedStage, QUIET, Tracked, set_point_gains, unit};
use crate::design::{Design, Goal, Preview};
use crate::solve::{LoopProblem, Solution, flat::Flat};
use nalgebra::{DMatrix, DVector};
use slqg::synthesis::{Dimensions, LinearCost, Synthesis};

/// Most samples of a preview.
pub const LONGEST_PREVIEW: usize = 10_000;

/// Gains over the reference samples to come, as [`slqg::tracking::Preview`] takes them.
#[derive(Debug, Clone, PartialEq)]
pub struct PreviewGains {
    /// Samples known ahead, `T`.
    pub samples: usize,
    /// `[Gamma_1 .. Gamma_T]`, `(N nu) x (T nz)`. The last one stands for all that follow: their sum.
    pub sequence: DMatrix<f64>,
    /// `(n_v nu) x (T nz)`: what the inputs in flight are worth, for an event trigger.
    pub displaced: DMatrix<f64>,
    /// Share of the gains, by sums of absolute values, that belongs to samples beyond the `T`-th: the largest over inputs
    /// and tracked outputs.
    pub tail: f64,
    /// Of a set point: the cost per cycle of standing there, which with the state known comes on top of `tr(P W)`.
    pub standing_cost: Option<f64>,
}

impl PreviewGains {
    /// What the design's `[tracking]` asks for; `None` if it has none, or `solution` no steady state of the in-flight
    /// recursion.
    ///
    /// # Errors
    /// No preview of up to [`LONGEST_PREVIEW`] samples meets the tolerance.
    pub fn of(design: &Design, solution: &Solution) -> Option<Result<Self, PreviewTooLong>> {
        Self::over(&LoopProblem::of(design), design, solution)
    }

    /// The same for another loop with the design's plant and cost.
    ///
    /// # Errors
    /// As [`PreviewGains::of`].
    pub fn over(
        problem: &LoopProblem,
        design: &Design,
        solution: &Solution,
    ) -> Option<Result<Self, PreviewTooLong>> {
        let tracked = Tracked::of(design)?;
        match &design.tracking.as_ref()?.goal {
            Goal::SetPoint(set_point) => {
                set_point_gains(problem, solution, &tracked, &set_point.value).map(Ok)
            }
            Goal::Trajectory(trajectory) => preview_gains(problem, solution, &tracked, trajectory.preview),
        }
    }

    /// Numbers in both tables together.
    pub fn floats(&self) -> usize {
        self.sequence.len() + self.displaced.len()
    }
}

/// A preview would have to be longer than [`LONGEST_PREVIEW`].
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "tracking.preview_tolerance: {LONGEST_PREVIEW} samples ahead leave {tail:.1e} of the gains beyond them, more than {tolerance:e}; \
     give a larger tolerance, or preview = the number of samples that can be known"
)]
pub struct PreviewTooLong {
    /// Asked for.
    pub tolerance: f64,
    /// What the longest preview leaves.
    pub tail: f64,
}

/// The gains of each sample `t = 1, 2, ..` until the rest is negligible: `[sequence; displaced]`, `(N nu + n_v nu) x nz`.
fn responses(
    problem: &LoopProblem,
    tracked: &Tracked,
    synthesis: &mut Synthesis<'_, '_, f64>,
) -> Vec<DMatrix<f64>> {
    let dimensions = synthesis.dimensions();
    let (rows, outputs) = (dimensions.sequence_rows(), tracked.outputs());
    let nothing = OwnedStage {
        state: DVector::zeros(dimensions.states),
        input: DVector::zeros(dimensions.inputs),
        constant: 0.0,
    };
    let mut workspaces = vec![vec![0.0; dimensions.linear_workspace_len()]; outputs];
    let mut costs: Vec<_> =
        workspaces.iter_mut().map(|workspace| LinearCost::new(&dimensions, workspace)).collect();
    for (output, cost) in costs.iter_mut().enumerate() {
        cost.restart(tracked.stage(&problem.r, &unit(outputs, output)).state.as_slice(), 0.0);
    }
    let mut found: Vec<DMatrix<f64>> = Vec::new();
    let mut total = DMatrix::zeros(rows, outputs);
    let mut quiet = 0;
    while quiet < QUIET + dimensions.gain_columns() && found.len() < 4 * LONGEST_PREVIEW {
        let mut gains = DMatrix::zeros(rows + dimensions.in_flight_rows(), outputs);
        for (output, cost) in costs.iter_mut().enumerate() {
            cost.step_back(synthesis, nothing.borrow());
            gains.view_mut((0, output), (rows, 1)).copy_from_slice(cost.feedforward());
            gains
                .view_mut((rows, output), (dimensions.in_flight_rows(), 1))
                .copy_from_slice(cost.displaced());
        }
        let size = gains.rows(0, rows).abs();
        total += &size;
        let largest = by_input(&dimensions, &size).zip_map(&by_input(&dimensions, &total), share).max();
        quiet = if largest <= NEGLIGIBLE { quiet + 1 } else { 0 };
        found.push(gains);
    }
    found
}

/// The largest over the steps of a sequence, `nu x nz`.
fn by_input(dimensions: &Dimensions, sizes: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(dimensions.inputs, sizes.ncols(), |input, output| {
        (0..dimensions.length)
            .map(|step| sizes[(step * dimensions.inputs + input, output)])
            .fold(0.0, f64::max)
    })
}

fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

/// Preview gains of the problem's steady state. `None` unless the in-flight recursion found one.
///
/// # Errors
/// No preview of up to [`LONGEST_PREVIEW`] samples meets the tolerance.
pub fn preview_gains(
    problem: &LoopProblem,
    solution: &Solution,
    tracked: &Tracked,
    preview: Preview,
) -> Option<Result<PreviewGains, PreviewTooLong>> {
    let value = solution.value.as_ref().filter(|_| solution.is_stabilising())?;
    let flat = Flat::new(problem);
    let gains = flat.at(value, |synthesis| responses(problem, tracked, synthesis));
    Some(cut(&flat.dimensions, &gains, preview))
}

/// The gains of the first samples, the last of which takes in all that follow.
fn cut(
    dimensions: &Dimensions,
    gains: &[DMatrix<f64>],
    preview: Preview,
) -> Result<PreviewGains, PreviewTooLong> {
    let rows = dimensions.sequence_rows();
    let outputs = gains[0].ncols();
    let sum_from = |from: usize, of: &dyn Fn(&DMatrix<f64>) -> DMatrix<f64>| {
        // From the small end, so that tails are accurate.
        let zero = DMatrix::zeros(gains[0].nrows(), outputs);
        gains.iter().skip(from).rev().fold(zero, |sum, gain| sum + of(gain))
    };
    let sizes = |from: usize| by_input(dimensions, &sum_from(from, &DMatrix::abs).rows(0, rows).into_owned());
    let whole = sizes(0);
    let tail = |samples: usize| sizes(samples).zip_map(&whole, share).max();
    let samples = match preview {
        Preview::Cycles(samples) => samples,
        Preview::Auto { tolerance } => {
            let most = gains.len().min(LONGEST_PREVIEW);
            if tail(most) > tolerance {
                return Err(PreviewTooLong { tolerance, tail: tail(most) });
            }
            // Tails fall with the length: bisection.
            let (mut short, mut enough) = (0, most);
            while enough - short > 1 {
                let middle = short + (enough - short) / 2;
                if tail(middle) > tolerance { short = middle } else { enough = middle }
            }
            enough
        }
    };
    let mut all = DMatrix::from_fn(gains[0].nrows(), samples * outputs, |row, column| {
        gains.get(column / outputs).map_or(0.0, |gain| gain[(row, column % outputs)])
    });
    all.columns_mut((samples - 1) * outputs, outputs).copy_from(&sum_from(samples - 1, &DMatrix::clone));
    Ok(PreviewGains {
        samples,
        sequence: all.rows(0, rows).into_owned(),
        displaced: all.rows(rows, all.nrows() - rows).into_owned(),
        tail: tail(samples),
        standing_cost: None,
    })
}
