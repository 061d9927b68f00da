//! `tracking.set_point`: a constant to stay at, and the input that holds the plant there.

use super::document::{Field, counted};
use super::equilibrium::Equilibria;
use super::{DesignError, Plant};
use nalgebra::{DMatrix, DVector};

/// A constant that the tracked outputs are to stay at. There is a state and a constant input that hold them there.
#[derive(Debug, Clone, PartialEq)]
pub struct SetPoint {
    /// What the tracked outputs are to be: nz.
    pub value: DVector<f64>,
    /// nu x nz: the constant input that holds the tracked outputs at z, `u = input z`, of all such inputs the one with
    /// the least u'Ru. Where z cannot be held, the input for a z near it that can.
    pub input: DMatrix<f64>,
}

impl SetPoint {
    /// `z`: nz x nx, the tracked outputs. `r`: nu x nu, the weight of the input.
    pub(super) fn read(
        field: &Field<'_>,
        plant: &Plant,
        z: &DMatrix<f64>,
        r: &DMatrix<f64>,
    ) -> Result<Self, DesignError> {
        let value = DVector::from_vec(field.numbers()?);
        let outputs = z.nrows();
        if value.len() != outputs {
            let found = format!(
                "found {}, but tracking.z has {}",
                counted(value.len(), "number"),
                counted(outputs, "row")
            );
            return Err(field.reject_with(found, format!("give {}", counted(outputs, "number"))));
        }
        let equilibria = Equilibria::of(plant, z, r);
        if equilibria.hold(&value) {
            return Ok(SetPoint { value, input: equilibria.input() });
        }
        let found = format!("found {}, where no constant input holds the tracked outputs", spoken(&value));
        let nearest = spoken(&equilibria.nearest(&value));
        let free = equilibria.dimensions();
        let advice = format!(
            "give a point that can be held, the nearest is {nearest}, or add inputs or drop rows of tracking.z: \
             constant inputs hold {free} of {outputs} outputs independently"
        );
        Err(field.reject_with(found, advice))
    }
}

fn spoken(values: &DVector<f64>) -> String {
    // Twelve digits: what is given back as it was printed is accepted.
    let rounded = |value: &f64| {
        let rounded: f64 = format!("{value:.11e}").parse().expect("a number was formatted");
        rounded.to_string()
    };
    format!("[{}]", values.iter().map(rounded).collect::<Vec<_>>().join(", "))
}
