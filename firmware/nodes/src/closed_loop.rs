//! Controller and actuator against the plant model, frame by frame, for a fixed number of cycles.
//!
//! Everything that could differ between two machines is in here and in the core: arithmetic in `f32`, frames, links.
//! Nothing is random; the plant is pushed by a fixed pattern instead of noise.

use crate::pendulum::{ACTUATOR, Actuator, Controller, DESIGN, INPUTS, MODEL, OUTPUTS, STATES};
use crate::scripted_link::{FRAME_CAPACITY, ScriptedLink};
use crc::{CRC_32_ISCSI, Crc, Digest};
use slqg::{
    Tick,
    nalgebra::SVector,
    wire::{self, Acknowledgement, Measurement},
};

/// Cycles of a run: 4 s of the pendulum.
pub const CYCLES: u32 = 200;

/// Delays of control frames in cycles: half of them late, one in six lost, and an outage longer than a sequence.
const ACTUATOR_SCRIPT: [Option<u8>; 24] = [
    Some(0),
    Some(0),
    Some(1),
    None,
    Some(0),
    Some(2),
    Some(0),
    Some(0),
    Some(3),
    Some(1),
    Some(0),
    Some(0), //
    Some(1),
    Some(0),
    None,
    None,
    None,
    Some(5),
    Some(4),
    Some(0),
    Some(0),
    Some(1),
    Some(0),
    Some(2),
];
/// Delays of measurement frames: its length has no factor in common with the other, so that all pairs occur.
const SENSOR_SCRIPT: [Option<u8>; 17] = [
    Some(0),
    Some(1),
    Some(0),
    None,
    Some(0),
    Some(3),
    Some(0),
    Some(0),
    Some(2), //
    Some(0),
    None,
    Some(6),
    Some(0),
    Some(1),
    Some(0),
    Some(0),
    Some(4),
];
/// Push on each state in units of 1e-3, one row a cycle, over and over.
const PUSHES: [[i8; STATES]; 7] =
    [[2, 0, 1, 0], [-1, 0, -2, 0], [0, 0, 1, 0], [3, 0, 0, 0], [-2, 0, 1, 0], [0, 0, -1, 0], [-2, 0, 0, 0]];

/// What a run of the loop leaves behind, to be compared between host and board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// CRC-32 over the bits of every applied input, every estimate and the final state.
    pub digest: u32,
    /// Plant state after the last cycle.
    pub state: [f32; STATES],
    /// The last input that the actuator applied.
    pub applied: f32,
    /// Largest magnitude of the rod's angle in the run, rad.
    pub largest_angle: f32,
}

/// Runs the loop from its fixed start to its fixed end.
///
/// # Panics
/// If the generated design does not fit its own types, which the generator rules out.
pub fn run() -> Outcome {
    let checksum = Crc::<u32>::new(&CRC_32_ISCSI);
    let mut digest = checksum.digest();
    let start = Tick(0);
    let Ok(mut controller) = Controller::new(DESIGN, start) else {
        panic!("the generated design does not fit its controller");
    };
    let mut actuator = Actuator::new(ACTUATOR, start);
    let mut sensor_link = ScriptedLink::new(&SENSOR_SCRIPT);
    let mut actuator_link = ScriptedLink::new(&ACTUATOR_SCRIPT);
    let mut buffer = [0; FRAME_CAPACITY];
    let mut state = MODEL.initial_mean;
    let mut applied = SVector::<f32, INPUTS>::zeros();
    let mut largest_angle = 0.0_f32;

    for cycle in 0..CYCLES {
        let tick = start + cycle;
        let output: SVector<f32, OUTPUTS> = MODEL.c * state;
        if let Ok(frame) = wire::encode_measurement(&Measurement { tick, output }, &mut buffer) {
            sensor_link.send(frame);
        }
        // A refused frame changes nothing and is counted by the controller.
        for frame in sensor_link.arrived() {
            let _ = controller.receive(&frame);
        }
        if let Ok(Some(frame)) = controller.cycle(&mut buffer) {
            actuator_link.send(frame);
        }
        for frame in actuator_link.arrived() {
            let _ = actuator.receive(&frame);
        }
        let played = actuator.step();
        applied = played.input;
        // The acknowledgement reaches the controller before the next cycle begins.
        let told = Acknowledgement { tick, age: played.age };
        if let Ok(frame) = wire::encode_acknowledgement::<f32>(&told, &mut buffer) {
            let _ = controller.receive(frame);
        }

        let push = PUSHES[cycle as usize % PUSHES.len()];
        let push = SVector::<f32, STATES>::from_fn(|row, _| f32::from(push[row]) * 1e-3);
        state = MODEL.a * state + MODEL.b * applied + push;
        largest_angle = largest_angle.max(state[2].abs());
        include(&mut digest, applied.as_slice());
        include(&mut digest, controller.estimator().posterior_mean().as_slice());
    }
    include(&mut digest, state.as_slice());
    Outcome { digest: digest.finalize(), state: state.into(), applied: applied[0], largest_angle }
}

fn include(digest: &mut Digest<'_, u32>, values: &[f32]) {
    for value in values {
        digest.update(&value.to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rod_stays_upright_through_the_scripted_losses() {
        let outcome = run();
        assert!(outcome.largest_angle < 0.5, "{outcome:?}");
        assert!(outcome.state.iter().all(|value| value.abs() < 2.0), "{outcome:?}");
    }

    #[test]
    fn a_run_is_the_same_every_time() {
        assert_eq!(run(), run());
    }
}
