//! Controller and actuator against the plant model, frame by frame, for a fixed number of cycles.
//!
//! Everything that could differ between two machines is in here and in the core: arithmetic in `f32`, frames, links.
//! Nothing is random; the plant is pushed by a fixed pattern instead of noise. Which designs are run is said in
//! [`crate::cases`].

use crate::Time;
use crate::scripted_link::{FRAME_CAPACITY, ScriptedLink};
use crc::{CRC_32_ISCSI, Crc, Digest};
use heapless::Vec;
use slqg::{
    Tick,
    actuator::{Actuator, Settings},
    controller::{Controller, Design, Memory},
    nalgebra::SVector,
    wire::{self, Measurement},
};

/// Cycles of a run: 4 s of the pendulum.
pub const CYCLES: u32 = 200;
/// Most states of a plant.
const MOST_STATES: usize = 4;
/// Most reference samples that are handed over at once.
const MOST_SAMPLES: usize = 1024;

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
const PUSHES: [[i8; MOST_STATES]; 7] =
    [[2, 0, 1, 0], [-1, 0, -2, 0], [0, 0, 1, 0], [3, 0, 0, 0], [-2, 0, 1, 0], [0, 0, -1, 0], [-2, 0, 0, 0]];

/// What a run of the loop leaves behind, to be compared between host and board.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// CRC-32 over the bits of every applied input, every estimate and the final state, and over what was sent when.
    pub digest: u32,
    /// Plant state after the last cycle.
    pub state: Vec<f32, MOST_STATES>,
    /// Largest magnitude of each state in the run.
    pub largest: Vec<f32, MOST_STATES>,
    /// Largest magnitude of the tracking error in the last quarter of the run, of any tracked output; 0 without any.
    pub largest_error: f32,
    /// Control frames sent.
    pub sent: u32,
    /// Time the controller took, by the clock that the run was given.
    pub time: Time,
}

/// What becomes of the acknowledgements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Feedback {
    /// Each is there before the next cycle.
    Instant,
    /// There is none.
    None,
    /// Delays in cycles, over and over; each tells the last four cycles.
    Scripted(&'static [Option<u8>]),
}

/// One end of the loop's constants, as the generator makes them.
#[derive(Debug)]
pub(crate) struct Loop<const NX: usize, const NU: usize, const NY: usize, const NZ: usize> {
    /// The controller's.
    pub(crate) design: Design<'static, f32, NX, NU, NY>,
    /// The actuator's.
    pub(crate) actuator: Settings<f32, NU>,
    /// Tracked outputs as rows over the states; without any, no reference is handed over.
    pub(crate) tracked: [[f32; NX]; NZ],
    /// What each tracked output is to be in the middle half of the run; zero before and after.
    pub(crate) plateau: [f32; NZ],
    /// The acknowledgements' way.
    pub(crate) feedback: Feedback,
}

impl<const NX: usize, const NU: usize, const NY: usize, const NZ: usize> Loop<NX, NU, NY, NZ> {
    fn reference(&self, cycle: u32) -> SVector<f32, NZ> {
        let within = (CYCLES / 4..3 * CYCLES / 4).contains(&cycle);
        if within { SVector::from(self.plateau) } else { SVector::zeros() }
    }

    /// Runs the loop from its fixed start to its fixed end. `clock` counts upwards in ticks of any length, and may wrap.
    ///
    /// # Panics
    /// If the generated design does not fit its own types, which the generator rules out.
    pub(crate) fn run(
        &self,
        memory: Memory<'_, f32, NX, NU, NY>,
        of_actuator: &mut [SVector<f32, NU>],
        clock: fn() -> u32,
    ) -> Outcome {
        let checksum = Crc::<u32>::new(&CRC_32_ISCSI);
        let mut digest = checksum.digest();
        let start = Tick(0);
        let Ok(mut controller) = Controller::new(self.design, start, memory) else {
            panic!("the generated design does not fit its controller");
        };
        let model = self.design.model;
        let mut actuator = Actuator::new(self.actuator, start, of_actuator);
        let mut sensor_link = ScriptedLink::new(&SENSOR_SCRIPT);
        let mut actuator_link = ScriptedLink::new(&ACTUATOR_SCRIPT);
        let mut buffer = [0; FRAME_CAPACITY];
        let mut state = model.initial_mean;
        let mut largest = SVector::<f32, NX>::zeros();
        let (mut largest_error, mut sent) = (0.0_f32, 0);
        let mut time = Time::default();
        let mut acknowledgement_link = match self.feedback {
            Feedback::Scripted(script) => ScriptedLink::new(script),
            Feedback::Instant => ScriptedLink::new(&[Some(0)]),
            Feedback::None => ScriptedLink::new(&[None]),
        };
        let told_cycles = if matches!(self.feedback, Feedback::Scripted(_)) { 4 } else { 1 };
        let mut acknowledged = Vec::new();

        for cycle in 0..CYCLES {
            let tick = start + cycle;
            let output: SVector<f32, NY> = model.c * state;
            if let Ok(frame) = wire::encode_measurement(&Measurement { tick, output }, &mut buffer) {
                sensor_link.send(frame);
            }
            let begin = clock();
            // A refused frame changes nothing and is counted by the controller.
            for frame in sensor_link.arrived().iter().chain(&acknowledged) {
                let _ = controller.receive(frame);
            }
            if let Some(preview) = &self.design.preview {
                let ahead =
                    (1..=preview.samples().min(MOST_SAMPLES) as u32).map(|t| self.reference(cycle + t));
                let known: Vec<_, MOST_SAMPLES> = ahead.collect();
                let _ = controller.follow(&known);
            }
            let frame = controller.cycle(&mut buffer).ok().flatten();
            time.add(clock().wrapping_sub(begin));
            sent += u32::from(frame.is_some());
            digest.update(&[u8::from(frame.is_some())]);
            match frame {
                Some(frame) => actuator_link.send(frame),
                None => actuator_link.skip(),
            }
            for frame in actuator_link.arrived() {
                let _ = actuator.receive(&frame);
            }
            let played = actuator.step();
            // What arrives now is there before the next cycle begins.
            let told = actuator.acknowledgement(told_cycles);
            if let Some(Ok(frame)) = told.map(|told| wire::encode_acknowledgement::<f32>(&told, &mut buffer))
            {
                acknowledgement_link.send(frame);
            }
            acknowledged = acknowledgement_link.arrived();

            for (row, reference) in self.tracked.iter().zip(self.reference(cycle).iter()) {
                let error = SVector::from(*row).dot(&state) - reference;
                if cycle >= 3 * CYCLES / 4 + CYCLES / 8 {
                    largest_error = largest_error.max(error.abs());
                }
            }
            let push = PUSHES[cycle as usize % PUSHES.len()];
            let push = SVector::<f32, NX>::from_fn(|row, _| f32::from(push[row % MOST_STATES]) * 1e-3);
            state = model.a * state + model.b * played.input + push;
            largest = largest.zip_map(&state, |most, now| most.max(now.abs()));
            include(&mut digest, played.input.as_slice());
            include(&mut digest, controller.estimator().posterior_mean().as_slice());
        }
        include(&mut digest, state.as_slice());
        Outcome {
            digest: digest.finalize(),
            state: state.iter().copied().collect(),
            largest: largest.iter().copied().collect(),
            largest_error,
            sent,
            time,
        }
    }
}

fn include(digest: &mut Digest<'_, u32>, values: &[f32]) {
    for value in values {
        digest.update(&value.to_le_bytes());
    }
}
