//! How it is decided what is sent: by send cost, reference and precision.

#[path = "random/dice.rs"]
mod dice;
mod double_integrator;
mod trigger_bench;

use dice::Dice;
use double_integrator::{LENGTH, Node};
use slqg::actuator::{Actuator, Age};
use slqg::event::Candidate;
use slqg::in_flight::InFlight;
use slqg::nalgebra::SVector;
use slqg::tracking::Feedforward;
use slqg::wire::{self, Acknowledgement};
use slqg::{DefaultInput, Tick, sequence::ControlSequence};
use trigger_bench::{BOTH, Bench, Judge};

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
fn benefit<T: Judge>(bench: &Bench<T>, numbers: &[f64], sent: [bool; LENGTH], age: Age) -> f64 {
    let number = |at: usize| SVector::from([T::nearest(numbers[at])]);
    let mut in_flight = InFlight::<T, 1, 6, 1>::default();
    for ago in (1..=LENGTH).rev() {
        let inputs = (0..LENGTH).map(|entry| number(ago * LENGTH + entry)).collect();
        in_flight.push(sent[ago - 1].then_some(ControlSequence { tick: Tick(100) - ago as u32, inputs }));
    }
    in_flight.acknowledge(age, number(0));
    let gains = bench.workshop.design().gains;
    let state = SVector::from([T::nearest(numbers[1]), T::nearest(numbers[2])]);
    let expected = in_flight.expected_inputs(&gains);
    let inputs = gains.sequence::<6>(&state, &expected);
    let candidate =
        Candidate { posterior_mean: &state, expected: &expected, inputs: &inputs, displaced: &[] };
    bench.trigger(0.0).benefit(&gains, &in_flight, candidate).widen()
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
        let mut controller = Node::new(bench.design(Some(trigger)), Tick(0)).expect("a fitting design");
        let mut actuator = Actuator::<f64, 1, 6>::new(bench.workshop.settings, Tick(0));
        let mut in_flight = InFlight::<f64, 1, 6, 1>::default();
        let mut dice = Dice(0xD1CE);
        let (mut decided, mut otherwise) = ([0; 2], 0);
        for tick in 0..400 {
            let mut numbers = |count| (0..count).map(|_| SVector::from([dice.roll() * 8.0 - 4.0])).collect();
            let feedforward = Feedforward { inputs: numbers(LENGTH), displaced: numbers(gains.in_flight()) };
            controller.set_feedforward(feedforward.clone()).expect("finite");
            let mut buffer = [0; 64];
            let frame = controller.cycle(&mut buffer).expect("there is room");

            let (state, expected) =
                (controller.estimator().posterior_mean(), in_flight.expected_inputs(&gains));
            let mut inputs = gains.sequence::<6>(state, &expected);
            feedforward.add_to(&mut inputs);
            let decides = |displaced| {
                let candidate =
                    Candidate { posterior_mean: state, expected: &expected, inputs: &inputs, displaced };
                trigger.is_worth_sending(trigger.benefit(&gains, &in_flight, candidate))
            };
            assert_eq!(frame.is_some(), decides(&feedforward.displaced), "cycle {tick}");
            otherwise += u32::from(frame.is_some() != decides(&[]));
            decided[usize::from(frame.is_some())] += 1;

            // Half of the packets arrive, all at once.
            in_flight.push(frame.map(|_| ControlSequence { tick: Tick(tick), inputs: inputs.clone() }));
            if let Some(frame) = frame.filter(|_| dice.delay(&[0.5]).is_some()) {
                actuator.receive(frame).expect("newer than the last");
            }
            let applied = actuator.step();
            in_flight.acknowledge(applied.age, applied.input);
            let acknowledgement = Acknowledgement::of(applied.tick, applied.age);
            let frame =
                wire::encode_acknowledgement::<f64>(&acknowledgement, &mut buffer).expect("there is room");
            controller.receive(frame).expect("of use");
        }
        assert!(decided.iter().all(|count| *count > 30) && otherwise > 10, "{decided:?} {otherwise}");
    }
}
