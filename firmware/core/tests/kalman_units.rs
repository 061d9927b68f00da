//! Units change nothing but units: where they change by powers of two, not a bit is different.

#[path = "random/dice.rs"]
mod dice;
mod driven;
mod lent;

use dice::Dice;
use driven::{Driven, Link, settings};
use slqg::estimator::{Merging, Model};
use slqg::nalgebra::{SMatrix, SVector};
use slqg::{Age, DefaultInput, Scalar, Tick};

const LENGTH: usize = 2;
const NX: usize = 3;
const NY: usize = 2;
type Filter<T> = Driven<T, NX, 1, NY, LENGTH, 5>;

/// A plant that grows by up to 1.5 a cycle, of entries that single precision has too.
fn plant(dice: &mut Dice) -> Model<f64, NX, 1, NY> {
    let mut number = || (dice.roll() * 64.0).round() / 32.0 - 1.0;
    let (a, process, initial) = (
        SMatrix::from_fn(|_, _| number()),
        SMatrix::<f64, NX, NX>::from_fn(|_, _| number()),
        SMatrix::<f64, NX, NX>::from_fn(|_, _| number()),
    );
    let noise = SMatrix::<f64, NY, NY>::from_fn(|_, _| number());
    Model {
        a,
        b: SMatrix::from_fn(|_, _| number()),
        c: SMatrix::from_fn(|_, _| number()),
        process_noise: process * process.transpose() + SMatrix::identity() / 16.0,
        measurement_noise: noise * noise.transpose() + SMatrix::identity() / 16.0,
        initial_mean: SVector::from_fn(|_, _| number()),
        initial_covariance: initial * initial.transpose() + SMatrix::identity() / 16.0,
    }
}

/// The same plant with states and outputs in units that are `2^-x` and `2^-y` as large.
fn scaled<T: Scalar>(plant: &Model<f64, NX, 1, NY>, x: [i32; NX], y: [i32; NY]) -> Model<T, NX, 1, NY> {
    let factor = |power: i32| 2f64.powi(power);
    Model {
        a: SMatrix::from_fn(|i, j| T::nearest(plant.a[(i, j)] * factor(x[i] - x[j]))),
        b: SMatrix::from_fn(|i, j| T::nearest(plant.b[(i, j)] * factor(x[i]))),
        c: SMatrix::from_fn(|i, j| T::nearest(plant.c[(i, j)] * factor(y[i] - x[j]))),
        process_noise: SMatrix::from_fn(|i, j| T::nearest(plant.process_noise[(i, j)] * factor(x[i] + x[j]))),
        measurement_noise: SMatrix::from_fn(|i, j| {
            T::nearest(plant.measurement_noise[(i, j)] * factor(y[i] + y[j]))
        }),
        initial_mean: SVector::from_fn(|i, _| T::nearest(plant.initial_mean[i] * factor(x[i]))),
        initial_covariance: SMatrix::from_fn(|i, j| {
            T::nearest(plant.initial_covariance[(i, j)] * factor(x[i] + x[j]))
        }),
    }
}

/// Mean and covariance after every cycle, in the plant's own units, and how often an estimate began anew.
fn history<T: Scalar>(
    plant: &Model<f64, NX, 1, NY>,
    merging: Merging,
    x: [i32; NX],
    y: [i32; NY],
) -> (Vec<Vec<f64>>, u32) {
    let link = Link::new(scaled::<T>(plant, x, y), &[0.5, 0.25], settings(DefaultInput::Zero, None));
    let mut driven: Filter<T> = link.driven(merging, 2, Tick(0));
    let mut dice = Dice(0x0417);
    let factor = |power: i32| 2f64.powi(-power);
    let mut found = Vec::new();
    for cycle in 0..300u32 {
        let output: [f64; NY] = [(); NY].map(|()| (dice.roll() * 32.0).round() / 16.0 - 1.0);
        let inputs = [(); LENGTH].map(|()| SVector::from([T::nearest((dice.roll() * 32.0).round() / 16.0)]));
        let is_silent = (50..200).contains(&cycle);
        if !is_silent && dice.roll() < 0.8 {
            let output = SVector::from_fn(|i, _| T::nearest(output[i] * 2f64.powi(y[i])));
            driven.filter.measure(Tick(cycle), output).expect("in time");
        }
        if cycle > 1 && dice.roll() < 0.5 {
            driven.filter.acknowledge(Tick(cycle) - 2, Age::Steps(0));
        }
        driven.filter();
        let estimate = driven.filter.posterior();
        let covariance = estimate.covariance();
        let mean = (0..NX).map(|i| estimate.mean[i].widen() * factor(x[i]));
        let entries = (0..NX).flat_map(|i| (0..NX).map(move |j| (i, j)));
        let entries = entries.map(|(i, j)| covariance[(i, j)].widen() * factor(x[i] + x[j]));
        found.push(mean.chain(entries).collect());
        driven.advance(Some(inputs));
    }
    (found, driven.filter.begun_anew())
}

fn nothing_changes<T: Scalar>(merging: Merging, x: [i32; NX], y: [i32; NY]) {
    let mut dice = Dice(0x5CA1E);
    let mut begun_anew = 0;
    for number in 0..20 {
        let plant = plant(&mut dice);
        let (expected, times) = history::<T>(&plant, merging, [0; NX], [0; NY]);
        let found = history::<T>(&plant, merging, x, y);
        assert!(found == (expected, times), "plant {number}, {merging:?}");
        begun_anew += times;
    }
    assert!(begun_anew > 0, "no silence was long enough");
}

#[test]
fn states_and_outputs_in_other_units_have_the_same_estimates_to_the_bit() {
    nothing_changes::<f32>(Merging::Single, [7, -5, 3], [-4, 6]);
    nothing_changes::<f64>(Merging::Single, [20, -31, 0], [9, -12]);
}

#[test]
fn states_in_other_units_are_merged_alike_to_the_bit() {
    // Units of outputs change the logarithms of likelihoods by a constant, which is rounded.
    for merging in [Merging::Imm, Merging::Gpb2] {
        nothing_changes::<f32>(merging, [7, -5, 3], [0, 0]);
        nothing_changes::<f64>(merging, [20, -31, 0], [0, 0]);
    }
}
