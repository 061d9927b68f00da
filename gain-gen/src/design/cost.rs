//! `[cost]`: what the controller weighs, thesis (3.16).

use super::document::{Section, counted};
use super::symmetric::{Definiteness, symmetric};
use super::{DesignError, Plant, modes};
use nalgebra::{Complex, DMatrix};

/// Stage cost `x' Q x + u' R u`, with u the input that is really applied.
#[derive(Debug, Clone, PartialEq)]
pub struct Cost {
    /// Q: nx x nx, symmetric positive semidefinite; no unstable mode of the plant is free of cost.
    pub q: DMatrix<f64>,
    /// R: nu x nu, symmetric positive definite.
    pub r: DMatrix<f64>,
    /// Q_K, the weight of the state at the end of a task: nx x nx, symmetric positive semidefinite; Q unless given.
    pub terminal: DMatrix<f64>,
}

impl Cost {
    /// `unstable`: the modes of the plant that do not decay.
    pub(super) fn read(
        root: &Section<'_>,
        plant: &Plant,
        unstable: &[Complex<f64>],
    ) -> Result<Self, DesignError> {
        let cost =
            root.required("cost", "a table with the weights q and r")?.section(&["q", "r", "terminal"])?;
        let field = cost.required("q", "Q, the weight of the state, nx x nx")?;
        let size = counted(plant.states(), "state");
        let q = symmetric(&field, plant.states(), &size, Definiteness::Semidefinite, "")?;
        // Q and its square root have the same null space, so Q itself answers for (A, Q^(1/2)).
        if let Some(lambda) = modes::unreached(&plant.a.transpose(), &q, unstable) {
            let found = format!("found a weight that ignores the unstable mode {}", modes::spoken(lambda));
            let allowed = "give each unstable mode a weight: (A, Q^(1/2)) must be detectable";
            return Err(field.reject_with(found, allowed.into()));
        }
        let field = cost.required("r", "R, the weight of the input, nu x nu")?;
        let size = counted(plant.inputs(), "input");
        let advice = "give an input without a price a small positive weight";
        let r = symmetric(&field, plant.inputs(), &size, Definiteness::Positive, advice)?;
        let terminal = match cost.optional("terminal", "Q_K, the weight of the final state, nx x nx") {
            None => q.clone(),
            Some(field) => {
                let size = counted(plant.states(), "state");
                symmetric(&field, plant.states(), &size, Definiteness::Semidefinite, "")?
            }
        };
        Ok(Cost { q, r, terminal })
    }
}
