//! Gains of a constant reference, and what it costs to stand there.

use super::{NEGLIGIBLE, PreviewGains, QUIET, Tracked, preview::LONGEST_PREVIEW, unit};
use crate::solve::{LoopProblem, Solution, flat::Flat};
use nalgebra::{DMatrix, DVector};
use slqg::synthesis::{LinearCost, Synthesis};

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
    Some(flat.at(steady, |synthesis| {
        let columns: Vec<_> = (0..outputs)
            .map(|output| settled(problem, tracked, synthesis, &unit(outputs, output)).0)
            .collect();
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
