//! A link that loses, delays and repeats what controllers of the double integrator send and hear; and all that one of them
//! knows, to the bit.
#![allow(dead_code)]

use crate::dice::Dice;
use crate::double_integrator::{DELAYS, LENGTH, Node};
use crate::lent;
use slqg::actuator::Actuator;
use slqg::controller::Design;
use slqg::nalgebra::SVector;
use slqg::wire::{self, Measurement};
use slqg::{Age, Tick};

/// How late frames to the controller are; the rest to 1 is loss.
const BACK: [f64; 4] = [0.5, 0.15, 0.1, 0.05];

/// Plant, actuator and both links.
pub(crate) struct Exercise<'d> {
    design: Design<'d, f32, 2, 1, 1>,
    actuator: Actuator<'static, f32, 1>,
    state: SVector<f32, 2>,
    dice: Dice,
    tick: Tick,
    to_controller: Vec<(Tick, Vec<u8>)>,
    to_actuator: Vec<(Tick, Vec<u8>)>,
}

impl<'d> Exercise<'d> {
    pub(crate) fn new(design: Design<'d, f32, 2, 1, 1>, start: Tick, seed: u64) -> Self {
        Self {
            design,
            actuator: lent::actuator(design.actuator, start, LENGTH),
            state: SVector::from([1.0, 0.5]),
            dice: Dice(0x9E37_79B9_7F4A_7C15 ^ (seed << 20)),
            tick: start,
            to_controller: vec![],
            to_actuator: vec![],
        }
    }

    /// The frames that reach the controller in this cycle.
    pub(crate) fn heard(&mut self) -> Vec<Vec<u8>> {
        let mut buffer = [0; 64];
        let noise = SVector::from([(self.dice.roll() - 0.5) as f32 * 0.03]);
        let measurement = Measurement { tick: self.tick, output: self.design.model.c * self.state + noise };
        if let Some(late) = self.dice.delay(&BACK) {
            let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
            self.to_controller.push((self.tick + late as u32, frame.to_vec()));
        }
        arrived(&mut self.to_controller, self.tick)
    }

    /// Ends the cycle, in which the controller sent this.
    pub(crate) fn finish(&mut self, frame: Option<&[u8]>) {
        if let (Some(frame), Some(late)) = (frame, self.dice.delay(&DELAYS)) {
            self.to_actuator.push((self.tick + late as u32, frame.to_vec()));
        }
        for frame in arrived(&mut self.to_actuator, self.tick) {
            // Past ones are refused.
            let _ = self.actuator.receive(&frame);
        }
        let applied = self.actuator.step();
        let noise = SVector::from_fn(|_, _| (self.dice.roll() - 0.5) as f32 * 0.03);
        self.state = self.design.model.a * self.state + self.design.model.b * applied.input + noise;
        self.tick += 1;
        // Each is about two cycles, the older of which another one may have told of.
        if let Some(late) = self.dice.delay(&BACK) {
            let mut buffer = [0; 64];
            let told = self.actuator.acknowledgement(2).expect("it has played");
            let frame = wire::encode_acknowledgement::<f32>(&told, &mut buffer).expect("there is room");
            self.to_controller.push((self.tick + late as u32, frame.to_vec()));
        }
    }

    /// Runs `controller` for some cycles, and returns what it sent and knew in each.
    pub(crate) fn run(
        &mut self,
        controller: &mut Node<'_, f32>,
        cycles: usize,
    ) -> Vec<(Option<Vec<u8>>, Vec<u64>)> {
        let mut cycle = || {
            for frame in self.heard() {
                // What is too old is refused.
                let _ = controller.receive(&frame);
            }
            let mut buffer = [0; 64];
            let frame = controller.cycle(&mut buffer).expect("there is room").map(<[u8]>::to_vec);
            self.finish(frame.as_deref());
            (frame, known(controller))
        };
        (0..cycles).map(|_| cycle()).collect()
    }
}

fn arrived(under_way: &mut Vec<(Tick, Vec<u8>)>, now: Tick) -> Vec<Vec<u8>> {
    let (arrived, rest) = std::mem::take(under_way).into_iter().partition(|(at, _)| *at == now);
    *under_way = rest;
    arrived.into_iter().map(|(_, frame)| frame).collect()
}

/// All that a controller knows: state, ages, inputs, acknowledgements, counts and what was sent.
pub(crate) fn known(controller: &Node<'_, f32>) -> Vec<u64> {
    let (estimator, now) = (controller.estimator(), controller.tick());
    let covariance = estimator.posterior_covariance();
    let numbers = estimator.posterior_mean().iter().chain(covariance.iter());
    let mut known: Vec<u64> = numbers.map(|number| number.to_bits().into()).collect();
    known.push(now.0.into());
    let ages = (0..LENGTH as u8).map(Age::Steps).chain([Age::Empty]);
    let modes = estimator.modes();
    known.extend(ages.map(|age| modes.map_or(7, |modes| modes.probability(age).to_bits().into())));
    for ago in 0..20 {
        let input = controller.expected_input(now - ago).map_or(7, |input| input[0].to_bits().into());
        let acknowledged =
            controller.acknowledged_age(now - ago).map_or(300, |age| age.steps().unwrap_or(255) as u64);
        known.extend([input, acknowledged, controller.has_sent(now - ago).into()]);
    }
    let counts = controller.counts();
    let counts = [counts.rejected_frames, counts.unacknowledged, counts.not_finite, counts.not_worth_sending];
    known.extend(counts.map(u64::from));
    known
}
