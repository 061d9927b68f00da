//! A controller that sends only what is worth a packet, and what it then counts, believes and saves.

#[path = "random/dice.rs"]
mod dice;
mod double_integrator;
mod lent;
#[path = "random/shuffle.rs"]
mod shuffle;
mod trigger_bench;

use dice::Dice;
use double_integrator::{DELAYS, LENGTH, Node};
use shuffle::shuffle;
use slqg::actuator::Applied;
use slqg::controller::{Counts, RejectedFrame};
use slqg::event::Trigger;
use slqg::nalgebra::SVector;
use slqg::wire::{self, Acknowledgement, Measurement};
use slqg::{Age, DefaultInput, Scalar, Tick};
use trigger_bench::{BOTH, Bench};

const CYCLES: usize = 300;
/// Sends some sequences of a run and keeps some.
const SOME: f64 = 0.01;

/// What happened in one run of the loop.
#[derive(Debug, PartialEq)]
struct Run<T: Scalar> {
    sent: Vec<Option<Vec<u8>>>,
    applied: Vec<Applied<T, 1>>,
    counts: Counts,
    /// Without that of packets.
    cost: f64,
}

impl<T: Scalar> Run<T> {
    fn packets(&self) -> usize {
        self.sent.iter().flatten().count()
    }
}

fn acknowledge<T: Scalar>(controller: &mut Node<'_, T>, tick: Tick, age: Age) -> Result<(), RejectedFrame> {
    let mut buffer = [0; 32];
    let acknowledgement = Acknowledgement::of(tick, age);
    let frame = wire::encode_acknowledgement::<T>(&acknowledgement, &mut buffer).expect("there is room");
    controller.receive(frame)
}

/// Runs the loop over a link that loses and delays control packets; every acknowledgement must be accepted.
fn run<T: Scalar>(bench: &Bench<T>, trigger: Option<Trigger<'_, T, 2, 1>>, seed: u64) -> Run<T> {
    let mut controller = lent::controller(bench.design(trigger), Tick(0)).expect("a fitting design");
    let mut actuator = lent::actuator(bench.workshop.settings, Tick(0), LENGTH);
    let model = &bench.workshop.model;
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15 ^ (seed << 20));
    let mut state = SVector::from([1.0, 0.5].map(T::nearest));
    let (mut sent, mut under_way, mut applied, mut cost) = (vec![], vec![], vec![], 0.0);
    for cycle in 0..CYCLES {
        let mut buffer = [0; 64];
        let noise = SVector::<f64, 2>::from_fn(|_, _| (dice.roll() - 0.5) * 0.03);
        let measurement = Measurement {
            tick: controller.tick(),
            output: model.c * state + SVector::from([T::nearest(noise[0] * 0.1)]),
        };
        let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
        controller.receive(frame).expect("of use");
        let frame = controller.cycle(&mut buffer).expect("there is room").map(<[u8]>::to_vec);
        let delay = dice.delay(&DELAYS);
        if let (Some(frame), Some(delay)) = (frame.clone(), delay) {
            under_way.push((cycle + delay, frame));
        }
        sent.push(frame);
        let mut arrived: Vec<_> =
            under_way.iter().filter(|(at, _)| *at == cycle).map(|(_, frame)| frame).collect();
        shuffle(&mut dice, &mut arrived);
        for frame in arrived {
            let _ = actuator.receive(frame);
        }
        if let Some(last) = applied.last() {
            let Applied { tick, input, .. } = last;
            assert_eq!(controller.expected_input(*tick), Some(*input));
        }
        let played = actuator.step();
        acknowledge(&mut controller, played.tick, played.age).expect("what was played was sent");
        let (x, u) = (state.map(T::widen), played.input[0].widen());
        cost += x[0] * x[0] + 0.1 * x[1] * x[1] + 0.05 * u * u;
        state = model.a * state + model.b * played.input + noise.map(T::nearest);
        applied.push(played);
    }
    Run { sent, applied, counts: controller.counts(), cost }
}

fn a_free_packet_is_always_sent<T: Scalar>() {
    for default_input in BOTH {
        let bench = Bench::<T>::new(default_input);
        for seed in 0..5 {
            let without = run(&bench, None, seed);
            assert_eq!(without.packets(), CYCLES);
            assert_eq!(run(&bench, Some(bench.trigger(0.0)), seed), without);
        }
    }
}

#[test]
fn packets_that_cost_nothing_are_sent_as_without_a_trigger_bit_for_bit() {
    a_free_packet_is_always_sent::<f32>();
    a_free_packet_is_always_sent::<f64>();
}

#[test]
fn packets_that_cost_too_much_are_never_sent_and_the_loop_goes_on() {
    for default_input in BOTH {
        let bench = Bench::<f32>::new(default_input);
        for send_cost in [f64::INFINITY, 1e30] {
            let run = run(&bench, Some(bench.trigger(send_cost)), 1);
            assert_eq!(run.packets(), 0);
            assert!(run.applied.iter().all(|applied| applied.age == Age::Empty && applied.input[0] == 0.0));
            let counts = Counts { not_worth_sending: CYCLES as u32, ..Counts::default() };
            assert_eq!(run.counts, counts);
        }
    }
}

#[test]
fn what_is_worth_a_packet_is_sent_and_the_rest_is_counted() {
    for default_input in BOTH {
        let bench = Bench::<f32>::new(default_input);
        for seed in 0..5 {
            let run = run(&bench, Some(bench.trigger(SOME)), seed);
            let packets = run.packets();
            assert!((CYCLES / 20..CYCLES * 3 / 4).contains(&packets), "{packets}");
            let counts = Counts { not_worth_sending: (CYCLES - packets) as u32, ..Counts::default() };
            assert_eq!(run.counts, counts);
            // Far from the target everything is worth a packet; nothing is sent for long near it.
            assert!(run.sent[0].is_some());
            assert!(run.applied.iter().any(|applied| applied.age == Age::Empty), "buffers run out");
        }
    }
}

#[test]
fn with_packets_in_the_bill_sending_what_is_worth_it_costs_less_than_sending_all() {
    for default_input in BOTH {
        let bench = Bench::<f64>::new(default_input);
        let bill = |trigger: Option<Trigger<'_, f64, 2, 1>>| {
            (0..20)
                .map(|seed| run(&bench, trigger, seed))
                .map(|run| run.cost + SOME * run.packets() as f64)
                .sum()
        };
        let (all, some): (f64, f64) = (bill(None), bill(Some(bench.trigger(SOME))));
        assert!(some < 0.95 * all, "{some} instead of {all}");
    }
}

#[test]
fn an_acknowledgement_of_a_packet_that_was_not_sent_is_refused() {
    let bench = Bench::<f32>::new(DefaultInput::Hold);
    let mut controller = lent::controller(bench.design(None), Tick(0)).expect("a fitting design");
    let mut buffer = [0; 64];
    assert!(controller.cycle(&mut buffer).expect("there is room").is_some());
    controller.set_trigger(Some(bench.trigger(f64::INFINITY))).expect("a fitting trigger");
    assert_eq!(controller.cycle(&mut buffer), Ok(None));
    let refused = Err(RejectedFrame::Acknowledgement);
    assert_eq!(acknowledge(&mut controller, Tick(1), Age::Steps(0)), refused, "nothing was sent in cycle 1");
    assert_eq!(acknowledge(&mut controller, Tick(1), Age::Steps(1)), Ok(()), "that of cycle 0 was");
    controller.set_trigger(None).expect("none always fits");
    assert!(controller.cycle(&mut buffer).expect("there is room").is_some());
    assert_eq!(controller.counts().not_worth_sending, 1);
}
