//! A controller that takes frames whose checksums are right: what it sends is finite and is taken by its actuator, and a frame that it
//! does not take changes nothing.
//!
//! Beside it runs a twin that is handed only the frames that were taken, or that told of a sensor; both must do the same, bit by bit.

use crate::plant::{LENGTH, Room, Workshop};
use crate::script::{any_bytes, any_frame, byte, number, tick_near, up_to, vector, whole};
use arbitrary::{Result, Unstructured};
use slqg::actuator::{Actuator, memory_len};
use slqg::controller::{Controller, Counts, RejectedFrame};
use slqg::estimator::Plausibility;
use slqg::nalgebra::SVector;
use slqg::tracking::Feedforward;
use slqg::wire::{self, Acknowledgement, MOST_AGES, Measurement};
use slqg::{Age, Scalar, Tick};

/// Bytes of a frame and room for more.
const BUFFER: usize = 64;

/// Plays a script: the first bytes say which loop it is, the others what happens to it.
pub fn check(bytes: &[u8]) {
    let mut script = Unstructured::new(bytes);
    // A script that ends early has ended.
    let _ = match script.arbitrary() {
        Ok(true) => play::<f64>(&mut script),
        _ => play::<f32>(&mut script),
    };
}

fn play<T: Scalar>(script: &mut Unstructured<'_>) -> Result<()> {
    let workshop = Workshop::<T>::read(script)?;
    let design = workshop.design();
    // Near the wrap.
    let start = tick_near(script, Tick(0))?;
    let mut rooms = [Room::new(design.sizes()), Room::new(design.sizes())];
    let [one, other] = &mut rooms;
    let mut pair = Pair {
        controller: Controller::new(design, start, one.lend()).expect("a design that fits"),
        twin: Controller::new(design, start, other.lend()).expect("a design that fits"),
        watches: *design.plausibility != Plausibility::NONE,
    };
    let mut memory = [SVector::zeros(); memory_len(LENGTH)];
    let mut actuator = Actuator::new(workshop.settings, start, &mut memory);
    while !script.is_empty() {
        let now = pair.controller.tick();
        match up_to(script, 9)? {
            0..=2 => {
                let is_lost = byte(script)? & 1 == 1;
                if let Some(frame) = pair.cycle()
                    && !is_lost
                {
                    actuator.receive(&frame).expect("it is made in this cycle, for this actuator");
                }
                let applied = actuator.step();
                assert!(applied.input.iter().all(|value| value.is_finite()));
                pair.compare();
            }
            3 => {
                let told = actuator.acknowledgement(up_to(script, 8)?.into());
                if let Some(told) = told {
                    let mut buffer = [0; BUFFER];
                    pair.receive(
                        wire::encode_acknowledgement::<T>(&told, &mut buffer).expect("there is room"),
                    );
                }
            }
            4 => {
                let measurement =
                    Measurement::<T, 1> { tick: tick_near(script, now)?, output: vector(script)? };
                let mut buffer = [0; BUFFER];
                pair.receive(wire::encode_measurement(&measurement, &mut buffer).expect("there is room"));
            }
            5 => {
                // In time, and about where the plant may be.
                let output = SVector::<T, 1>::repeat(T::nearest(f64::from(script.arbitrary::<i8>()?) / 16.0));
                let measurement = Measurement { tick: now, output };
                let mut buffer = [0; BUFFER];
                pair.receive(wire::encode_measurement(&measurement, &mut buffer).expect("there is room"));
            }
            6 => {
                let tick = tick_near(script, now)?;
                let ages = (0..=up_to(script, MOST_AGES as u8 - 1)?).map(|_| {
                    Ok(match up_to(script, LENGTH as u8 + 1)? {
                        0 => Age::Empty,
                        steps => Age::Steps(steps - 1),
                    })
                });
                let told = Acknowledgement { tick, ages: ages.collect::<Result<_>>()? };
                let mut buffer = [0; BUFFER];
                pair.receive(wire::encode_acknowledgement::<T>(&told, &mut buffer).expect("there is room"));
            }
            7 => pair.receive(&any_frame(script, now)?),
            8 => pair.receive(&whole(any_bytes(script)?)),
            _ => {
                // What is committed is lost.
                if pair.decides(script)? {
                    actuator.step();
                }
            }
        }
    }
    Ok(())
}

/// A controller and its twin.
struct Pair<'m, T: Scalar> {
    controller: Controller<'m, T, 2, 1, 1>,
    twin: Controller<'m, T, 2, 1, 1>,
    /// Whether they watch their sensor.
    watches: bool,
}

impl<T: Scalar> Pair<'_, T> {
    fn receive(&mut self, frame: &[u8]) {
        let rejected = self.controller.counts().rejected_frames;
        let taken = self.controller.receive(frame);
        assert_eq!(self.controller.counts().rejected_frames, rejected + u32::from(taken.is_err()));
        match taken {
            Ok(()) => assert_eq!(self.twin.receive(frame), taken),
            // Whoever watches sensors is told by a reading that the estimator does not take, too.
            Err(RejectedFrame::Implausible | RejectedFrame::Measurement(_)) if self.watches => {
                assert_eq!(self.twin.receive(frame), taken);
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }

    /// Runs a cycle of both; the frame that is sent.
    fn cycle(&mut self) -> Option<Vec<u8>> {
        let tick = self.controller.tick();
        let mut buffers = [[0; BUFFER], [0; BUFFER]];
        let [one, other] = &mut buffers;
        let frame = self.controller.cycle(one).expect("there is room");
        assert_eq!(self.twin.cycle(other).expect("there is room"), frame, "the twin sends the same");
        let frame = frame?;
        let mut room = [SVector::<T, 1>::zeros(); LENGTH];
        let sequence = wire::decode_control(frame, &mut room).expect("a frame of the loop, and finite");
        assert_eq!((sequence.tick, sequence.inputs.len()), (tick, LENGTH));
        Some(frame.to_vec())
    }

    /// What whoever decides more than the core does may do; whether the cycle is over.
    fn decides(&mut self, script: &mut Unstructured<'_>) -> Result<bool> {
        let (choice, number) = (byte(script)?, number::<T>(script)?);
        for controller in [&mut self.controller, &mut self.twin] {
            match choice % 4 {
                0 => {
                    let proposed = controller.propose().sequence.inputs.len();
                    assert_eq!(proposed, LENGTH);
                }
                1 => {
                    let replaced = controller.replace(&[SVector::repeat(number); LENGTH]).is_ok();
                    assert_eq!(replaced, number.is_finite());
                }
                2 => {
                    let inputs = [SVector::repeat(number)];
                    let feedforward = Feedforward { inputs: &inputs, displaced: &[] };
                    assert_eq!(controller.set_feedforward(feedforward).is_ok(), number.is_finite());
                }
                _ => controller.commit(choice & 0x80 != 0),
            }
        }
        Ok(choice % 4 == 3)
    }

    fn compare(&self) {
        let told = |controller: &Controller<'_, T, 2, 1, 1>| {
            let mean = controller.estimator().posterior_mean().map(|value| value.widen().to_bits());
            let covariance =
                controller.estimator().posterior_covariance().map(|value| value.widen().to_bits());
            let counts = Counts { rejected_frames: 0, ..controller.counts() };
            (controller.tick(), mean, covariance, counts, controller.health())
        };
        assert_eq!(told(&self.controller), told(&self.twin));
        let estimate = self.controller.estimator();
        assert!(estimate.posterior_mean().iter().all(|value| value.is_finite()), "a state that is one");
        // Kept are factors, whose squares may be beyond the scalar's range: a variance may be infinite, but never no number.
        let variances = estimate.posterior_covariance().diagonal();
        assert!(variances.iter().all(|variance| *variance >= T::zero()), "variances");
    }
}
