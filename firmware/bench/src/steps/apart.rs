//! The cycles of controller and actuator in pieces, each of them timed.
//!
//! They are put together here as [`slqg::controller::Controller`] and [`slqg::actuator::Actuator`] put them together; `run`
//! sees that both come to the same.

use super::stopwatch::{Step, Stopwatch};
use crate::scripted_link::{FRAME_CAPACITY, Frame};
use core::hint::black_box;
use slqg::{
    Tick,
    actuator::Actuator,
    controller::{Design, Law, Memory},
    estimator::{ModeFilter, Remembered, Surroundings},
    event::{Candidate, Trigger},
    in_flight::InFlight,
    nalgebra::SVector,
    played::{Age, Played},
    tracking::Feedforward,
    wire,
};

/// Most inputs of a sequence.
const LONGEST: usize = 16;

/// What a controller and an actuator are lent.
pub(super) type Memories<'m, const NX: usize, const NU: usize, const NY: usize> =
    (Memory<'m, f32, NX, NU, NY>, &'m mut [SVector<f32, NU>]);

/// What both ends are made of.
pub(super) struct Apart<'m, const NX: usize, const NU: usize, const NY: usize> {
    design: &'m Design<'static, f32, NX, NU, NY>,
    law: Law<'static, f32, NX, NU>,
    /// What the estimator's cycle is counted as.
    estimator: Step,
    next: Tick,
    filter: ModeFilter<'m, f32, NX, NU, NY>,
    in_flight: InFlight<'m, f32, NU>,
    expected: &'m mut [SVector<f32, NU>],
    forward: &'m mut [SVector<f32, NU>],
    displaced: &'m mut [SVector<f32, NU>],
    room: &'m mut [SVector<f32, NU>],
    numbers: &'m mut [f32],
    actuator: Actuator<'m, f32, NU>,
}

impl<'m, const NX: usize, const NU: usize, const NY: usize> Apart<'m, NX, NU, NY> {
    /// `None` if there is less memory than the design takes.
    pub(super) fn new(
        design: &'m Design<'static, f32, NX, NU, NY>,
        acknowledged: bool,
        start: Tick,
        (memory, of_actuator): Memories<'m, NX, NU, NY>,
    ) -> Option<Self> {
        let (length, sizes) = (design.gains.length(), design.sizes());
        let Memory { cycles, estimates, ages, sent, inputs } = memory;
        let of_trigger = design.trigger.as_ref().map_or(0, Trigger::numbers_len);
        let (numbers, ages) = ages.split_at_mut_checked(of_trigger)?;
        let remembered = Remembered::new(cycles, ages, estimates, length, design.merging.estimates(length))?;
        let (inputs, rest) = inputs.split_at_mut_checked(sizes.sent * length)?;
        let (expected, rest) = rest.split_at_mut_checked(length)?;
        let (forward, rest) = rest.split_at_mut_checked(length)?;
        let (displaced, room) = rest.split_at_mut_checked(length)?;
        Some(Self {
            design,
            law: design.law(),
            estimator: if acknowledged { Step::Estimator } else { Step::ModeFilter },
            next: start,
            filter: ModeFilter::new(design.model, design.measurement_buffer, start, remembered),
            in_flight: InFlight::new(length, start, sent, inputs),
            expected,
            forward,
            displaced,
            room,
            numbers,
            actuator: Actuator::new(design.actuator, start, of_actuator),
        })
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

        let Design { model, actuator, merging, plausibility, preview, trigger, .. } = self.design;
        let Law { gains, arrives_at_once } = &self.law;
        let in_flight = &self.in_flight;
        let around = Surroundings {
            model,
            in_flight,
            actuator,
            gains,
            arrives_at_once: *arrives_at_once,
            merging: *merging,
            plausibility,
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
        let input = |age| around.applied(tick - 1, age, &modes).unwrap_or_else(SVector::zeros);
        let played = match modes.known() {
            Some(age) => Played::Known(age, input(age)),
            None => {
                let last = gains.length() - 1;
                Played::Believed { modes, oldest: input(u8::try_from(last).map_or(Age::Empty, Age::Steps)) }
            }
        };

        let expected: &[_] = watch.time(Step::ExpectedInputs, || {
            let (in_flight, gains) = (black_box(&self.in_flight), black_box(gains));
            in_flight.fill_expected(gains, black_box(&played), black_box(self.expected))
        });
        let posterior_mean = self.filter.posterior_mean();
        let inputs = self.in_flight.candidate();
        watch.time(Step::Law, || {
            let (mean, expected) = (black_box(posterior_mean), black_box(expected));
            black_box(gains).fill_sequence(mean, expected, black_box(&mut *inputs));
        });
        let mut added = Feedforward::NONE;
        if let Some(preview) = preview {
            added = watch
                .time(Step::Feedforward, || {
                    let (forward, displaced) =
                        (black_box(&mut *self.forward), black_box(&mut *self.displaced));
                    black_box(preview).fill_feedforward(black_box(reference), forward, displaced)
                })
                .ok()?;
        }
        inputs.iter_mut().zip(added.inputs).for_each(|(input, added)| *input += added);
        let in_flight = &self.in_flight;
        let sequence = in_flight.proposed();
        let worth_sending = trigger.as_ref().is_none_or(|trigger| {
            let Feedforward { displaced, .. } = added;
            let candidate =
                Candidate { posterior_mean, expected, inputs: sequence.inputs, displaced, played };
            let benefit = watch.time(Step::Benefit, || {
                let (gains, in_flight) = (black_box(gains), black_box(in_flight));
                black_box(trigger).benefit(
                    gains,
                    in_flight,
                    black_box(&candidate),
                    black_box(&mut *self.room),
                    black_box(&mut *self.numbers),
                )
            });
            trigger.is_worth_sending(benefit)
        });
        let mut buffer = [0; FRAME_CAPACITY];
        let free = &mut buffer[..];
        let frame = watch
            .time(Step::EncodeControl, || wire::encode_control(black_box(&sequence), black_box(free)))
            .ok()?;
        let frame = Frame::from_slice(frame).ok().filter(|_| worth_sending);
        self.in_flight.push(worth_sending);
        frame
    }

    /// The actuator's cycle; the input it applies.
    pub(super) fn actuator(&mut self, watch: &mut Stopwatch, frame: Option<&[u8]>) -> SVector<f32, NU> {
        let Some(frame) = frame else { return self.actuator.step().input };
        let mut coming = [SVector::<f32, NU>::zeros(); LONGEST];
        let coming = &mut coming[..];
        let sequence = watch
            .time(Step::DecodeControl, || wire::decode_control(black_box(frame), black_box(coming)))
            .ok();
        let (applied, _) = watch.time(Step::PlayOut, || {
            let actuator = black_box(&mut self.actuator);
            if let Some(sequence) = black_box(&sequence) {
                let _ = actuator.offer(sequence);
            }
            (actuator.step(), actuator.acknowledgement(1))
        });
        applied.input
    }
}
