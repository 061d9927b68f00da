//! `[tracking]`: outputs that follow a reference or stay at a set point, thesis chapter 4.
//!
//! With this table `cost.q` and `cost.terminal` weigh the tracking error `z - z^Ref`, thesis (4.2). [`super::Cost`] then
//! has the weights of the state that follow, `Z'QZ`, which is all the feedback needs to know, thesis (4.10).

use super::cost::Weights;
use super::document::{Section, counted};
use super::{DesignError, Plant, Reference, SetPoint};
use nalgebra::{DMatrix, DVector};

/// Most reference samples the controller is told ahead.
const LONGEST_PREVIEW: usize = 10_000;
/// Share of the preview gains that may lie beyond the preview, unless the design says.
const PREVIEW_TOLERANCE: f64 = 1e-3;

/// What follows a reference, and how it is weighed. Thesis (4.1), (4.2).
#[derive(Debug, Clone, PartialEq)]
pub struct Tracking {
    /// Z, nz x nx: the tracked outputs, `z = Z x`; no row of zeros.
    pub z: DMatrix<f64>,
    /// Q, nz x nz: weight of the tracking error, `cost.q` as given; symmetric positive semidefinite.
    pub weight: DMatrix<f64>,
    /// Q_K, nz x nz: the same at the end of a task, `cost.terminal` as given; symmetric positive semidefinite.
    pub terminal_weight: DMatrix<f64>,
    /// What z is to be.
    pub goal: Goal,
}

/// What the tracked outputs are to be.
#[derive(Debug, Clone, PartialEq)]
pub enum Goal {
    /// A constant to stay at.
    SetPoint(SetPoint),
    /// A reference that moves and is known some cycles ahead.
    Trajectory(Trajectory),
}

/// A reference that moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// How far ahead the controller knows it.
    pub preview: Preview,
    /// The reference itself, if it is part of the design; else it is given at run time.
    pub reference: Option<Reference>,
}

/// How many reference samples ahead the controller knows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Preview {
    /// As many as matter.
    Auto {
        /// Share of the preview gains that may lie beyond; above 0, below 1.
        tolerance: f64,
    },
    /// So many, 1 to 10000.
    Cycles(usize),
}

impl Tracking {
    /// What the tracked outputs are to be in `cycle`, which begins at `cycle * sample_time` (s): nz values. `None` if
    /// that is known at run time only.
    pub fn reference(&self, cycle: usize, sample_time: f64) -> Option<DVector<f64>> {
        match &self.goal {
            Goal::SetPoint(set_point) => Some(set_point.value.clone()),
            Goal::Trajectory(trajectory) => {
                trajectory.reference.as_ref().map(|reference| reference.at(cycle as f64 * sample_time))
            }
        }
    }

    /// nz, the number of tracked outputs.
    pub fn outputs(&self) -> usize {
        self.z.nrows()
    }
}

/// The table with Z read: the cost is read in terms of Z, and what is left of the table in terms of the cost.
pub(super) struct TrackedOutputs<'d> {
    /// Z, nz x nx.
    pub(super) z: DMatrix<f64>,
    tracking: Section<'d>,
}

impl<'d> TrackedOutputs<'d> {
    /// `None`: the design tracks nothing.
    pub(super) fn read(root: &Section<'d>, plant: &Plant) -> Result<Option<Self>, DesignError> {
        let Some(table) = root.optional("tracking", "a table with the key z") else { return Ok(None) };
        let tracking = table.section(&[
            "z",
            "preview",
            "preview_tolerance",
            "reference",
            "interpolation",
            "set_point",
        ])?;
        let meaning = "Z, a matrix with one row per tracked output and one column per state";
        let field = tracking.required("z", meaning)?;
        let z = field.matrix()?;
        let (outputs, states) = (z.nrows(), plant.states());
        if z.ncols() != states {
            let size = counted(states, "state");
            let found = format!("found a {outputs}x{} matrix, but the plant has {size}", z.ncols());
            return Err(field.reject_with(found, format!("give a {outputs}x{states} matrix")));
        }
        if let Some(row) = z.row_iter().position(|row| row.amax() == 0.0) {
            let found = format!("found only zeros in row {}: this output never moves", row + 1);
            return Err(field.reject_with(found, "leave the row out or say what it tracks".into()));
        }
        Ok(Some(TrackedOutputs { z, tracking }))
    }

    /// The rest of the table. `weights`: of the tracking error, as given; `r`: nu x nu, the weight of the input.
    pub(super) fn finish(
        self,
        plant: &Plant,
        weights: Weights,
        r: &DMatrix<f64>,
    ) -> Result<Tracking, DesignError> {
        let TrackedOutputs { z, tracking } = self;
        let goal = goal(&tracking, plant, &z, r)?;
        Ok(Tracking { z, weight: weights.q, terminal_weight: weights.terminal, goal })
    }
}

fn goal(
    tracking: &Section<'_>,
    plant: &Plant,
    z: &DMatrix<f64>,
    r: &DMatrix<f64>,
) -> Result<Goal, DesignError> {
    let meaning = "a list of numbers, one per row of tracking.z";
    let Some(field) = tracking.optional("set_point", meaning) else {
        let preview = preview(tracking)?;
        return Ok(Goal::Trajectory(Trajectory {
            preview,
            reference: Reference::read(tracking, z.nrows())?,
        }));
    };
    for key in ["preview", "preview_tolerance", "reference", "interpolation"] {
        if let Some(other) = tracking.optional(key, "") {
            let found = "found beside tracking.set_point".to_string();
            let allowed = "leave one of them out: a set point stays where it is, so that there is nothing to \
                           preview or to follow";
            return Err(other.reject_with(found, allowed.into()));
        }
    }
    Ok(Goal::SetPoint(SetPoint::read(&field, plant, z, r)?))
}

fn preview(tracking: &Section<'_>) -> Result<Preview, DesignError> {
    let field = tracking.optional("preview", "a whole number of cycles from 1 to 10000, or \"auto\"");
    let tolerance = tracking.optional("preview_tolerance", "a number above 0 and below 1");
    if let Some(field) = field {
        if !field.is_text() {
            let cycles = field.whole_number(1..=LONGEST_PREVIEW)?;
            let Some(tolerance) = tolerance else { return Ok(Preview::Cycles(cycles)) };
            let found = "found beside a number of cycles".to_string();
            return Err(tolerance.reject_with(found, "give it with preview = \"auto\" only".into()));
        }
        field.choice(&[("auto", ())])?;
    }
    let Some(field) = tolerance else { return Ok(Preview::Auto { tolerance: PREVIEW_TOLERANCE }) };
    let tolerance = field.number()?;
    if !(0.0 < tolerance && tolerance < 1.0) {
        return Err(field.reject(format!("found the number {tolerance}")));
    }
    Ok(Preview::Auto { tolerance })
}
