//! Units in which plant and law have entries of like size, so that the units of the design file do not matter.

use crate::balance::{power_of_two, state_units_with_free_inputs};
use crate::design::Plant;
use crate::solve::Law;
use nalgebra::{DMatrix, DVector};

/// The unit of each state, input and output, in the design's.
#[derive(Debug, Clone)]
pub(crate) struct Units {
    states: DVector<f64>,
    inputs: DVector<f64>,
    outputs: DVector<f64>,
}

impl Units {
    /// States balanced, inputs by what they do to them, outputs by their noise.
    pub(crate) fn of(plant: &Plant) -> Self {
        let states = DVector::from_vec(state_units_with_free_inputs(&plant.a, &plant.b));
        let inputs = plant.b.column_iter().map(|column| {
            let effect = column.component_div(&states).amax();
            if effect > 0.0 { power_of_two(effect.recip()) } else { 1.0 }
        });
        Self {
            inputs: DVector::from_iterator(plant.inputs(), inputs),
            outputs: plant.measurement_noise.diagonal().map(|variance| power_of_two(variance.sqrt())),
            states,
        }
    }

    /// The plant in these units.
    pub(crate) fn plant(&self, plant: &Plant) -> Plant {
        let (x, u, y) = (&self.states, &self.inputs, &self.outputs);
        let covariance = |matrix: &DMatrix<f64>, unit: &DVector<f64>| {
            matrix.map_with_location(|row, column, value| value / unit[row] / unit[column])
        };
        Plant {
            sample_time: plant.sample_time,
            a: rescaled(&plant.a, x, x),
            b: rescaled(&plant.b, x, u),
            c: rescaled(&plant.c, y, x),
            process_noise: covariance(&plant.process_noise, x),
            measurement_noise: covariance(&plant.measurement_noise, y),
            initial_mean: plant.initial_mean.component_div(x),
            initial_covariance: covariance(&plant.initial_covariance, x),
            continuous: plant.continuous.as_ref().map(|(a, b)| (rescaled(a, x, x), rescaled(b, x, u))),
        }
    }

    /// The law in these units.
    pub(crate) fn law(&self, law: &Law) -> Law {
        let inputs = |count: usize| DVector::from_fn(count, |row, _| self.inputs[row % self.inputs.len()]);
        let sequence = inputs(law.lx.nrows());
        Law {
            lx: rescaled(&law.lx, &sequence, &self.states),
            m: rescaled(&law.m, &sequence, &inputs(law.m.ncols())),
            ..law.clone()
        }
    }
}

/// `to^-1 matrix from`, with the units of rows and columns on the diagonals.
fn rescaled(matrix: &DMatrix<f64>, to: &DVector<f64>, from: &DVector<f64>) -> DMatrix<f64> {
    matrix.map_with_location(|row, column, value| value / to[row] * from[column])
}
