//! What a reference adds to the law. THEORY 6.
//!
//! The recursion is the core's, [`slqg::synthesis::LinearCost`]; here it is run for one unit reference after another. What is
//! followed and what it costs is said in this file; gains over the samples to come are in `preview`, those of a constant
//! in `set_point`, the feedforward of a task that ends in `task`.

mod preview;
mod set_point;
mod task;

use crate::design::{Design, Goal};
use nalgebra::{DMatrix, DVector};
use slqg::synthesis::Stage;

pub use preview::{LONGEST_PREVIEW, PreviewGains, PreviewTooLong, preview_gains};
pub use set_point::set_point_gains;
pub(in crate::solve) use task::TaskReference;
pub use task::TrackedTask;

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

/// `z` that asks for one tracked output only.
fn unit(outputs: usize, output: usize) -> DVector<f64> {
    DVector::from_fn(outputs, |row, _| if row == output { 1.0 } else { 0.0 })
}
