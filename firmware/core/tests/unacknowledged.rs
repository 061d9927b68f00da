//! Whole controllers that hear of few ages or none: what the law is handed, what is sent, and how the loop fares.

#[path = "random/dice.rs"]
mod dice;
mod double_integrator;
mod lent;
mod trigger_bench;

use dice::Dice;
use double_integrator::{DELAYS, LATE, LENGTH, Node, Workshop};
use slqg::actuator::{Actuator, Applied, Limits, Settings};
use slqg::controller::{Counts, Design};
use slqg::estimator::Merging;
use slqg::nalgebra::SVector;
use slqg::played::Played;
use slqg::tracking::Feedforward;
use slqg::wire::{self, Measurement};
use slqg::{Age, DefaultInput, Scalar, Tick, sequence::ControlSequence};
use trigger_bench::{BOTH, Bench};

const MERGINGS: [Merging; 3] = [Merging::Single, Merging::Imm, Merging::Gpb2];
const CYCLES: usize = 300;
/// Sends some sequences of a run and keeps some.
const SOME: f64 = 0.01;

/// A loop over a link that loses and delays control packets, and from which few acknowledgements come back.
struct Loop<'a, T: Scalar> {
    design: Design<'a, T, 2, 1, 1>,
    controller: Node<'a, T>,
    actuator: Actuator<'static, T, 1>,
    state: SVector<T, 2>,
    dice: Dice,
    cycle: usize,
    under_way: Vec<(usize, Vec<u8>)>,
    applied: Vec<Applied<T, 1>>,
    /// Whether an acknowledgement came after the last cycle.
    heard: bool,
    /// Probability that an acknowledgement comes, and cycles that each is about.
    acknowledged: (f64, usize),
}

impl<'a, T: Scalar> Loop<'a, T> {
    fn new(design: Design<'a, T, 2, 1, 1>, acknowledged: (f64, usize), seed: u64) -> Self {
        Self {
            design,
            controller: lent::controller(design, Tick(0)).expect("a fitting design"),
            actuator: lent::actuator(design.actuator, Tick(0), LENGTH),
            state: SVector::from([1.0, 0.5].map(T::nearest)),
            dice: Dice(0x9E37_79B9_7F4A_7C15 ^ (seed << 20)),
            cycle: 0,
            under_way: vec![],
            applied: vec![],
            heard: false,
            acknowledged,
        }
    }

    /// Measures and runs the controller, and returns what it sends.
    fn controls(&mut self) -> Option<ControlSequence<'static, T, 1>> {
        let mut buffer = [0; 64];
        let noise = SVector::from([T::nearest((self.dice.roll() - 0.5) * 0.003)]);
        let output = self.design.model.c * self.state + noise;
        let measurement = Measurement { tick: self.controller.tick(), output };
        let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
        self.controller.receive(frame).expect("of use");
        let frame = self.controller.cycle(&mut buffer).expect("there is room")?.to_vec();
        let sequence = lent::decoded(&frame, LENGTH).expect("finite numbers only");
        if let Some(delay) = self.dice.delay(&DELAYS) {
            self.under_way.push((self.cycle + delay, frame));
        }
        Some(sequence)
    }

    /// Moves the plant.
    fn moves(&mut self) {
        for (_, frame) in self.under_way.iter().filter(|(at, _)| *at == self.cycle) {
            let _ = self.actuator.receive(frame);
        }
        let applied = self.actuator.step();
        let noise = SVector::from_fn(|_, _| T::nearest((self.dice.roll() - 0.5) * 0.03));
        self.state = self.design.model.a * self.state + self.design.model.b * applied.input + noise;
        let (probability, cycles) = self.acknowledged;
        self.applied.push(applied);
        self.heard = self.dice.roll() < probability;
        if self.heard {
            let mut buffer = [0; 64];
            let acknowledgement = self.actuator.acknowledgement(cycles).expect("it has played");
            let frame = wire::encode_acknowledgement::<T>(&acknowledgement, &mut buffer);
            self.controller.receive(frame.expect("there is room")).expect("what was played was sent");
        }
        self.cycle += 1;
    }
}

/// The law for the age played in the last cycle as the estimator sees it: the mean over all, or the mean age rounded.
fn what_is_sent_is_the_law(rounds_age: bool) {
    let bound = SVector::from([0.8]);
    for default_input in BOTH {
        for limits in [None, Some(Limits { min: -bound, max: bound, rate: None })] {
            let workshop = Workshop::<f64>::double_integrator(Settings { default_input, limits, safe: None });
            for merging in MERGINGS {
                let design = Design { merging, ..workshop.design() };
                let mut run = Loop::new(design, (0.2, 1), 1);
                run.controller.round_age(rounds_age);
                let mut in_flight = lent::in_flight(LENGTH, LENGTH + LATE, Tick(0));
                let (mut uncertain, mut otherwise) = (0, 0);
                for now in 0..CYCLES {
                    let sequence = run.controls().expect("everything is sent");
                    let modes = run.controller.estimator().modes().expect("filtered");
                    let last = Tick(now as u32) - 1;
                    let expected = |age: Age| {
                        let input = in_flight.applied_input(default_input, last, age, &modes.held);
                        let input = design.actuator.saturate(&input.unwrap_or_else(SVector::zeros));
                        lent::expected(&in_flight, &design.gains, &Played::Known(age, input))
                    };
                    let mut mean = vec![SVector::zeros(); design.gains.in_flight()];
                    for (age, probability) in modes.iter() {
                        for (sum, input) in mean.iter_mut().zip(expected(age)) {
                            *sum += input * probability;
                        }
                    }
                    let ages = modes
                        .iter()
                        .map(|(age, probability)| (age.steps().unwrap_or(LENGTH) as f64, probability));
                    let mean_age: f64 = ages.map(|(age, probability)| age * probability).sum();
                    let nearest = Some(mean_age.round() as u8).filter(|age| usize::from(*age) < LENGTH);
                    assert_eq!(modes.rounded(LENGTH), nearest.map_or(Age::Empty, Age::Steps));
                    let rounded = expected(modes.rounded(LENGTH));
                    let posterior_mean = run.controller.estimator().posterior_mean();
                    let law = |vbar: &[SVector<f64, 1>]| lent::sequence(&design.gains, posterior_mean, vbar);
                    let distance = |vbar: &[SVector<f64, 1>]| {
                        let pairs = law(vbar).into_iter().zip(sequence.inputs);
                        pairs.map(|(law, sent)| (law - sent).norm()).fold(0.0, f64::max)
                    };
                    let (meant, other) =
                        if rounds_age { (&rounded[..], &mean[..]) } else { (&mean[..], &rounded[..]) };
                    assert!(distance(meant) < 1e-12, "cycle {now}, {merging:?}, {default_input:?}");
                    otherwise += usize::from(distance(other) > 1e-6);
                    uncertain += usize::from(modes.known().is_none());
                    lent::push(&mut in_flight, Some(sequence.inputs));
                    run.moves();
                }
                assert!(uncertain > CYCLES / 2 && otherwise > CYCLES / 4, "{uncertain} {otherwise}");
                assert!(run.state.norm() < 3.0, "the loop is stable: {}", run.state);
            }
        }
    }
}

#[test]
fn the_law_takes_the_expected_inputs_of_every_age_with_its_probability() {
    what_is_sent_is_the_law(false);
}

#[test]
fn a_controller_that_rounds_the_age_takes_the_mean_age_for_certain() {
    what_is_sent_is_the_law(true);
}

fn some_packets_are_worth_it<T: Scalar>() {
    for default_input in BOTH {
        let bench = Bench::<T>::new(default_input);
        for merging in MERGINGS {
            for acknowledged in [(0.0, 1), (0.5, 1), (0.3, 8)] {
                let design = Design { merging, ..bench.design(Some(bench.trigger(SOME))) };
                let mut run = Loop::new(design, acknowledged, 2);
                let mut packets = 0;
                for cycle in 0..CYCLES {
                    // A reference that goes up and down.
                    let push =
                        |ahead: usize| SVector::from([T::nearest(0.2 * ((cycle + ahead) as f64).sin())]);
                    let inputs: Vec<_> = (0..LENGTH).map(push).collect();
                    let displaced = &inputs[..design.gains.in_flight()];
                    let feedforward = Feedforward { inputs: &inputs, displaced };
                    run.controller.set_feedforward(feedforward).expect("finite");
                    packets += usize::from(run.controls().is_some());
                    run.moves();
                }
                let counts = run.controller.counts();
                assert!((CYCLES / 20..CYCLES * 19 / 20).contains(&packets), "{packets} with {merging:?}");
                let not_worth_sending = (CYCLES - packets) as u32;
                let unacknowledged = counts.unacknowledged;
                assert_eq!(counts, Counts { not_worth_sending, unacknowledged, ..Counts::default() });
                assert!(unacknowledged > CYCLES as u32 / 3);
                assert!(run.state.norm() < T::nearest(3.0), "the loop is stable: {}", run.state);
            }
        }
    }
}

#[test]
fn what_is_worth_a_packet_is_decided_and_sent_without_acknowledgements_too() {
    some_packets_are_worth_it::<f32>();
    some_packets_are_worth_it::<f64>();
}

#[test]
fn after_an_acknowledgement_of_eight_cycles_every_input_in_memory_is_known_to_the_bit() {
    let settings = Settings { default_input: DefaultInput::Zero, limits: None, safe: None };
    let workshop = Workshop::<f32>::double_integrator(settings);
    for merging in MERGINGS {
        let design = Design { merging, ..workshop.design() };
        let mut run = Loop::new(design, (0.3, 8), 3);
        let mut compared = 0;
        for now in 0..CYCLES {
            run.controls();
            // Of the cycle before the oldest in memory nothing is remembered.
            let remembered = now.saturating_sub(LATE)..now;
            if run.heard {
                for played in &run.applied[remembered] {
                    assert_eq!(run.controller.expected_input(played.tick), Some(played.input));
                    compared += 1;
                }
            }
            run.moves();
        }
        assert!(compared > CYCLES);
    }
}
