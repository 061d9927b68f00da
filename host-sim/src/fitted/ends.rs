//! What both ends are told beside the tables: plant model, actuator, grids of a bus; padded to the size class.

use crate::{contender::Kind, plant::padded};
use gain_gen::{
    design::{Counted, Design, Steps},
    joining::joining_covariance,
};
use nalgebra::{DMatrix, SMatrix, SVector};
use slqg::{
    DefaultInput, Scalar,
    actuator::{Limits, Settings},
    estimator::Model,
    wire::can::Grid,
};

fn cast<T: Scalar, const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> SMatrix<T, R, C> {
    matrix.map(T::nearest)
}

pub(super) fn model<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    design: &Design,
) -> Model<T, NX, NU, NY> {
    let plant = &design.plant;
    let mut measurement_noise = cast(&padded::<NY, NY>(&plant.measurement_noise));
    for output in plant.outputs()..NY {
        // A padded output has noise of its own, so that its innovation can be divided by.
        measurement_noise[(output, output)] = T::one();
    }
    let mean = DMatrix::from_column_slice(plant.states(), 1, plant.initial_mean.as_slice());
    Model {
        a: cast(&padded(&plant.a)),
        b: cast(&padded(&plant.b)),
        c: cast(&padded(&plant.c)),
        process_noise: cast(&padded(&plant.process_noise)),
        measurement_noise,
        initial_mean: cast(&padded(&mean)),
        initial_covariance: cast(&padded(&plant.initial_covariance)),
    }
}

/// The plant for a controller that joins a loop that runs.
pub(super) fn joining<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    design: &Design,
) -> Model<T, NX, NU, NY> {
    let covariance = joining_covariance(&design.plant, design.controller.measurement_buffer);
    Model { initial_mean: SVector::zeros(), initial_covariance: cast(&padded(&covariance)), ..model(design) }
}

pub(super) fn actuator<T: Scalar, const NU: usize>(
    design: &Design,
    default_input: DefaultInput,
) -> Settings<T, NU> {
    Settings {
        default_input,
        limits: design.controller.input_limits.as_ref().map(|limits| Limits {
            min: SVector::from_fn(|i, _| limits.get(i).map_or(T::zero(), |&(min, _)| T::nearest(min))),
            max: SVector::from_fn(|i, _| limits.get(i).map_or(T::zero(), |&(_, max)| T::nearest(max))),
        }),
    }
}

/// What values are rounded to on the network; a padded one is zero, which is on every grid. Without a network nothing is.
pub(super) fn grid<T: Scalar, const D: usize>(
    design: &Design,
    kind: Kind,
    of: impl Fn(&Steps) -> &Counted,
) -> Option<Grid<T, D>> {
    let steps = design.steps().filter(|_| kind != Kind::Lqg)?;
    let Counted { steps, largest_count } = of(&steps);
    let step = SVector::from_fn(|i, _| steps.get(i).map_or(T::one(), |&step| T::nearest(step)));
    Some(Grid { step, largest_count: *largest_count })
}
