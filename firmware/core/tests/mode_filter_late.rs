//! Ages that become known late, or by measurements alone.

#[path = "random/dice.rs"]
mod dice;
mod driven;
mod lent;
mod mixture;
#[path = "driven/plain.rs"]
mod plain;
#[path = "random/shuffle.rs"]
mod shuffle;

use dice::Dice;
use driven::{Driven, Link, MERGINGS, settings};
use mixture::{BOTH, LENGTH, Scenario};
use plain::{Plain, agree};
use shuffle::shuffle;
use slqg::estimator::{Merging, Model};
use slqg::nalgebra::{SMatrix, SVector};
use slqg::{Age, DefaultInput, Scalar, Tick};

type Filter<T> = Driven<T, 2, 1, 1, LENGTH, 8>;
const START: Tick = Tick(u32::MAX - 8);
/// Cycles of a random history.
const CYCLES: usize = 20;
/// Most cycles a measurement may be late; an acknowledgement one less beyond the cycle after.
const LATE: usize = 6;

/// When each cycle's measurement and acknowledgement arrive, if ever.
struct Arrivals {
    outputs: Vec<Option<usize>>,
    acknowledgements: Vec<Option<usize>>,
}

impl Arrivals {
    fn new(dice: &mut Dice) -> Self {
        let mut late = |at: usize, most: usize| {
            let late = (dice.roll() * (most + 1) as f64) as usize;
            (dice.roll() < 0.7).then_some(at + late)
        };
        Self {
            outputs: (0..=CYCLES).map(|at| late(at, LATE)).collect(),
            acknowledgements: (0..CYCLES).map(|at| late(at + 1, LATE - 1)).collect(),
        }
    }
}

/// The filter that is given in time whatever has arrived by cycle `now`.
fn told_in_time<T: Scalar>(
    scenario: &Scenario<T>,
    merging: Merging,
    arrivals: &Arrivals,
    now: usize,
) -> Filter<T> {
    let mut driven: Filter<T> = scenario.link.driven(merging, LATE, START);
    let has_arrived = |at: Option<usize>| at.is_some_and(|at| at <= now);
    for at in 0..=now {
        if has_arrived(arrivals.outputs[at]) {
            driven.filter.measure(START + at as u32, scenario.outputs[at]).expect("in time");
        }
        if at > 0 && has_arrived(arrivals.acknowledgements[at - 1]) {
            driven.filter.acknowledge(START + (at - 1) as u32, scenario.applied[at - 1].age);
        }
        driven.filter();
        if at < now {
            driven.advance(scenario.sent[at]);
        }
    }
    driven
}

/// `strict` rejects half of what is measured, and soon doubts the estimate.
fn order_does_not_matter<T: Scalar>(strict: bool) {
    let mut dice = Dice(0xACE5);
    for round in 0..40 {
        let mut scenario = Scenario::<T>::new(&mut dice, BOTH[round % 2], CYCLES);
        if strict {
            scenario.link.plausibility.gate = Some(T::nearest(0.3));
            scenario.link.plausibility.doubt_after = 2;
        }
        let arrivals = Arrivals::new(&mut dice);
        for merging in MERGINGS {
            let mut driven: Filter<T> = scenario.link.driven(merging, LATE, START);
            for now in 0..=CYCLES {
                let mut arriving: Vec<(usize, bool)> =
                    (0..=now).flat_map(|at| [(at, false), (at, true)]).collect();
                shuffle(&mut dice, &mut arriving);
                for (at, is_output) in arriving {
                    let tick = START + at as u32;
                    if is_output && arrivals.outputs[at] == Some(now) {
                        assert_eq!(driven.filter.measure(tick, scenario.outputs[at]), Ok(()));
                    } else if !is_output && at < CYCLES && arrivals.acknowledgements[at] == Some(now) {
                        assert!(driven.filter.acknowledge(tick, scenario.applied[at].age));
                        // Said twice is as good as once.
                        assert!(driven.filter.acknowledge(tick, scenario.applied[at].age));
                    }
                    // Filtering early, with half of what arrives in this cycle, must not matter either.
                    if dice.roll() < 0.1 {
                        driven.filter();
                    }
                }
                driven.filter();
                let in_time = told_in_time::<T>(&scenario, merging, &arrivals, now);
                assert_eq!(driven.bits(), in_time.bits(), "cycle {now} with {merging:?}");
                if now < CYCLES {
                    driven.advance(scenario.sent[now]);
                }
            }
        }
    }
}

#[test]
fn acknowledgements_and_measurements_late_and_shuffled_give_the_same_bits_as_in_time() {
    order_does_not_matter::<f32>(false);
    order_does_not_matter::<f64>(false);
}

#[test]
fn whether_a_measurement_is_believed_does_not_depend_on_when_others_arrive() {
    order_does_not_matter::<f32>(true);
    order_does_not_matter::<f64>(true);
}

#[test]
fn once_all_ages_in_memory_are_known_the_estimate_is_the_kalman_filter_again() {
    let mut dice = Dice(0xACE5);
    for round in 0..40 {
        let scenario = Scenario::<f32>::new(&mut dice, BOTH[round % 2], LATE);
        let model = &scenario.link.model;
        for merging in MERGINGS {
            let mut driven: Filter<f32> = scenario.link.driven(merging, LATE, START);
            let mut plain = Plain::new(model);
            plain.update(model, scenario.outputs[0]);
            for at in 0..LATE {
                driven.filter.measure(START + at as u32, scenario.outputs[at]).expect("in time");
                driven.advance(scenario.sent[at]);
                plain.predict(model, scenario.applied[at].input);
                plain.update(model, scenario.outputs[at + 1]);
            }
            driven.filter.measure(START + LATE as u32, scenario.outputs[LATE]).expect("in time");
            for at in (0..LATE).rev() {
                assert!(driven.filter.acknowledge(START + at as u32, scenario.applied[at].age));
            }
            driven.filter();
            let found: Vec<f64> = driven.numbers().into_iter().map(f64::from).collect();
            assert!(agree(&found, &plain.numbers(), 1e-5), "{merging:?}: {found:?}");
        }
    }
}

/// Position and speed, pushed by the input; only the position is measured, and shows an input no sooner than two
/// cycles later.
fn cart() -> Model<f64, 2, 1, 1> {
    Model {
        a: SMatrix::from([[1.0, 0.0], [0.1, 1.0]]),
        b: SMatrix::from([[0.0, 0.1]]),
        c: SMatrix::from([[1.0], [0.0]]),
        process_noise: SMatrix::from_diagonal_element(1e-6),
        measurement_noise: SMatrix::from([[1e-4]]),
        initial_mean: SVector::zeros(),
        initial_covariance: SMatrix::identity() * 1e-4,
    }
}

#[test]
fn an_input_that_shows_in_the_measurements_tells_the_age_that_was_played() {
    let both = |merging| [(merging, true), (merging, false)];
    for (merging, arrives) in [Merging::Imm, Merging::Gpb2].into_iter().flat_map(both) {
        let model = cart();
        // At once or never.
        let link = Link::new(model.clone(), &[0.5], settings(DefaultInput::Zero, None));
        let mut driven: Filter<f64> = link.driven(merging, LATE, Tick(0));
        let mut state = SVector::<f64, 2>::zeros();
        // One sequence in cycle 0: what is played in cycle 1 tells whether it arrived, and is measured in cycle 3.
        let inputs = [30.0, 30.0, 30.0];
        for now in 0..4 {
            driven.filter.measure(Tick(now), model.c * state).expect("in time");
            driven.filter();
            let found = driven.filter.modes().expect("filtered");
            let age = if arrives && now > 0 { Age::Steps(now as u8 - 1) } else { Age::Empty };
            match now {
                1 => assert_eq!(found.probability(age), 0.5),
                3 => assert!(found.probability(age) > 0.99, "{merging:?}, {arrives}: {found:?}"),
                _ => (),
            }
            driven.advance((now == 0).then_some(inputs.map(|input| SVector::from([input]))));
            let input = if arrives && now < 3 { inputs[now as usize] } else { 0.0 };
            state = model.a * state + model.b * input;
        }
    }
}

/// Mean of the squared error of the position and speed, over long runs without any acknowledgement.
fn mean_error(merging: Merging) -> f64 {
    let model = cart();
    let mut dice = Dice(0xACE5);
    let (mut sum, cycles) = (0.0, 4000);
    let mut scenario = Scenario::<f64>::new(&mut dice, DefaultInput::Zero, cycles);
    let delays = [0.5, 0.2, 0.1];
    scenario.on(Link::new(model, &delays, settings(DefaultInput::Zero, None)), &delays, &mut dice);
    let mut driven: Filter<f64> = scenario.link.driven(merging, LATE, START);
    for now in 0..cycles {
        driven.filter.measure(START + now as u32, scenario.outputs[now]).expect("in time");
        driven.filter();
        sum += (driven.filter.posterior_mean() - scenario.states[now]).norm_squared();
        driven.advance(scenario.sent[now]);
    }
    sum / cycles as f64
}

#[test]
fn the_more_ages_are_kept_apart_the_better_the_estimate_without_acknowledgements() {
    let [single, imm, gpb2] = MERGINGS.map(mean_error);
    assert!(imm < 0.98 * single && gpb2 < 0.98 * imm, "{single} {imm} {gpb2}");
}
