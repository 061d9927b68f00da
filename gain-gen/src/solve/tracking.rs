//! What a reference adds to the law: preview gains in steady state, set points, the feedforward of a task. THEORY 6.
//!
//! The recursion is the core's, [`slqg::synthesis::LinearCost`]; here it is run for one unit reference after another.

use super::{LoopProblem, Solution, in_flight::Flat};
use crate::design::{Design, Goal, Preview};
use nalgebra::{DMatrix, DVector};
use slqg::synthesis::{Dimensions, LinearCost, Stage, Synthesis};

/// Most samples of a preview.
pub const LONGEST_PREVIEW: usize = 10_000;
/// Part of the preview gains' sum that one sample's must fall below before the rest is taken for nothing.
const NEGLIGIBLE: f64 = 1e-12;
/// Samples in a row that must be that small, beside one for each number of the loop's state: gains that oscillate pass
/// through zero, and those of a slow link begin with zeros.
const QUIET: usize = 32;

/// What follows the reference, and what it costs: stage cost `(Z x - z)^T Q (Z x - z) + (u - G z)^T R (u - G z)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracked {
    /// `Z`, `nz x nx`.
    pub z: DMatrix<f64>,
    /// `Q`, `nz x nz`.
    pub weight: DMatrix<f64>,
    /// `Q_K`, `nz x nz`.
    pub terminal_weight: DMatrix<f64>,
    /// `G`, `nu x nz`: the input that holds the plant at a set point; zero for a reference that moves.
    pub input: DMatrix<f64>,
}

impl Tracked {
    /// Of a design; `None` if it follows nothing.
    pub fn of(design: &Design) -> Option<Self> {
        let tracking = design.tracking.as_ref()?;
        Some(Self {
            z: tracking.z.clone(),
            weight: tracking.weight.clone(),
            terminal_weight: tracking.terminal_weight.clone(),
            input: match &tracking.goal {
                Goal::SetPoint(set_point) => set_point.input.clone(),
                Goal::Trajectory(_) => DMatrix::zeros(design.plant.inputs(), tracking.outputs()),
            },
        })
    }

    /// Tracked outputs, `nz`.
    pub fn outputs(&self) -> usize {
        self.z.nrows()
    }

    fn stage(&self, r: &DMatrix<f64>, reference: &DVector<f64>) -> OwnedStage {
        let weighted = &self.weight * reference;
        let input = &self.input * reference;
        OwnedStage {
            state: self.z.tr_mul(&weighted),
            constant: reference.dot(&weighted) + input.dot(&(r * &input)),
            input: r * input,
        }
    }
}

struct OwnedStage {
    state: DVector<f64>,
    input: DVector<f64>,
    constant: f64,
}

impl OwnedStage {
    fn borrow(&self) -> Stage<'_, f64> {
        Stage { state: self.state.as_slice(), input: self.input.as_slice(), constant: self.constant }
    }
}

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
        let unit = DVector::from_fn(outputs, |row, _| if row == output { 1.0 } else { 0.0 });
        cost.restart(tracked.stage(&problem.r, &unit).state.as_slice(), 0.0);
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

/// Gains of a set point: those of a preview of one sample, with the input weighed relative to the one that holds the plant
/// there, and the cost of standing at `value`. `None` unless the in-flight recursion found a steady state.
pub fn set_point_gains(
    problem: &LoopProblem,
    solution: &Solution,
    tracked: &Tracked,
    value: &DVector<f64>,
) -> Option<PreviewGains> {
    let steady = solution.value.as_ref().filter(|_| solution.is_stabilising())?;
    let flat = Flat::new(problem);
    let outputs = tracked.outputs();
    let units =
        (0..outputs).map(|output| DVector::from_fn(outputs, |row, _| if row == output { 1.0 } else { 0.0 }));
    Some(flat.at(steady, |synthesis| {
        let columns: Vec<_> = units.map(|unit| settled(problem, tracked, synthesis, &unit).0).collect();
        let all = DMatrix::from_columns(&columns);
        let rows = flat.dimensions.sequence_rows();
        PreviewGains {
            samples: 1,
            sequence: all.rows(0, rows).into_owned(),
            displaced: all.rows(rows, all.nrows() - rows).into_owned(),
            tail: 0.0,
            standing_cost: Some(settled(problem, tracked, synthesis, value).1),
        }
    }))
}

/// `[Uff; l]` for a reference that stands still for ever, and what a cycle then costs.
fn settled(
    problem: &LoopProblem,
    tracked: &Tracked,
    synthesis: &mut Synthesis<'_, '_, f64>,
    reference: &DVector<f64>,
) -> (DVector<f64>, f64) {
    let dimensions = synthesis.dimensions();
    let stage = tracked.stage(&problem.r, reference);
    let mut workspace = vec![0.0; dimensions.linear_workspace_len()];
    let mut cost = LinearCost::new(&dimensions, &mut workspace);
    let mut last = DVector::zeros(0);
    let mut quiet = 0;
    let mut per_cycle = 0.0;
    for _ in 0..4 * LONGEST_PREVIEW {
        let before = cost.constant();
        cost.step_back(synthesis, stage.borrow());
        per_cycle = cost.constant() - before;
        let found = DVector::from_iterator(
            cost.feedforward().len() + cost.displaced().len(),
            cost.feedforward().iter().chain(cost.displaced()).copied(),
        );
        let moved = if last.len() == found.len() { (&found - &last).amax() } else { f64::INFINITY };
        quiet = if moved <= NEGLIGIBLE * found.amax() { quiet + 1 } else { 0 };
        last = found;
        if quiet == QUIET + dimensions.gain_columns() {
            break;
        }
    }
    // What is left of the difference of two constants may be their rounding.
    let is_rounding = per_cycle <= NEGLIGIBLE * cost.constant().abs().max(stage.constant);
    (last, if is_rounding { 0.0 } else { per_cycle })
}

/// The feedforward of a task, and what the reference adds to its expected cost.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedTask {
    /// `Uff` of each cycle `k = 0..K-1`, `N nu` each.
    pub feedforward: Vec<DVector<f64>>,
    /// `sx_0`, `nx`: the start enters the cost by `- 2 sx_0^T E[x_0]`.
    pub state: DVector<f64>,
    /// `s_0`, thesis (4.13).
    pub constant: f64,
    /// What the task costs more if in each cycle the reference of that cycle is taken for all that is to come.
    pub surprise: f64,
}

/// The linear parts of a task's cost-to-go, backwards beside the recursion: for the reference as it is, and for one that
/// stands still, by tracked output.
pub(super) struct TaskReference<'r> {
    tracked: &'r Tracked,
    r: &'r DMatrix<f64>,
    /// `z_k` for `k = 0..=K`.
    reference: &'r [DVector<f64>],
    workspaces: Vec<Vec<f64>>,
}

impl<'r> TaskReference<'r> {
    pub(super) fn new(problem: &'r LoopProblem, tracked: &'r Tracked, reference: &'r [DVector<f64>]) -> Self {
        let length = Flat::new(problem).dimensions.linear_workspace_len();
        Self { tracked, r: &problem.r, reference, workspaces: vec![vec![0.0; length]; 1 + tracked.outputs()] }
    }

    /// Runs `step`, which takes the recursion one cycle back, for every cycle from the last to the first.
    pub(super) fn run<'s, 'p: 's, 'w: 's>(
        &mut self,
        synthesis: &mut Synthesis<'p, 'w, f64>,
        mut step: impl FnMut(&mut Synthesis<'p, 'w, f64>),
    ) -> TrackedTask {
        let Self { tracked, r, reference, workspaces } = self;
        let dimensions = synthesis.dimensions();
        let outputs = tracked.outputs();
        let unit = |output: usize| DVector::from_fn(outputs, |row, _| if row == output { 1.0 } else { 0.0 });
        let last = reference.last().expect("a task has an end");
        let terminal = |z: &DVector<f64>| tracked.z.tr_mul(&(&tracked.terminal_weight * z));
        let mut costs: Vec<_> =
            workspaces.iter_mut().map(|workspace| LinearCost::new(&dimensions, workspace)).collect();
        let (known, still) = costs.split_first_mut().expect("one for the reference");
        known.restart(terminal(last).as_slice(), last.dot(&(&tracked.terminal_weight * last)));
        for (output, cost) in still.iter_mut().enumerate() {
            cost.restart(terminal(&unit(output)).as_slice(), 0.0);
        }
        let steps = reference.len() - 1;
        let mut feedforward = Vec::with_capacity(steps);
        let mut surprise = 0.0;
        for now in reference[..steps].iter().rev() {
            step(synthesis);
            known.step_back(synthesis, tracked.stage(r, now).borrow());
            let chosen = DVector::from_column_slice(known.feedforward());
            let mut unaware = -&chosen;
            for (output, cost) in still.iter_mut().enumerate() {
                cost.step_back(synthesis, tracked.stage(r, &unit(output)).borrow());
                unaware.axpy(now[output], &DVector::from_column_slice(cost.feedforward()), 1.0);
            }
            let rows = chosen.len();
            let quadratic = DMatrix::from_row_slice(rows, rows, synthesis.sequence_cost());
            surprise += unaware.dot(&(quadratic * &unaware));
            feedforward.push(chosen);
        }
        feedforward.reverse();
        let state = DVector::from_column_slice(known.state());
        TrackedTask { feedforward, state, constant: known.constant(), surprise }
    }
}
