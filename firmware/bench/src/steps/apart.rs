//! The cycles of controller and actuator in pieces, each of them timed.
//!
//! They are put together here as [`slqg::controller::Controller`] and [`slqg::actuator::Actuator`] put them together; `run`
//! sees that both come to the same.

use super::stopwatch::{Step, Stopwatch};
use crate::scripted_link::{FRAME_CAPACITY, Frame};
use core::hint::black_box;
use heapless::Vec;
use slqg::{
    Tick,
    actuator::{Actuator, Age},
    controller::{Design, Law},
    estimator::{ModeFilter, Surroundings},
    event::Candidate,
    in_flight::InFlight,
    nalgebra::SVector,
    sequence::ControlSequence,
    tracking::Feedforward,
    wire,
};

/// What both ends are made of.
pub(super) struct Apart<
    'd,
    const NX: usize,
    const NU: usize,
    const NY: usize,
    const N: usize,
    const H: usize,
    const E: usize,
> {
    design: &'d Design<'static, f32, NX, NU, NY>,
    law: Law<'static, f32, NX, NU>,
    /// What the estimator's cycle is counted as.
    estimator: Step,
    next: Tick,
    filter: ModeFilter<f32, NX, NU, NY, N, H, E>,
    in_flight: InFlight<f32, NU, N, H>,
    feedforward: Feedforward<f32, NU, N>,
    actuator: Actuator<f32, NU, N>,
}

impl<'d, const NX: usize, const NU: usize, const NY: usize, const N: usize, const H: usize, const E: usize>
    Apart<'d, NX, NU, NY, N, H, E>
{
    pub(super) fn new(design: &'d Design<'static, f32, NX, NU, NY>, acknowledged: bool, start: Tick) -> Self {
        Self {
            design,
            law: design.law(),
            estimator: if acknowledged { Step::Estimator } else { Step::ModeFilter },
            next: start,
            filter: ModeFilter::new(design.model, design.measurement_buffer, start)
                .remembering(design.acknowledgement_buffer),
            in_flight: InFlight::default(),
            feedforward: Feedforward::default(),
            actuator: Actuator::new(design.actuator, start),
        }
    }

    /// The controller's cycle; its frame, if any is sent.
    pub(super) fn controller<const NZ: usize>(
        &mut self,
        watch: &mut Stopwatch,
        measurement: &[u8],
        acknowledgement: Option<&[u8]>,
        reference: &[SVector<f32, NZ>],
    ) -> Option<Frame> {
        let tick = self.next;
        self.next += 1;
        let decode = || wire::decode_measurement::<f32, NY>(black_box(measurement));
        let measurement = watch.time(Step::DecodeMeasurement, decode).ok()?;
        let told = acknowledgement.and_then(|frame| {
            let decode = || wire::decode_acknowledgement::<f32>(black_box(frame));
            watch.time(Step::DecodeAcknowledgement, decode).ok()
        });

        let Design { model, actuator, merging, preview, trigger, .. } = self.design;
        let Law { gains, arrives_at_once } = &self.law;
        let in_flight = &self.in_flight;
        let around = Surroundings {
            model,
            in_flight,
            actuator,
            gains,
            arrives_at_once: *arrives_at_once,
            merging: *merging,
        };
        watch.time(self.estimator, || {
            let (filter, around) = (black_box(&mut self.filter), black_box(&around));
            if filter.tick() != tick {
                filter.advance(around);
            }
            if let Some((told, age)) =
                black_box(&told).as_ref().and_then(|told| Some((told, told.ages.first()?)))
            {
                filter.acknowledge(told.tick, *age);
            }
            let _ = filter.measure(measurement.tick, measurement.output);
            filter.filter(around);
        });
        let modes = self.filter.modes()?;
        let input = |age| around.input(tick - 1, age, modes.held()).unwrap_or_else(SVector::zeros);
        match modes.known() {
            Some(age) => {
                let input = input(age);
                self.in_flight.acknowledge(age, input);
            }
            None => {
                let oldest = input(Age::Steps(N as u8 - 1));
                self.in_flight.believe(modes.clone(), oldest);
            }
        }

        let in_flight = &self.in_flight;
        let expected =
            watch.time(Step::ExpectedInputs, || black_box(in_flight).expected_inputs(black_box(gains)));
        let posterior_mean = self.filter.posterior_mean();
        let mut inputs: Vec<SVector<f32, NU>, N> = watch
            .time(Step::Law, || black_box(gains).sequence(black_box(posterior_mean), black_box(&expected)));
        if let Some(preview) = preview {
            let weigh = || black_box(preview).feedforward(black_box(reference));
            self.feedforward = watch.time(Step::Feedforward, weigh).ok()?;
        }
        self.feedforward.add_to(&mut inputs);
        let worth_sending = trigger.as_ref().is_none_or(|trigger| {
            let displaced = &self.feedforward.displaced;
            let candidate = Candidate { posterior_mean, expected: &expected, inputs: &inputs, displaced };
            let weigh =
                || black_box(trigger).benefit(black_box(gains), black_box(in_flight), black_box(candidate));
            trigger.is_worth_sending(watch.time(Step::Benefit, weigh))
        });
        let sequence = ControlSequence { tick, inputs };
        let mut buffer = [0; FRAME_CAPACITY];
        let free = &mut buffer[..];
        let frame = watch
            .time(Step::EncodeControl, || wire::encode_control(black_box(&sequence), black_box(free)))
            .ok()?;
        let frame = Frame::from_slice(frame).ok().filter(|_| worth_sending);
        self.in_flight.push(worth_sending.then_some(sequence));
        frame
    }

    /// The actuator's cycle; the input it applies.
    pub(super) fn actuator(&mut self, watch: &mut Stopwatch, frame: Option<&[u8]>) -> SVector<f32, NU> {
        let Some(frame) = frame else { return self.actuator.step().input };
        let decode = || wire::decode_control::<f32, NU, N>(black_box(frame));
        let sequence = watch.time(Step::DecodeControl, decode).ok();
        let (applied, _) = watch.time(Step::PlayOut, || {
            let actuator = black_box(&mut self.actuator);
            if let Some(sequence) = black_box(&sequence) {
                let _ = actuator.offer(sequence.clone());
            }
            (actuator.step(), actuator.acknowledgement(1))
        });
        applied.input
    }
}
