//! How far numbers on a diagonal are apart: as they are written, and in units in which the plant is balanced.

use crate::balance::state_units_with_free_inputs;
use crate::design::Plant;
use nalgebra::DMatrix;

/// Ratio as written from which numbers may be warned of.
pub(super) const FAR: f64 = 1e12;
/// Ratio in balanced units that they must have beside it: units alone account for what is less.
const FAR_IN_BALANCE: f64 = 1e9;

/// Units in which the plant is balanced.
pub(super) struct Units {
    states: Vec<f64>,
    inputs: Vec<f64>,
    outputs: Vec<f64>,
}

impl Units {
    pub(super) fn of(plant: &Plant) -> Self {
        let (a, b) = plant.continuous.as_ref().map_or((&plant.a, &plant.b), |(a, b)| (a, b));
        let states = state_units_with_free_inputs(a, b);
        let largest = |sizes: &mut dyn Iterator<Item = f64>| sizes.fold(0.0, f64::max);
        // An input of this size moves some state by 1, an output is this large where some state is 1.
        let inputs = (0..b.ncols())
            .map(|j| largest(&mut (0..states.len()).map(|i| b[(i, j)].abs() / states[i])).recip())
            .collect();
        let outputs = (0..plant.outputs())
            .map(|k| largest(&mut (0..states.len()).map(|i| plant.c[(k, i)].abs() * states[i])))
            .collect();
        Self { states, inputs, outputs }
    }

    /// Largest and smallest weight of a state other than 0, if they are too far apart.
    pub(super) fn states_apart(&self, weights: &DMatrix<f64>) -> Option<(f64, f64)> {
        apart(weights, &self.states, 2)
    }

    /// The same for weights of inputs.
    pub(super) fn inputs_apart(&self, weights: &DMatrix<f64>) -> Option<(f64, f64)> {
        apart(weights, &self.inputs, 2)
    }

    /// The same for variances of outputs.
    pub(super) fn outputs_apart(&self, variances: &DMatrix<f64>) -> Option<(f64, f64)> {
        apart(variances, &self.outputs, -2)
    }
}

fn apart(diagonal: &DMatrix<f64>, units: &[f64], power: i32) -> Option<(f64, f64)> {
    let entries = diagonal.diagonal();
    let extremes = |values: &mut dyn Iterator<Item = f64>| {
        values
            .filter(|value| *value > 0.0 && value.is_finite())
            .fold((0.0, f64::INFINITY), |(most, least), value| {
                (f64::max(most, value), f64::min(least, value))
            })
    };
    let (most, least) = extremes(&mut entries.iter().copied());
    let in_balance = entries.iter().zip(units).map(|(entry, unit)| entry * unit.powi(power));
    let (most_balanced, least_balanced) = extremes(&mut { in_balance });
    (most / least >= FAR && most_balanced / least_balanced >= FAR_IN_BALANCE).then_some((most, least))
}
