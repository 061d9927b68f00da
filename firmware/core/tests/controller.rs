//! Controller and actuator, joined by nothing but frames over a link that loses, delays and reorders them.

#[path = "random/dice.rs"]
mod dice;
mod double_integrator;
mod lent;
#[path = "random/shuffle.rs"]
mod shuffle;

use dice::Dice;
use double_integrator::{DELAYS, LATE, LENGTH, Node, Workshop};
use shuffle::shuffle;
use slqg::actuator::{Actuator, Applied, Limits, Settings};
use slqg::nalgebra::SVector;
use slqg::wire::{self, Acknowledgement, Measurement};
use slqg::{Age, DefaultInput, Scalar, Tick};

const CYCLES: usize = 400;
const START: Tick = Tick(u32::MAX - 200);
/// How late acknowledgements come: mostly at once, some too late for a short memory, some never.
const ACKNOWLEDGED: [f64; 6] = [0.5, 0.15, 0.1, 0.1, 0.05, 0.05];

fn measurement_frame<T: Scalar>(tick: Tick, output: T) -> Vec<u8> {
    let mut buffer = [0; 32];
    let measurement = Measurement { tick, output: SVector::from([output]) };
    wire::encode_measurement(&measurement, &mut buffer).expect("there is room").to_vec()
}

fn acknowledgement_frame<T: Scalar>(tick: Tick, age: Age) -> Vec<u8> {
    let mut buffer = [0; 32];
    let acknowledgement = Acknowledgement::of(tick, age);
    wire::encode_acknowledgement::<T>(&acknowledgement, &mut buffer).expect("there is room").to_vec()
}

/// One run: a plant, its two ends, and frames under way as (cycle of arrival, bytes).
struct Loop<'a, T: Scalar> {
    workshop: &'a Workshop<T>,
    controller: Node<'a, T>,
    actuator: Actuator<'static, T, 1>,
    state: SVector<T, 2>,
    dice: Dice,
    cycle: usize,
    to_controller: Vec<(usize, Vec<u8>)>,
    to_actuator: Vec<(usize, Vec<u8>)>,
    applied: Vec<Applied<T, 1>>,
    /// Whether the cycle's acknowledgement has arrived.
    acknowledged: Vec<bool>,
}

impl<'a, T: Scalar> Loop<'a, T> {
    fn new(workshop: &'a Workshop<T>, seed: u64) -> Self {
        Self {
            workshop,
            controller: lent::controller(workshop.design(), START).expect("a fitting design"),
            actuator: lent::actuator(workshop.settings, START, LENGTH),
            state: SVector::from([1.0, 0.5].map(T::nearest)),
            dice: Dice(seed),
            cycle: 0,
            to_controller: vec![],
            to_actuator: vec![],
            applied: vec![],
            acknowledged: vec![],
        }
    }

    fn noise(&mut self, deviation: f64) -> T {
        T::nearest((self.dice.roll() - 0.5) * 12.0f64.sqrt() * deviation)
    }

    /// Frames that reach the controller in this cycle, in random order.
    fn frames_for_controller(&mut self) -> Vec<Vec<u8>> {
        let output = self.state[0] + self.noise(0.01);
        if let Some(late) = self.dice.delay(&[0.6, 0.1, 0.1, 0.05, 0.05]) {
            let frame = measurement_frame(START + self.cycle as u32, output);
            self.to_controller.push((self.cycle + late, frame));
        }
        let mut arrived = take_arrived(&mut self.to_controller, self.cycle);
        shuffle(&mut self.dice, &mut arrived);
        for frame in &arrived {
            if let Ok(Acknowledgement { tick, .. }) = wire::decode_acknowledgement::<T>(frame) {
                self.acknowledged[tick.since(START) as usize] = true;
            }
        }
        arrived
    }

    /// Plant, actuator and both links after the controller has run, with the frame it sent.
    fn finish_cycle(&mut self, frame: Option<Vec<u8>>) {
        if let (Some(frame), Some(late)) = (frame, self.dice.delay(&DELAYS)) {
            self.to_actuator.push((self.cycle + late, frame));
        }
        for frame in take_arrived(&mut self.to_actuator, self.cycle) {
            let _ = self.actuator.receive(&frame);
        }
        let applied = self.actuator.step();
        if let Some(late) = self.dice.delay(&ACKNOWLEDGED) {
            self.to_controller
                .push((self.cycle + 1 + late, acknowledgement_frame::<T>(applied.tick, applied.age)));
        }
        let disturbance = SVector::from([self.noise(0.01), self.noise(0.01)]);
        let model = &self.workshop.model;
        self.state = model.a * self.state + model.b * applied.input + disturbance;
        self.applied.push(applied);
        self.acknowledged.push(false);
        self.cycle += 1;
    }

    fn run_controller(&mut self) -> Option<Vec<u8>> {
        let mut buffer = [0; 64];
        self.controller.cycle(&mut buffer).expect("there is room").map(<[u8]>::to_vec)
    }

    fn run_cycle(&mut self) {
        for frame in self.frames_for_controller() {
            assert_eq!(self.controller.receive(&frame), Ok(()));
        }
        let frame = self.run_controller();
        self.finish_cycle(frame);
    }
}

fn take_arrived(under_way: &mut Vec<(usize, Vec<u8>)>, cycle: usize) -> Vec<Vec<u8>> {
    let (arrived, rest) = std::mem::take(under_way).into_iter().partition(|(at, _)| *at == cycle);
    *under_way = rest;
    arrived.into_iter().map(|(_, frame)| frame).collect()
}

fn settings<T: Scalar>(default_input: DefaultInput, bound: Option<f64>) -> Settings<T, 1> {
    let bounds = |bound: f64| [-bound, bound].map(|value| SVector::from([T::nearest(value)]));
    Settings {
        default_input,
        limits: bound.map(bounds).map(|[min, max]| Limits { min, max, rate: None }),
        safe: None,
    }
}

/// Every setting of a loop, with a seed.
fn every_loop<T: Scalar>(check: impl Fn(Loop<'_, T>)) {
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        for bound in [None, Some(0.8)] {
            let workshop = Workshop::double_integrator(settings::<T>(default_input, bound));
            for seed in 1..=10 {
                check(Loop::new(&workshop, 0x9E37_79B9_7F4A_7C15 ^ (seed << 20)));
            }
        }
    }
}

/// Acknowledged inputs, remembered or not, are believed to the bit to be what left the actuator.
fn belief_is_what_was_applied<T: Scalar>(mut run: Loop<'_, T>) {
    let mut compared = 0;
    for _ in 0..CYCLES {
        run.run_cycle();
        let hold = run.workshop.settings.default_input == DefaultInput::Hold;
        // Held inputs are known if the one before is.
        let mut known = false;
        for (at, applied) in run.applied.iter().enumerate().skip(run.cycle.saturating_sub(LATE + 1)) {
            let default_known = !hold || known || at == 0;
            known = run.acknowledged[at] && (applied.age != Age::Empty || default_known);
            if let (true, Some(input)) = (known, run.controller.expected_input(applied.tick)) {
                assert_eq!(input, applied.input, "cycle {at} seen from {}", run.cycle);
                compared += 1;
            }
        }
    }
    assert!(compared > CYCLES, "most acknowledgements arrive");
    assert!(run.state.norm() < T::nearest(10.0), "the loop is stable: {}", run.state);
    assert_eq!(run.controller.counts().not_finite, 0);
}

#[test]
fn an_acknowledged_input_is_believed_to_be_what_the_actuator_applied() {
    every_loop::<f32>(belief_is_what_was_applied);
    every_loop::<f64>(belief_is_what_was_applied);
}

fn order_does_not_matter<T: Scalar>(mut run: Loop<'_, T>) {
    let mut other = lent::controller(run.workshop.design(), START).expect("a fitting design");
    let mut other_order = Dice(run.dice.0 ^ 0x5555);
    for cycle in 0..CYCLES {
        let mut frames = run.frames_for_controller();
        for frame in &frames {
            assert_eq!(run.controller.receive(frame), Ok(()));
        }
        shuffle(&mut other_order, &mut frames);
        for frame in &frames {
            assert_eq!(other.receive(frame), Ok(()));
        }
        let mut buffer = [0; 64];
        let expected = other.cycle(&mut buffer).expect("there is room").map(<[u8]>::to_vec);
        let frame = run.run_controller();
        assert_eq!(frame, expected, "cycle {cycle}");
        run.finish_cycle(frame);
    }
}

#[test]
fn the_order_of_frames_within_a_cycle_does_not_change_a_bit() {
    every_loop::<f32>(order_does_not_matter);
    every_loop::<f64>(order_does_not_matter);
}

fn garbage_changes_nothing<T: Scalar>(mut run: Loop<'_, T>) {
    let mut other = lent::controller(run.workshop.design(), START).expect("a fitting design");
    let mut garbage_frames = 0;
    for cycle in 0..CYCLES {
        let now = other.tick();
        let mut buffer = [0; 64];
        for frame in run.frames_for_controller() {
            let mut damaged = frame.clone();
            damaged[(run.dice.roll() * frame.len() as f64) as usize] ^= 0x10;
            let never_sent = acknowledgement_frame::<T>(now - 1, Age::Steps(200));
            let not_over = acknowledgement_frame::<T>(now, Age::Empty);
            let forgotten = acknowledgement_frame::<T>(now - (LATE as u32 + 1), Age::Empty);
            let future = measurement_frame(now + 1, T::one());
            let ancient = measurement_frame(now - (LATE as u32 + 1), T::one());
            let other_scalar = if T::BYTES == 4 {
                measurement_frame::<f64>(now, 1.0)
            } else {
                measurement_frame::<f32>(now, 1.0)
            };
            let truncated = frame[..frame.len() - 1].to_vec();
            for garbage in
                [damaged, never_sent, not_over, forgotten, future, ancient, other_scalar, truncated, vec![]]
            {
                other.receive(&garbage).expect_err("garbage");
                garbage_frames += 1;
            }
            assert_eq!(run.controller.receive(&frame), other.receive(&frame));
        }
        let expected = other.cycle(&mut buffer).expect("there is room").map(<[u8]>::to_vec);
        let frame = run.run_controller();
        assert_eq!(frame, expected, "cycle {cycle}");
        run.finish_cycle(frame);
    }
    assert_eq!(run.controller.counts().rejected_frames, 0);
    assert_eq!(other.counts().rejected_frames, garbage_frames);
    assert_eq!(other.counts().unacknowledged, run.controller.counts().unacknowledged);
}

#[test]
fn garbage_is_counted_and_changes_nothing() {
    every_loop::<f32>(garbage_changes_nothing);
    every_loop::<f64>(garbage_changes_nothing);
}
