//! After an outage of any length a loop goes on as well as one that knows what the outage was.
//!
//! While nothing is heard the plant is held by hand. Then it is let go, and every measurement and acknowledgement comes.

#[path = "random/dice.rs"]
mod dice;
mod driven;
mod lent;
#[path = "driven/plain.rs"]
mod plain;

use dice::Dice;
use driven::{Driven, Link, MERGINGS, settings};
use plain::Plain;
use slqg::estimator::{Merging, Model, Plausibility};
use slqg::nalgebra::{SMatrix, SVector};
use slqg::{Age, DefaultInput, Scalar, Tick};

/// Outages, in cycles.
const LONGEST: usize = 2000;
/// Cycles that are looked at after an outage.
const AFTER: usize = 100;

type Filter<T, const NX: usize, const NY: usize> = Driven<T, NX, 1, NY, 1, 4>;

/// A plant, a law that stabilises it, and where it is held, in f64.
struct Case<const NX: usize, const NY: usize> {
    model: Model<f64, NX, 1, NY>,
    gain: SMatrix<f64, 1, NX>,
    held: SVector<f64, NX>,
}

impl<const NX: usize, const NY: usize> Case<NX, NY> {
    fn new(model: Model<f64, NX, 1, NY>, held: [f64; NX]) -> Self {
        // The linear-quadratic regulator's, of cost weights one.
        let (a, b) = (model.a, model.b);
        let mut cost = SMatrix::<f64, NX, NX>::identity();
        let mut gain = SMatrix::zeros();
        for _ in 0..2000 {
            let weight = 1.0 + (b.transpose() * cost * b)[0];
            gain = b.transpose() * cost * a / weight;
            let next = a.transpose() * cost * (a - b * gain) + SMatrix::identity();
            cost = (next + next.transpose()) / 2.0;
        }
        Self { model, gain, held: SVector::from(held) }
    }

    fn model<T: Scalar>(&self) -> Model<T, NX, 1, NY> {
        let model = &self.model;
        Model {
            a: model.a.map(T::nearest),
            b: model.b.map(T::nearest),
            c: model.c.map(T::nearest),
            process_noise: model.process_noise.map(T::nearest),
            measurement_noise: model.measurement_noise.map(T::nearest),
            initial_mean: model.initial_mean.map(T::nearest),
            initial_covariance: model.initial_covariance.map(T::nearest),
        }
    }

    fn driven<T: Scalar>(&self, merging: Merging) -> Filter<T, NX, NY> {
        let mut link = Link::new(self.model(), &[0.7], settings(DefaultInput::Zero, None));
        // As designs have it that say nothing of it.
        link.plausibility =
            Plausibility { gate: Some(T::nearest(1e4)), doubt_after: 8, ..Plausibility::NONE };
        link.driven(merging, 3, Tick(0))
    }

    fn measured(&self, state: &SVector<f64, NX>, dice: &mut Dice) -> SVector<f64, NY> {
        let noise = self.model.measurement_noise.diagonal();
        self.model.c * state + noise.map(|variance: f64| (dice.roll() - 0.5) * (12.0 * variance).sqrt())
    }

    /// What the plant costs after an outage, with `decide` told what is measured and deciding what is applied.
    fn cost(&self, mut decide: impl FnMut(SVector<f64, NY>) -> f64) -> f64 {
        let mut dice = Dice(0xC057);
        let mut state = self.held;
        let mut cost = 0.0;
        for _ in 0..AFTER {
            let input = decide(self.measured(&state, &mut dice));
            cost += state.norm_squared() + input * input;
            state = self.model.a * state + self.model.b * input;
        }
        cost
    }

    /// Of an estimator that is told when the outage ends, and knows nothing of the state then.
    fn cost_of_the_best(&self) -> f64 {
        let mut plain = Plain::new(&self.model);
        plain.mean = SVector::zeros();
        plain.covariance = SMatrix::identity() * 1e2;
        let mut input = None;
        self.cost(|output| {
            if let Some(input) = input {
                plain.predict(&self.model, input);
            }
            plain.update(&self.model, output);
            let decided = -(self.gain * plain.mean)[0];
            input = Some(SVector::from([decided]));
            decided
        })
    }

    /// The largest share by which an outage of one of `lengths` costs more than the best, and its length; `hears` says whether
    /// acknowledgements come while it lasts.
    fn dearest<T: Scalar>(
        &self,
        merging: Merging,
        hears: bool,
        lengths: impl Iterator<Item = usize>,
    ) -> (f64, usize) {
        let best = self.cost_of_the_best();
        let mut worst = (0.0, 0);
        for length in lengths {
            let share = self.cost_after::<T>(merging, hears, length).0 / best;
            if share.is_nan() || share > worst.0 {
                worst = (share, length);
            }
        }
        worst
    }

    /// What the loop costs once it is let go after `length` cycles, and how often its estimate began anew by then.
    fn cost_after<T: Scalar>(&self, merging: Merging, hears: bool, length: usize) -> (f64, u32) {
        let mut driven = self.driven::<T>(merging);
        for _ in 0..length {
            self.end(&mut driven, hears.then_some(Age::Empty));
        }
        let anew = driven.filter.begun_anew();
        let cost = self.cost(|output| {
            driven.filter.measure(driven.filter.tick(), output.map(T::nearest)).expect("in time");
            self.end(&mut driven, Some(Age::Steps(0)))
        });
        (cost, anew)
    }

    /// Decides and ends a cycle, perhaps told what was played in it.
    fn end<T: Scalar>(&self, driven: &mut Filter<T, NX, NY>, played: Option<Age>) -> f64 {
        driven.filter();
        let estimate = driven.filter.posterior_mean().map(T::widen);
        let input = T::nearest(-(self.gain * estimate)[0]);
        driven.advance(Some([SVector::from([input])]));
        if let Some(age) = played {
            assert!(driven.filter.acknowledge(driven.filter.tick() - 1, age));
        }
        input.widen()
    }
}

/// The pendulum on a cart of the thesis, 20 ms: an unstable mode that grows by 1.15 a cycle.
fn pendulum() -> Case<4, 2> {
    let sample_time = 0.02;
    let a = SMatrix::<f64, 4, 4>::new(
        0.0,
        1.0,
        0.0,
        0.0, //
        0.0,
        -0.17894736842105263,
        7.744736842105263,
        0.0, //
        0.0,
        0.0,
        0.0,
        1.0, //
        0.0,
        -0.5263157894736842,
        51.63157894736842,
        0.0,
    ) * sample_time;
    let b = SVector::<f64, 4>::new(0.0, 1.7894736842105263, 0.0, 5.2631578947368425) * sample_time;
    let (mut power, mut transition, mut integral) =
        (SMatrix::<f64, 4, 4>::identity(), SMatrix::zeros(), SMatrix::zeros());
    for order in 0..30 {
        transition += power;
        integral += power / f64::from(order + 1);
        power = power * a / f64::from(order + 1);
    }
    let noise = [2.5e-5, 3.046174197867086e-6];
    let model = Model {
        a: transition,
        b: integral * b,
        c: SMatrix::<f64, 2, 4>::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0),
        process_noise: SMatrix::from_diagonal(&SVector::from([noise[0], 0.0, noise[1], 0.0])),
        measurement_noise: SMatrix::from_diagonal(&SVector::from(noise)),
        initial_mean: SVector::from([0.0, 0.2, 0.0, 0.2]),
        initial_covariance: SMatrix::from_diagonal(&SVector::from([1e-4, 0.0, 1e-4, 0.0])),
    };
    Case::new(model, [0.1, 0.0, 0.02, 0.0])
}

/// Position and speed, of which the position is measured; `growth` is the speed's own per cycle.
fn cart(growth: f64) -> Case<2, 1> {
    let model = Model {
        a: SMatrix::<f64, 2, 2>::new(1.0, 0.1, 0.0, growth),
        b: SVector::from([0.005, 0.1]),
        c: SMatrix::<f64, 1, 2>::new(1.0, 0.0),
        process_noise: SMatrix::from_diagonal_element(1e-4),
        measurement_noise: SMatrix::from_element(1e-3),
        initial_mean: SVector::zeros(),
        initial_covariance: SMatrix::identity() * 0.1,
    };
    Case::new(model, [1.0, 0.0])
}

/// After no outage does the loop cost more than `most` times the best, and single precision as much as double.
///
/// Above one is what the model says and the hand that holds the plant does not do: that the state moved on meanwhile.
fn nothing_is_lost<const NX: usize, const NY: usize>(case: &Case<NX, NY>, most: f64) {
    for merging in MERGINGS {
        for hears in [true, false] {
            // Every length where it is quick.
            let step = if merging == Merging::Single && !hears { 1 } else { 23 };
            let lengths = || (1..=LONGEST).step_by(step);
            let single = case.dearest::<f32>(merging, hears, lengths());
            let double = case.dearest::<f64>(merging, hears, lengths());
            for (found, length) in [single, double] {
                assert!(
                    found < most,
                    "{merging:?}, acknowledged {hears}: {found} times the best after {length}"
                );
            }
            let difference = (single.0 / double.0 - 1.0).abs();
            // Estimates begin anew after other lengths, so that only the dearest of all are alike.
            assert!(step > 1 || difference < 0.01, "{merging:?}, {hears}: {single:?} {double:?}");
        }
    }
}

const PAGE: &str = include_str!("../../../docs/outages.md");

#[test]
fn the_page_shows_what_outages_cost() {
    let case = pendulum();
    let lines = [1, 5, 10, 20, 40, 58, 80, 100, 150, 200, 500, 1000, 2000].map(|length| {
        let single = case.cost_after::<f32>(Merging::Single, false, length);
        let double = case.cost_after::<f64>(Merging::Single, false, length);
        format!("{length} {:.3} {:.3} {} {}", single.0, double.0, single.1, double.1)
    });
    let best = format!("costs {:.3}.", case.cost_of_the_best());
    lines.iter().chain([&best]).for_each(|line| println!("{line}"));
    for line in &lines {
        let is_shown = PAGE.lines().any(|other| other.split_whitespace().eq(line.split_whitespace()));
        assert!(is_shown, "not in docs/outages.md: {line}");
    }
    assert!(PAGE.contains(&best), "not in docs/outages.md: {best}");
}

#[test]
fn a_pendulum_is_caught_after_an_outage_of_any_length() {
    nothing_is_lost(&pendulum(), 4.0);
}

#[test]
fn a_cart_is_caught_after_an_outage_of_any_length() {
    nothing_is_lost(&cart(0.9), 1.2);
    nothing_is_lost(&cart(1.0), 1.2);
    nothing_is_lost(&cart(1.3), 50.0);
}

#[test]
fn a_plant_that_grows_by_thirty_a_cycle_is_caught_after_an_outage_of_any_length() {
    nothing_is_lost(&cart(30.0), 15.0);
}
