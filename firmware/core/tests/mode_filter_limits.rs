//! What would break the numbers of probabilities: measurements nobody expects, none for long, and lies.

#[path = "random/dice.rs"]
mod dice;
mod driven;
mod lent;

use dice::Dice;
use driven::{Driven, Link, MERGINGS, settings};
use slqg::estimator::{Merging, Model};
use slqg::nalgebra::{SMatrix, SVector};
use slqg::{Age, DefaultInput, Scalar, Tick};

const LENGTH: usize = 3;
const DELAYS: [f64; LENGTH] = [0.5, 0.2, 0.1];
const BOTH: [DefaultInput; 2] = [DefaultInput::Zero, DefaultInput::Hold];
/// Measurements that are late by one cycle still count.
type Filter<T> = Driven<T, 2, 1, 1, LENGTH, 6>;

/// Position and speed, position measured; `growth` is the factor of the unstable one of the two per cycle.
fn model<T: Scalar>(growth: f64) -> Model<T, 2, 1, 1> {
    Model {
        a: SMatrix::<f64, 2, 2>::from([[growth, 0.0], [0.1, 1.0]]).map(T::nearest),
        b: SMatrix::<f64, 2, 1>::from([[0.005, 0.1]]).map(T::nearest),
        c: SMatrix::<f64, 1, 2>::from([[1.0], [0.0]]).map(T::nearest),
        process_noise: SMatrix::from_diagonal_element(T::nearest(0.01)),
        measurement_noise: SMatrix::from_element(T::nearest(0.01)),
        initial_mean: SVector::zeros(),
        initial_covariance: SMatrix::identity(),
    }
}

fn filter<T: Scalar>(growth: f64, merging: Merging, default_input: DefaultInput) -> Filter<T> {
    Link::new(model(growth), &DELAYS, settings(default_input, None)).driven(merging, 1, Tick(0))
}

fn some_inputs<T: Scalar>(dice: &mut Dice, size: f64) -> [SVector<T, 1>; LENGTH] {
    [(); LENGTH].map(|()| SVector::from([T::nearest((dice.roll() - 0.5) * size)]))
}

/// Calls `check` with every merging, default input and scalar type that there is.
macro_rules! everywhere {
    ($check:ident) => {
        for merging in MERGINGS {
            for default_input in BOTH {
                $check::<f32>(merging, default_input);
                $check::<f64>(merging, default_input);
            }
        }
    };
}

fn far_off_measurements_are_survived<T: Scalar>(merging: Merging, default_input: DefaultInput) {
    // The standard deviation of what is expected is below one.
    for far in [1e6, -1e6, 1e12, 1e30, T::max_value().unwrap_or_else(T::one).widen(), 0.0] {
        let mut dice = Dice(0xFA12);
        let mut driven = filter::<T>(1.0, merging, default_input);
        for cycle in 0..30 {
            let output = if cycle == 10 || cycle == 12 { T::nearest(far) } else { T::zero() };
            driven.filter.measure(Tick(cycle), SVector::from([output])).expect("finite");
            driven.filter();
            assert!(driven.is_sound(), "{far} in cycle {cycle}: {driven:?}");
            driven.advance(Some(some_inputs(&mut dice, 10.0)));
        }
    }
}

#[test]
fn measurements_a_million_deviations_off_leave_probabilities_that_sum_to_one() {
    everywhere!(far_off_measurements_are_survived);
}

#[test]
fn of_two_ages_that_explain_a_measurement_absurdly_badly_the_better_one_is_believed() {
    for merging in [Merging::Imm, Merging::Gpb2] {
        let link = Link::new(model::<f64>(1.0), &[0.5], settings(DefaultInput::Zero, None));
        let mut driven: Filter<f64> = link.driven(merging, 1, Tick(0));
        driven.advance(Some([SVector::from([1e7]); LENGTH]));
        driven.advance(None);
        // Neither explanation has a likelihood that is not zero but for its logarithm: the position would be 0 or 1e5.
        driven.filter.measure(Tick(2), SVector::from([1e9])).expect("finite");
        driven.filter();
        assert!(driven.filter.modes().expect("filtered").probability(Age::Steps(1)) > 0.99, "{driven:?}");
    }
}

#[test]
fn an_age_that_a_measurement_rules_out_takes_its_estimate_with_it() {
    for merging in [Merging::Imm, Merging::Gpb2] {
        let link = Link::new(model::<f64>(1.0), &[0.5], settings(DefaultInput::Zero, None));
        let mut driven: Filter<f64> = link.driven(merging, 1, Tick(0));
        driven.advance(Some([SVector::from([1e7]); LENGTH]));
        driven.filter.measure(Tick(1), SVector::from([0.0])).expect("finite");
        driven.filter();
        assert_eq!(driven.probabilities(), [0.0, 0.0, 0.0, 1.0]);
        assert!(driven.filter.posterior_mean().norm() < 1.0, "{}", driven.filter.posterior_mean());
    }
}

fn silence_is_survived<T: Scalar>(merging: Merging, default_input: DefaultInput) {
    for growth in [1.0, 1.1] {
        let mut dice = Dice(0x511E);
        let mut driven = filter::<T>(growth, merging, default_input);
        for cycle in 0..5000 {
            driven.filter();
            assert!(driven.is_sound(), "cycle {cycle}: {driven:?}");
            driven.advance((dice.roll() < 0.8).then(|| some_inputs(&mut dice, 1e3)));
        }
    }
}

#[test]
fn five_thousand_cycles_without_measurement_or_acknowledgement_leave_probabilities_that_sum_to_one() {
    everywhere!(silence_is_survived);
}

fn inputs_of_any_size_are_survived<T: Scalar>(merging: Merging, default_input: DefaultInput) {
    let mut dice = Dice(0x1A26E);
    let most = T::max_value().unwrap_or_else(T::one).widen();
    let mut driven = filter::<T>(1.1, merging, default_input);
    for cycle in 0..300 {
        let size = most * if dice.roll() < 0.5 { 1.0 } else { dice.roll() * 1e-9 };
        if dice.roll() < 0.5 {
            driven.filter.measure(Tick(cycle), SVector::from([T::nearest(dice.roll())])).expect("finite");
        }
        driven.filter();
        assert!(driven.is_sound(), "cycle {cycle}: {driven:?}");
        driven.advance(Some(some_inputs(&mut dice, size)));
    }
}

#[test]
fn ages_whose_inputs_are_too_far_apart_to_merge_leave_no_bad_number() {
    everywhere!(inputs_of_any_size_are_survived);
}

fn lies_are_survived<T: Scalar>(merging: Merging, default_input: DefaultInput) {
    let mut dice = Dice(0x11E5);
    let mut driven = filter::<T>(1.1, merging, default_input);
    for cycle in 0..500 {
        if dice.roll() < 0.7 {
            let output = SVector::from([T::nearest(dice.roll())]);
            driven.filter.measure(Tick(cycle), output).expect("in time");
        }
        for ago in 1..3 {
            if dice.roll() < 0.5 {
                // Any age at all, sent or not, possible after the one before or not.
                let age = dice.delay(&[0.18; 5]).map_or(Age::Empty, |age| Age::Steps(age as u8));
                driven.filter.acknowledge(Tick(cycle) - ago, age);
            }
        }
        driven.filter();
        assert!(driven.is_sound(), "cycle {cycle}: {driven:?}");
        driven.advance((dice.roll() < 0.8).then(|| some_inputs(&mut dice, 1.0)));
    }
}

#[test]
fn acknowledgements_that_contradict_each_other_or_all_that_was_sent_leave_no_bad_number() {
    everywhere!(lies_are_survived);
}

fn a_new_start_is_believed<T: Scalar>(merging: Merging, default_input: DefaultInput) {
    let mut dice = Dice(0x0FF);
    let mut driven = filter::<T>(1.0, merging, default_input);
    for cycle in 0..4u32 {
        driven.advance(Some(some_inputs(&mut dice, 1.0)));
        assert!(driven.filter.acknowledge(Tick(cycle), Age::Steps(0)));
    }
    // Two inputs are left, yet the buffer is empty.
    driven.advance(None);
    assert!(driven.filter.acknowledge(Tick(4), Age::Empty));
    driven.filter();
    assert_eq!(driven.probabilities(), [0.0, 0.0, 0.0, 1.0]);
    driven.advance(None);
    driven.filter();
    // What was sent before may be on its way as far as anyone knows, but what was played is gone.
    assert!(driven.is_sound());
    assert!(driven.filter.modes().expect("filtered").probability(Age::Empty) > T::nearest(0.5));
}

fn a_new_start_after_doubt_is_believed<T: Scalar>(merging: Merging, default_input: DefaultInput) {
    let inputs = [SVector::from([T::nearest(7.0)]); LENGTH];
    let mut driven = filter::<T>(1.0, merging, default_input);
    driven.advance(Some(inputs));
    assert!(driven.filter.acknowledge(Tick(0), Age::Steps(0)));
    driven.advance(Some(inputs));
    driven.filter();
    assert!(driven.filter.modes().expect("filtered").known().is_none());
    driven.advance(None);
    // Two sequences may be playing, and either has an input left.
    assert!(driven.filter.acknowledge(Tick(2), Age::Empty));
    driven.filter();
    assert_eq!(driven.probabilities(), [0.0, 0.0, 0.0, 1.0]);
    let held = driven.expected_input(Tick(2)).expect("filtered")[0].widen();
    let expected = if default_input == DefaultInput::Hold { 7.0 } else { 0.0 };
    assert!((held - expected).abs() < 1e-5, "{held}");
}

#[test]
fn an_actuator_that_was_started_again_in_doubt_holds_what_it_may_have_applied() {
    everywhere!(a_new_start_after_doubt_is_believed);
}

#[test]
fn an_actuator_that_was_started_again_is_believed_to_have_nothing_to_play() {
    everywhere!(a_new_start_is_believed);
}

#[test]
fn merged_covariances_stay_symmetric_and_positive_semidefinite_in_single_precision() {
    for merging in MERGINGS {
        let mut dice = Dice(0x5E3D);
        let mut driven = filter::<f32>(1.05, merging, DefaultInput::Hold);
        for cycle in 0..20_000 {
            if dice.roll() < 0.6 {
                driven.filter.measure(Tick(cycle), SVector::from([dice.roll() as f32])).expect("in time");
            }
            driven.filter();
            let covariance = driven.filter.posterior_covariance();
            assert_eq!(covariance[(0, 1)], covariance[(1, 0)]);
            let eigenvalues = covariance.map(f64::from).symmetric_eigenvalues();
            let slack = 4.0 * f64::from(f32::EPSILON) * eigenvalues.max();
            assert!(eigenvalues.min() >= -slack, "cycle {cycle} with {merging:?}: {covariance}");
            driven.advance(Some(some_inputs(&mut dice, 10.0)));
        }
    }
}
