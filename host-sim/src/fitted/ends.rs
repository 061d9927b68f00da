//! What both ends are told beside the tables: plant model, actuator, grids of a bus; padded to the size class.

use crate::{contender::Kind, plant::padded};
use gain_gen::{
    design::{Acknowledgement, Counted, Design, Steps},
    joining::joining_covariance,
};
use nalgebra::{DMatrix, SMatrix, SVector};
use slqg::{
    DefaultInput, Scalar,
    actuator::{Limits, Safe, Settings},
    estimator::{Merging, Model, Plausibility},
    wire::can::Grid,
};

fn cast<T: Scalar, const R: usize, const C: usize>(matrix: &SMatrix<f64, R, C>) -> SMatrix<T, R, C> {
    matrix.map(T::nearest)
}

pub(super) fn model<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    design: &Design,
    process_noise: &DMatrix<f64>,
) -> Model<T, NX, NU, NY> {
    let plant = &design.plant;
    let mean = DMatrix::from_column_slice(plant.states(), 1, plant.initial_mean.as_slice());
    Model {
        a: cast(&padded(&plant.a)),
        b: cast(&padded(&plant.b)),
        c: cast(&padded(&plant.c)),
        process_noise: cast(&padded(process_noise)),
        // A padded output has none: it is certain, and tells nothing.
        measurement_noise: cast(&padded(&plant.measurement_noise)),
        initial_mean: cast(&padded(&mean)),
        initial_covariance: cast(&padded(&plant.initial_covariance)),
    }
}

/// The plant for a controller that joins a loop that runs.
pub(super) fn joining<T: Scalar, const NX: usize, const NU: usize, const NY: usize>(
    design: &Design,
    process_noise: &DMatrix<f64>,
) -> Model<T, NX, NU, NY> {
    let covariance = joining_covariance(&design.plant, design.controller.measurement_buffer);
    Model {
        initial_mean: SVector::zeros(),
        initial_covariance: cast(&padded(&covariance)),
        ..model(design, process_noise)
    }
}

pub(super) fn actuator<T: Scalar, const NU: usize>(
    design: &Design,
    default_input: DefaultInput,
) -> Settings<T, NU> {
    let rates = design.controller.rates_per_cycle(design.plant.sample_time);
    let rate =
        rates.map(|rates| SVector::from_fn(|i, _| rates.get(i).map_or(T::zero(), |&rate| T::nearest(rate))));
    Settings {
        default_input,
        limits: design.controller.input_limits.as_ref().map(|limits| Limits {
            min: SVector::from_fn(|i, _| limits.get(i).map_or(T::zero(), |&(min, _)| T::nearest(min))),
            max: SVector::from_fn(|i, _| limits.get(i).map_or(T::zero(), |&(_, max)| T::nearest(max))),
            rate,
        }),
        safe: design.safety.safe.as_ref().map(|(after, input)| Safe {
            after: *after,
            input: SVector::from_fn(|i, _| input.get(i).map_or(T::zero(), |&value| T::nearest(value))),
        }),
    }
}

/// What is believed of the measurements; of a padded output nothing is to be said.
pub(super) fn plausibility<T: Scalar, const NY: usize>(
    design: &Design,
    acknowledgement: &Acknowledgement,
    merging: Merging,
) -> Plausibility<T, NY> {
    let safety = &design.safety;
    let anything = [-T::nearest(f64::INFINITY), T::nearest(f64::INFINITY)];
    Plausibility {
        gate: safety.threshold(acknowledgement, merging).map(T::nearest),
        doubt_after: safety.doubt_after,
        range: safety.range.as_ref().map(|range| {
            core::array::from_fn(|output| {
                range.get(output).map_or(anything, |&(least, most)| [T::nearest(least), T::nearest(most)])
            })
        }),
        stuck_after: core::array::from_fn(|output| safety.stuck_after.get(output).copied().unwrap_or(0)),
        rejects_stuck: safety.rejects_stuck,
        stale_after: safety.stale_after,
        lost_after: safety.lost_after,
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
