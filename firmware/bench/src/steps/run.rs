//! One loop, each cycle of which is done twice: by controller and actuator as a whole, and step by step.
//!
//! Both must come to the same bytes, or what is counted is not what runs.

use super::Cost;
use super::apart::{Apart, Memories};
use super::bounds::Dimensions;
use super::stopwatch::{Step, Stopwatch};
use crate::scripted_link::{FRAME_CAPACITY, Frame};
use core::hint::black_box;
use heapless::Vec;
use slqg::{
    Tick,
    actuator::{Actuator, Settings},
    controller::{Controller, Design},
    estimator::Merging,
    nalgebra::SVector,
    wire::{self, Measurement},
};

/// Cycles before any is counted: more than a sequence is long, and than the estimator remembers.
const WARM_UP: u32 = 24;
/// Cycles that are counted, each loss of the pattern as often as any other.
const COUNTED: u32 = 96;
/// Whether the control frame of a cycle is lost, over and over. Ten in a row let the longest sequence run out.
const LOST: [bool; 24] = {
    let mut lost = [false; 24];
    let mut at = 0;
    while at < lost.len() {
        lost[at] = matches!(at, 2 | 5 | 6 | 12..=21);
        at += 1;
    }
    lost
};
/// Most reference samples that are handed over at once.
const MOST_SAMPLES: usize = 1024;

/// Constants of both ends, and what the loop is told.
pub(super) struct Loop<const NX: usize, const NU: usize, const NY: usize, const NZ: usize> {
    pub(super) name: &'static str,
    pub(super) design: Design<'static, f32, NX, NU, NY>,
    pub(super) actuator: Settings<f32, NU>,
    /// What each tracked output is to be; handed over in every cycle, all samples that make a difference.
    pub(super) reference: [f32; NZ],
    /// Whether the controller is told what was played.
    pub(super) acknowledged: bool,
}

impl<const NX: usize, const NU: usize, const NY: usize, const NZ: usize> Loop<NX, NU, NY, NZ> {
    /// Runs the loop, and tells what each step took.
    pub(super) fn count<'m>(
        &'m self,
        (whole, of_whole): Memories<'m, NX, NU, NY>,
        apart: Memories<'m, NX, NU, NY>,
        clock: fn() -> u32,
        each: &mut dyn FnMut(Cost),
    ) {
        let mut watch = Stopwatch::new(clock);
        let start = Tick(0);
        let Ok(mut controller) = Controller::new(self.design, start, whole) else {
            panic!("the generated design does not fit its controller");
        };
        let mut actuator = Actuator::new(self.actuator, start, of_whole);
        let Some(mut steps) = Apart::new(&self.design, self.acknowledged, start, apart) else {
            panic!("there is less memory than the design takes");
        };
        let samples = self.design.preview.map_or(0, |preview| preview.samples());
        let reference: Vec<SVector<f32, NZ>, MOST_SAMPLES> =
            (0..samples.min(MOST_SAMPLES)).map(|_| SVector::from(self.reference)).collect();

        let (mut measured, mut sent, mut told) =
            ([0; FRAME_CAPACITY], [0; FRAME_CAPACITY], [0; FRAME_CAPACITY]);
        let mut acknowledgement: Option<Frame> = None;
        let mut state = self.design.model.initial_mean;
        for cycle in 0..WARM_UP + COUNTED {
            if cycle == WARM_UP {
                watch.start();
            }
            let tick = start + cycle;
            let output: SVector<f32, NY> = self.design.model.c * state;
            let Ok(measurement) = wire::encode_measurement(&Measurement { tick, output }, &mut measured)
            else {
                panic!("a measurement frame is longer than the buffer");
            };
            let frame = watch.time(Step::ControllerCycle, || {
                let controller = black_box(&mut controller);
                let _ = controller.receive(black_box(measurement));
                if let Some(acknowledgement) = black_box(&acknowledgement) {
                    let _ = controller.receive(acknowledgement);
                }
                if !reference.is_empty() {
                    let _ = controller.follow(black_box(&reference));
                }
                controller.cycle(&mut sent).ok().flatten()
            });
            let apart = steps.controller(&mut watch, measurement, acknowledgement.as_deref(), &reference);
            assert!(frame == apart.as_deref(), "the steps do not come to the controller's frame");

            let arrives = frame.filter(|_| !LOST[cycle as usize % LOST.len()]);
            // Cycles in which nothing arrives are shorter; a mean over both would say nothing of either.
            let told = match arrives {
                Some(frame) => watch.time(Step::ActuatorCycle, || {
                    let actuator = black_box(&mut actuator);
                    let _ = actuator.receive(black_box(frame));
                    play(actuator, &mut told)
                }),
                None => play(&mut actuator, &mut told),
            };
            let Some((input, told)) = told else { panic!("the actuator acknowledges every cycle") };
            let apart = steps.actuator(&mut watch, arrives);
            assert!(apart == input, "the steps do not come to the actuator's input");
            acknowledgement = if self.acknowledged { Frame::from_slice(told).ok() } else { None };
            // Some motion, the same in every run.
            let push = SVector::from_fn(|row, _| if cycle as usize % 7 == row { 1e-3 } else { 0.0 });
            state = self.design.model.a * state + self.design.model.b * input + push;
        }
        let length = self.design.gains.length();
        let dimensions = self.dimensions(length, self.design.merging != Merging::Single);
        for (step, time) in watch.times() {
            let multiply_adds = dimensions.multiply_adds(step);
            each(Cost { design: self.name, length, step: step.name(), time, multiply_adds });
        }
    }

    fn dimensions(&self, length: usize, apart: bool) -> Dimensions {
        Dimensions {
            states: NX,
            inputs: NU,
            outputs: NY,
            length,
            default_input: self.design.gains.default_input(),
            reference: self.design.preview.map_or(0, |preview| preview.samples() * preview.outputs()),
            triggered: self.design.trigger.is_some(),
            apart,
            acknowledged: self.acknowledged,
        }
    }
}

/// What the actuator applies, and its acknowledgement as bytes.
fn play<'b, const NU: usize>(
    actuator: &mut Actuator<'_, f32, NU>,
    buffer: &'b mut [u8],
) -> Option<(SVector<f32, NU>, &'b [u8])> {
    let applied = actuator.step();
    let told = actuator.acknowledgement(1)?;
    Some((applied.input, wire::encode_acknowledgement::<f32>(&told, buffer).ok()?))
}
