//! The estimator for loops without acknowledgements that no data change: what it expects, against every age weighed.
#![cfg(feature = "linear")]

#[path = "random/dice.rs"]
mod dice;
mod double_integrator;
mod lent;
mod trigger_bench;

use dice::Dice;
use double_integrator::{LATE, LENGTH, Node, Workshop};
use slqg::actuator::{Limits, Settings};
use slqg::controller::{Design, InvalidDesign, RejectedFrame, Sizes};
use slqg::estimator::Merging;
use slqg::nalgebra::SVector;
use slqg::wire::{Acknowledgement, Measurement};
use slqg::{Age, DefaultInput, Scalar, Tick};
use trigger_bench::{BOTH, Bench};

const CYCLES: u32 = 300;

fn settings<T: Scalar>(default_input: DefaultInput, limit: Option<f64>) -> Settings<T, 1> {
    let limits = limit.map(|limit| {
        let bound = SVector::from([T::nearest(limit)]);
        Limits { min: -bound, max: bound, rate: None }
    });
    Settings { default_input, limits, safe: None }
}

fn node<'a, T: Scalar>(workshop: &'a Workshop<T>, merging: Merging) -> Node<'a, T> {
    lent::controller(Design { merging, ..workshop.design() }, Tick(0)).expect("a fitting design")
}

/// The same sequences, sent and kept back alike, for both.
fn expects_what_weighing_every_age_gives<T: Scalar>(tolerance: f64) {
    for (default_input, limit) in BOTH.into_iter().flat_map(|default| [(default, None), (default, Some(0.6))])
    {
        let workshop = Workshop::<T>::double_integrator(settings(default_input, limit));
        let (mut linear, mut single) = (node(&workshop, Merging::Linear), node(&workshop, Merging::Single));
        let mut dice = Dice(7);
        let near = |one: &SVector<T, 1>, other: &SVector<T, 1>| {
            (one[0].widen() - other[0].widen()).abs() < tolerance
        };
        let mut largest = 0.0_f64;
        for cycle in 0..CYCLES {
            let expected = [linear.propose().expected.to_vec(), single.propose().expected.to_vec()];
            assert_eq!(expected[0].len(), default_input.in_flight(LENGTH));
            for (mean, weighed) in expected[0].iter().zip(&expected[1]) {
                assert!(near(mean, weighed), "{default_input:?}, {limit:?}, cycle {cycle}: {mean} {weighed}");
                largest = largest.max(mean[0].widen().abs());
            }
            if let Some(last) = cycle.checked_sub(1) {
                let inputs = [linear.expected_input(Tick(last)), single.expected_input(Tick(last))];
                let [mean, weighed] = inputs.map(|input| input.expect("it is over"));
                assert!(
                    near(&mean, &weighed),
                    "{default_input:?}, {limit:?}, cycle {last}: {mean} {weighed}"
                );
            }
            let inputs: Vec<_> =
                (0..LENGTH).map(|_| SVector::from([T::nearest(dice.roll() * 2.0 - 1.0)])).collect();
            let is_sent = dice.roll() > 0.2;
            // What leaves the actuator is what counts.
            let saturated: Vec<_> = inputs.iter().map(|input| workshop.settings.saturate(input)).collect();
            for (controller, inputs) in [(&mut linear, &inputs), (&mut single, &saturated)] {
                controller.replace(inputs).expect("finite");
                controller.commit(is_sent);
            }
        }
        assert!(largest > 0.3, "something was expected");
    }
}

#[test]
fn it_expects_what_weighing_every_age_gives_in_f64() {
    expects_what_weighing_every_age_gives::<f64>(1e-13);
}

#[test]
fn it_expects_what_weighing_every_age_gives_in_f32() {
    expects_what_weighing_every_age_gives::<f32>(2e-6);
}

#[test]
fn over_a_link_that_loses_nothing_it_is_the_kalman_filter_whatever_is_late() {
    let workshop = Workshop::<f64>::double_integrator(settings(DefaultInput::Hold, None));
    let of = |merging| {
        let design = Design { merging, arrives_at_once: 1.0, ..workshop.design() };
        lent::controller(design, Tick(0)).expect("a fitting design")
    };
    let (mut linear, mut single) = (of(Merging::Linear), of(Merging::Single));
    let mut dice = Dice(3);
    let mut late: Vec<Measurement<f64, 1>> = vec![];
    for cycle in 0..CYCLES {
        late.push(Measurement { tick: Tick(cycle), output: SVector::from([dice.roll()]) });
        for _ in 0..2 {
            let place = (dice.roll() * late.len() as f64) as usize;
            if dice.roll() < 0.6 && !late.is_empty() {
                let measurement = late.swap_remove(place);
                let taken = [linear.measured(&measurement), single.measured(&measurement)];
                assert_eq!(taken[0], taken[1]);
            }
        }
        late.retain(|measurement| Tick(cycle).age_of(measurement.tick) < Some(LATE as u32));
        let sequences =
            [linear.propose().sequence.inputs.to_vec(), single.propose().sequence.inputs.to_vec()];
        assert_eq!(sequences[0], sequences[1], "to the bit");
        assert_eq!(linear.estimator().posterior(), single.estimator().posterior(), "to the bit");
        linear.commit(true);
        single.commit(true);
    }
}

#[test]
fn it_takes_no_acknowledgement() {
    let workshop = Workshop::<f32>::double_integrator(settings(DefaultInput::Zero, None));
    let mut linear = node(&workshop, Merging::Linear);
    linear.propose();
    linear.commit(true);
    for age in [Age::Steps(0), Age::Empty] {
        let told = linear.acknowledged(&Acknowledgement::of(Tick(0), age));
        assert_eq!(told, Err(RejectedFrame::Acknowledgement));
    }
}

#[test]
fn it_begins_anew_as_one_that_has_just_been_made() {
    let workshop = Workshop::<f64>::double_integrator(settings(DefaultInput::Hold, None));
    let design = Design { merging: Merging::Linear, ..workshop.design() };
    let (mut used, mut new) = (node(&workshop, Merging::Linear), node(&workshop, Merging::Linear));
    for cycle in 0..20 {
        used.measured(&Measurement { tick: Tick(cycle), output: SVector::from([1.0]) }).expect("in time");
        used.propose();
        used.commit(true);
    }
    used.restart(design, Tick(0)).expect("the same design");
    for cycle in 0..20 {
        for controller in [&mut used, &mut new] {
            let output = SVector::from([f64::from(cycle).sin()]);
            controller.measured(&Measurement { tick: Tick(cycle), output }).expect("in time");
        }
        assert_eq!(used.propose().sequence, new.propose().sequence);
        used.commit(cycle % 3 > 0);
        new.commit(cycle % 3 > 0);
    }
}

#[test]
fn a_trigger_does_not_go_with_it() {
    let bench = Bench::<f64>::new(DefaultInput::Zero);
    assert_eq!(bench.workshop.settings.default_input, DefaultInput::Zero);
    let design = Design { merging: Merging::Linear, ..bench.design(Some(bench.trigger(1.0))) };
    assert_eq!(lent::controller(design, Tick(0)).err(), Some(InvalidDesign::Linear));
}

#[test]
fn it_takes_less_memory_than_one_that_weighs_ages() {
    let (linear, single) = (Sizes::linear(8, 12), Sizes::of(8, 12, 1));
    assert_eq!((linear.ages, linear.sent), (0, 2));
    assert_eq!((linear.cycles, linear.estimates), (single.cycles, single.estimates));
    assert!(linear.inputs * 2 < single.inputs, "{} {}", linear.inputs, single.inputs);
}
