//! How it is decided what is sent: by send cost, reference and precision.

#[path = "random/dice.rs"]
mod dice;
mod double_integrator;
mod lent;
mod trigger_bench;

use dice::Dice;
use double_integrator::LENGTH;
use slqg::event::Candidate;
use slqg::nalgebra::SVector;
use slqg::played::Played;
use slqg::tracking::Feedforward;
use slqg::wire::{self, Acknowledgement};
use slqg::{Age, DefaultInput, Scalar, Tick};
use trigger_bench::{BOTH, Bench};

const SEND_COST: f64 = 0.3;

#[test]
fn another_send_cost_decides_as_if_it_had_been_the_first() {
    let bench = Bench::<f64>::new(DefaultInput::Zero);
    let trigger = bench.trigger(7.0);
    assert_eq!(trigger.with_send_cost(SEND_COST), bench.trigger(SEND_COST));
    for nothing in [0.0, -1.0, f64::NAN] {
        assert_eq!(trigger.with_send_cost(nothing), bench.trigger(0.0));
    }
}

#[test]
fn what_saves_exactly_its_cost_is_kept_and_what_cannot_be_judged_is_sent() {
    let bench = Bench::<f64>::new(DefaultInput::Zero);
    let trigger = bench.trigger(2.0);
    assert!(!trigger.is_worth_sending(2.0));
    assert!(trigger.is_worth_sending(2.0 + 4.0 * f64::EPSILON));
    assert!(trigger.is_worth_sending(f64::NAN));
    assert!(trigger.with_send_cost(0.0).is_worth_sending(-1.0));
}

/// What one sequence is worth, computed in `T`: for a state and packets sent that are given by `numbers`.
fn benefit<T: Scalar>(bench: &Bench<T>, numbers: &[f64], sent: [bool; LENGTH], age: Age) -> f64 {
    let number = |at: usize| SVector::from([T::nearest(numbers[at])]);
    let mut in_flight = lent::in_flight(LENGTH, LENGTH, Tick(100) - LENGTH as u32);
    for ago in (1..=LENGTH).rev() {
        let inputs: Vec<_> = (0..LENGTH).map(|entry| number(ago * LENGTH + entry)).collect();
        lent::push(&mut in_flight, sent[ago - 1].then_some(&inputs));
    }
    let played = Played::Known(age, number(0));
    let gains = bench.workshop.design().gains;
    let state = SVector::from([T::nearest(numbers[1]), T::nearest(numbers[2])]);
    let expected = lent::expected(&in_flight, &gains, &played);
    let inputs = lent::sequence(&gains, &state, &expected);
    let candidate =
        Candidate { posterior_mean: &state, expected: &expected, inputs: &inputs, displaced: &[], played };
    bench.trigger(0.0).benefit(&gains, &in_flight, &candidate, lent::inputs(LENGTH), &mut []).widen()
}

#[test]
fn single_and_double_precision_decide_alike_unless_it_hardly_matters() {
    let mut dice = Dice(0xD1CE);
    for default_input in BOTH {
        let (single, double) = (Bench::<f32>::new(default_input), Bench::<f64>::new(default_input));
        let mut decided = [0; 2];
        for _ in 0..2000 {
            // The same numbers in both.
            let numbers: Vec<f64> =
                (0..LENGTH * (LENGTH + 1)).map(|_| f64::from((dice.roll() * 2.0 - 1.0) as f32)).collect();
            let mut sent = [(); LENGTH].map(|()| dice.roll() < 0.7);
            let age = (dice.roll() * (LENGTH + 1) as f64) as usize;
            let age = if age < LENGTH { Age::Steps(age as u8) } else { Age::Empty };
            if let Some(steps) = age.steps() {
                sent[steps] = true;
            }
            let found = benefit(&single, &numbers, sent, age);
            let exact = benefit(&double, &numbers, sent, age);
            let send_cost = 0.2 + dice.roll();
            if (exact - send_cost).abs() > 1e-4 * send_cost {
                let decides = double.trigger(send_cost).is_worth_sending(exact);
                assert_eq!(
                    single.trigger(send_cost).is_worth_sending(found as f32),
                    decides,
                    "{found} for {exact}"
                );
                decided[usize::from(decides)] += 1;
            }
        }
        assert!(decided.iter().all(|count| *count > 200), "{decided:?}");
    }
}

#[test]
fn the_decision_is_about_the_sequence_with_its_feedforward_and_what_it_displaces() {
    for default_input in BOTH {
        let bench = Bench::<f64>::new(default_input);
        let (trigger, gains) = (bench.trigger(SEND_COST), bench.workshop.design().gains);
        let mut controller =
            lent::controller(bench.design(Some(trigger)), Tick(0)).expect("a fitting design");
        let mut actuator = lent::actuator(bench.workshop.settings, Tick(0), LENGTH);
        let mut in_flight = lent::in_flight(LENGTH, LENGTH, Tick(0));
        let mut played = Played::nothing();
        let mut dice = Dice(0xD1CE);
        let (mut decided, mut otherwise) = ([0; 2], 0);
        for tick in 0..400 {
            let mut numbers =
                |count| (0..count).map(|_| SVector::from([dice.roll() * 8.0 - 4.0])).collect::<Vec<_>>();
            let (added, displaced) = (numbers(LENGTH), numbers(gains.in_flight()));
            let feedforward = Feedforward { inputs: &added, displaced: &displaced };
            controller.set_feedforward(feedforward).expect("finite");
            let mut buffer = [0; 64];
            let frame = controller.cycle(&mut buffer).expect("there is room");

            let state = controller.estimator().posterior_mean();
            let expected = lent::expected(&in_flight, &gains, &played);
            let mut inputs = lent::sequence(&gains, state, &expected);
            inputs.iter_mut().zip(&added).for_each(|(input, added)| *input += added);
            let decides = |displaced| {
                let (expected, inputs) = (&expected[..], &inputs[..]);
                let candidate = Candidate { posterior_mean: state, expected, inputs, displaced, played };
                let mut room = [SVector::zeros(); LENGTH];
                trigger.is_worth_sending(trigger.benefit(&gains, &in_flight, &candidate, &mut room, &mut []))
            };
            assert_eq!(frame.is_some(), decides(&displaced), "cycle {tick}");
            otherwise += u32::from(frame.is_some() != decides(&[]));
            decided[usize::from(frame.is_some())] += 1;

            // Half of the packets arrive, all at once.
            lent::push(&mut in_flight, frame.map(|_| &inputs[..]));
            if let Some(frame) = frame.filter(|_| dice.delay(&[0.5]).is_some()) {
                actuator.receive(frame).expect("newer than the last");
            }
            let applied = actuator.step();
            played = Played::Known(applied.age, applied.input);
            let acknowledgement = Acknowledgement::of(applied.tick, applied.age);
            let frame =
                wire::encode_acknowledgement::<f64>(&acknowledgement, &mut buffer).expect("there is room");
            controller.receive(frame).expect("of use");
        }
        assert!(decided.iter().all(|count| *count > 30) && otherwise > 10, "{decided:?} {otherwise}");
    }
}
