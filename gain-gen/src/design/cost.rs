//! `[cost]`: what the controller weighs, thesis (3.16) and with `[tracking]` (4.2).

use super::document::{Field, Section, counted};
use super::symmetric::{Definiteness, symmetric};
use super::{DesignError, Plant, modes};
use nalgebra::{Complex, DMatrix};

/// Stage cost `x' Q x + u' R u`, with u the input that is really applied.
///
/// With [`super::Tracking`] the design weighs the error `z - z^Ref` of the outputs `z = Z x`; its weights W are turned
/// into those of the state here, `Z' W Z`, thesis (4.10).
#[derive(Debug, Clone, PartialEq)]
pub struct Cost {
    /// Q: nx x nx, symmetric positive semidefinite; no unstable mode of the plant is free of cost.
    pub q: DMatrix<f64>,
    /// R: nu x nu, symmetric positive definite.
    pub r: DMatrix<f64>,
    /// Q_K, the weight of the state at the end of a task: nx x nx, symmetric positive semidefinite; Q unless given.
    pub terminal: DMatrix<f64>,
}

/// `q` and `terminal` as the design has them: of the state, nx x nx, or of the tracking error, nz x nz.
pub(super) struct Weights {
    pub(super) q: DMatrix<f64>,
    pub(super) terminal: DMatrix<f64>,
}

impl Cost {
    /// `unstable`: the modes of the plant that do not decay. `tracked`: Z, if `q` weighs a tracking error.
    pub(super) fn read(
        root: &Section<'_>,
        plant: &Plant,
        unstable: &[Complex<f64>],
        tracked: Option<&DMatrix<f64>>,
    ) -> Result<(Self, Weights), DesignError> {
        let cost =
            root.required("cost", "a table with the weights q and r")?.section(&["q", "r", "terminal"])?;
        let (meaning, terminal_meaning) = match tracked {
            None => ("Q, the weight of the state, nx x nx", "Q_K, the weight of the final state, nx x nx"),
            Some(_) => (
                "Q, the weight of the tracking error, nz x nz",
                "Q_K, the weight of the final tracking error, nz x nz",
            ),
        };
        let weight = |field: &Field<'_>, key: &str| {
            let (size, against) = match tracked {
                None => (plant.states(), format!("the plant has {}", counted(plant.states(), "state"))),
                Some(z) => (
                    z.nrows(),
                    format!(
                        "with [tracking], {key} weighs the tracking error, of z = Z x, nz x nz, and tracking.z has {}",
                        counted(z.nrows(), "row")
                    ),
                ),
            };
            let given = symmetric(field, size, &against, Definiteness::Semidefinite, "")?;
            let of_state = tracked.map_or_else(|| given.clone(), |z| of_state(&given, z));
            if of_state.iter().any(|entry| !entry.is_finite()) {
                let found = "found weights that grow out of range when multiplied with tracking.z".into();
                return Err(field.reject_with(found, "check the units of both".into()));
            }
            Ok((given, of_state))
        };

        let field = cost.required("q", meaning)?;
        let (given, q) = weight(&field, "q")?;
        // x'Z'QZx is 0 where QZx is, so QZ itself answers for (A, Q^(1/2) Z).
        let seen = tracked.map_or_else(|| given.clone(), |z| z.tr_mul(&given));
        if let Some(lambda) = modes::unreached(&plant.a.transpose(), &seen, unstable) {
            let lambda = modes::spoken(lambda);
            let (found, allowed) = match tracked {
                None => (
                    format!("found a weight that ignores the unstable mode {lambda}"),
                    "give each unstable mode a weight: (A, Q^(1/2)) must be detectable",
                ),
                Some(_) => (
                    format!("found a weight of the tracked outputs that ignores the unstable mode {lambda}"),
                    "track outputs that show each unstable mode, with a weight: (A, Q^(1/2) Z) must be detectable",
                ),
            };
            return Err(field.reject_with(found, allowed.into()));
        }
        let field = cost.required("r", "R, the weight of the input, nu x nu")?;
        let against = format!("the plant has {}", counted(plant.inputs(), "input"));
        let advice = "give an input without a price a small positive weight";
        let r = symmetric(&field, plant.inputs(), &against, Definiteness::Positive, advice)?;
        let (terminal_given, terminal) = match cost.optional("terminal", terminal_meaning) {
            None => (given.clone(), q.clone()),
            Some(field) => weight(&field, "terminal")?,
        };
        Ok((Cost { q, r, terminal }, Weights { q: given, terminal: terminal_given }))
    }
}

/// `Z' W Z`, exactly symmetric.
fn of_state(weight: &DMatrix<f64>, z: &DMatrix<f64>) -> DMatrix<f64> {
    let product = z.tr_mul(weight) * z;
    &product * 0.5 + product.transpose() * 0.5
}
