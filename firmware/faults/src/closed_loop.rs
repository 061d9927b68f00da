//! The loop: one end in the emulator, the other one, the plant and the links in this process.

use crate::{
    design::{
        ACKNOWLEDGED_CYCLES, ACTUATOR, ACTUATOR_MEMORY, Actuator, Controller, DESIGN, MODEL, Memory,
        SEQUENCE_LENGTH,
    },
    node::{Node, Stopped},
};
use nalgebra::{SMatrix, SVector};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use slqg::{
    Tick,
    wire::{self, Kind, Measurement, Role},
};

/// `P(delay = 0, 1, ..)` of either link, as in the design file.
const DELAYS: [f64; 11] = [
    0.7,
    0.140134919,
    0.0535446853,
    0.0303992054,
    0.0203321882,
    0.0148805662,
    0.0115298891,
    0.00929256176,
    0.007708502,
    0.00653690849,
    0.00564057433,
];
/// Cycles of every run that ends well.
const LEAST: usize = 700;
/// Inputs in a row that are the same, after which nothing else is to be expected.
const SAME: usize = 300;
/// The rod has fallen, in rad.
const FALLEN: f64 = 0.5;

/// What a run came to.
pub(crate) struct Run {
    /// Input of each cycle that ran, in N.
    pub(crate) inputs: Vec<f32>,
    /// The rod has fallen.
    pub(crate) has_fallen: bool,
    /// The node has stopped: its watchdog would have reset it.
    pub(crate) has_stopped: bool,
    /// The end in this process was lost at the end.
    pub(crate) other_is_lost: bool,
}

/// A packet that arrives in a cycle.
struct Packet {
    due: usize,
    frame: Vec<u8>,
}

/// Packets under way, and the delays of those to come.
struct Link {
    packets: Vec<Packet>,
    delays: ChaCha8Rng,
}

impl Link {
    fn new(seed: u64, stream: u64) -> Self {
        let mut delays = ChaCha8Rng::seed_from_u64(seed);
        delays.set_stream(stream);
        Self { packets: Vec::new(), delays }
    }

    /// One number is drawn in each cycle, sent or not: faults change no delay.
    fn send(&mut self, cycle: usize, frame: Option<&[u8]>) {
        let mut drawn: f64 = self.delays.random();
        let delay = DELAYS.iter().position(|probability| {
            drawn -= probability;
            drawn < 0.0
        });
        if let Some((delay, frame)) = delay.zip(frame) {
            self.packets.push(Packet { due: cycle + delay, frame: frame.to_vec() });
        }
    }

    fn arriving(&mut self, cycle: usize) -> Vec<Vec<u8>> {
        let (due, later) =
            std::mem::take(&mut self.packets).into_iter().partition(|packet| packet.due == cycle);
        self.packets = later;
        due.into_iter().map(|packet: Packet| packet.frame).collect()
    }
}

/// Runs `cycles` cycles with the end `role` on this node; fewer, but [`LEAST`], where the last [`SAME`] inputs are those of the run
/// without a fault, to the bit.
pub(crate) fn run(node: &mut Node, role: Role, seed: u64, cycles: usize, undisturbed: &[f32]) -> Run {
    let mut outcome = Run { inputs: Vec::new(), has_fallen: false, has_stopped: false, other_is_lost: false };
    let (mut memory, mut room) = (Memory::new(), ACTUATOR_MEMORY);
    let mut controller =
        Controller::new(DESIGN, Tick(0), memory.lend()).expect("the generator has checked it");
    let mut actuator = Actuator::new(ACTUATOR, Tick(0), &mut room);
    let mut noise = ChaCha8Rng::seed_from_u64(seed);
    let (mut sensing, mut acting) = (Link::new(seed, 1), Link::new(seed, 2));
    let [a, w] = [&MODEL.a, &MODEL.process_noise].map(|matrix: &SMatrix<f32, 4, 4>| matrix.map(f64::from));
    let (b, c, v) = (MODEL.b.map(f64::from), MODEL.c.map(f64::from), MODEL.measurement_noise.map(f64::from));
    let mut state = MODEL.initial_mean.map(f64::from);
    let mut acknowledgement: Option<Vec<u8>> = None;
    if node.begin().is_err() {
        outcome.has_stopped = true;
        return outcome;
    }
    let (mut buffer, mut same) = ([0; 256], 0);
    for cycle in 0..cycles {
        let tick = Tick(cycle as u32);
        let mut gaussian = || noise.sample::<f64, _>(StandardNormal);
        let errors = SVector::<f64, 2>::from_fn(|place, _| v[(place, place)].sqrt() * gaussian());
        let pushes = SVector::<f64, 4>::from_fn(|place, _| w[(place, place)].sqrt() * gaussian());
        let output = (c * state + errors).map(|value| value as f32);
        let measured =
            wire::encode_measurement(&Measurement { tick, output }, &mut buffer).expect("there is room");
        sensing.send(cycle, Some(measured));
        let mut to_controller = sensing.arriving(cycle);
        to_controller.extend(acknowledgement.take());
        let control = match role {
            Role::Controller => controlled(node, tick, &to_controller),
            Role::Actuator => {
                for frame in &to_controller {
                    // What is of no use changes nothing.
                    let _ = controller.receive(frame);
                }
                Ok(controller.cycle(&mut buffer).expect("there is room").map(<[u8]>::to_vec))
            }
        };
        let Ok(control) = control else {
            outcome.has_stopped = true;
            break;
        };
        acting.send(cycle, control.as_deref());
        let to_actuator = acting.arriving(cycle);
        let applied = match role {
            Role::Actuator => applied(node, tick, &to_actuator),
            Role::Controller => {
                for frame in &to_actuator {
                    let _ = actuator.receive(frame);
                }
                let input = actuator.step().input[0];
                let told = actuator.acknowledgement(ACKNOWLEDGED_CYCLES);
                let told = told.and_then(|told| {
                    wire::encode_acknowledgement::<f32>(&told, &mut buffer).ok().map(<[u8]>::to_vec)
                });
                Ok((input, told))
            }
        };
        let Ok((input, told)) = applied else {
            outcome.has_stopped = true;
            break;
        };
        acknowledgement = told;
        outcome.inputs.push(input);
        same = if undisturbed.get(cycle).is_some_and(|other| other.to_bits() == input.to_bits()) {
            same + 1
        } else {
            0
        };
        if cycle + 1 >= LEAST && same >= SAME {
            break;
        }
        state = a * state + b * f64::from(input) + pushes;
        if state[2].is_nan() || state[2].abs() > FALLEN {
            outcome.has_fallen = true;
            break;
        }
    }
    outcome.other_is_lost = match role {
        Role::Controller => actuator.health().is_lost(),
        Role::Actuator => controller.health().is_lost(),
    };
    outcome
}

/// The controller's cycle on its node: the frame that it sends, if any.
fn controlled(node: &mut Node, tick: Tick, frames: &[Vec<u8>]) -> Result<Option<Vec<u8>>, Stopped> {
    frames.iter().for_each(|frame| node.send(frame));
    node.clock(tick, true);
    let frames = node.frames_up_to(Kind::Ran)?;
    Ok(frames.into_iter().find(|frame| Kind::of(frame) == Some(Kind::Control)))
}

/// The actuator's cycle on its node: what it applies, and what it tells of that. A frame that cannot be read is of another input
/// than it says, which is one like any other that is wrong.
fn applied(node: &mut Node, tick: Tick, frames: &[Vec<u8>]) -> Result<(f32, Option<Vec<u8>>), Stopped> {
    frames.iter().for_each(|frame| node.send(frame));
    node.clock(tick, true);
    let frames = node.frames_up_to(Kind::Applied)?;
    let last = frames.last().ok_or(Stopped)?;
    let input = wire::decode_applied::<f32, 1>(last).map_or(f32::NAN, |applied| applied.input[0]);
    Ok((input, frames.into_iter().find(|frame| Kind::of(frame) == Some(Kind::Acknowledgement))))
}

const _: () = assert!(SEQUENCE_LENGTH == 4, "the pages tell of N = 4");
