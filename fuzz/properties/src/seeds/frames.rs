//! Frames as they go over a link.

use super::Seed;
use slqg::nalgebra::SVector;
use slqg::played::Applied;
use slqg::sequence::ControlSequence;
use slqg::wire::{
    self, Acknowledgement, Clock, GainsAnswer, GainsPart, Measurement, Question, Ran, Reference, Role,
    Service, Status, Tuned, TuningStep, Verdict, serial,
};
use slqg::{Age, Scalar, Tick};

const BUFFER: usize = 128;

pub(super) fn measurement<T: Scalar, const NY: usize>(tick: Tick, output: [f64; NY]) -> Vec<u8> {
    let output = SVector::from(output).map(T::nearest);
    wire::encode_measurement(&Measurement { tick, output }, &mut [0; BUFFER]).expect("there is room").to_vec()
}

pub(super) fn control<T: Scalar, const NU: usize>(tick: Tick, inputs: &[[f64; NU]]) -> Vec<u8> {
    let inputs: Vec<_> = inputs.iter().map(|input| SVector::from(*input).map(T::nearest)).collect();
    let sequence = ControlSequence { tick, inputs: &inputs };
    wire::encode_control(&sequence, &mut [0; BUFFER]).expect("there is room").to_vec()
}

pub(super) fn acknowledgement<T: Scalar>(tick: Tick, ages: &[Age]) -> Vec<u8> {
    let told = Acknowledgement { tick, ages: ages.iter().copied().collect() };
    wire::encode_acknowledgement::<T>(&told, &mut [0; BUFFER]).expect("there is room").to_vec()
}

/// A frame of each kind and scalar.
pub(super) fn of_the_loop() -> Vec<Seed> {
    let ages = [Age::Steps(0), Age::Empty, Age::Steps(3)];
    vec![
        ("measurement_f32", measurement::<f32, 2>(Tick(7), [1.5, -0.25])),
        ("measurement_f64", measurement::<f64, 1>(Tick(u32::MAX), [1e-300])),
        ("control_f32", control::<f32, 1>(Tick(8), &[[1.0], [0.5], [0.25]])),
        ("control_f64", control::<f64, 2>(Tick(1 << 31), &[[1.0, -1.0], [0.0, 2.0]])),
        ("control_without_inputs", control::<f32, 1>(Tick(9), &[])),
        ("acknowledgement_f32", acknowledgement::<f32>(Tick(8), &ages)),
        ("acknowledgement_f64", acknowledgement::<f64>(Tick(0), &ages[..1])),
    ]
}

/// Lines with frames, and with what is none.
pub(super) fn on_a_line() -> Vec<Seed> {
    let line = |frame: &[u8]| serial::stuff(frame, &mut [0; BUFFER]).expect("there is room").to_vec();
    let frame = measurement::<f32, 2>(Tick(7), [1.5, -0.25]);
    let whole = line(&frame);
    vec![
        ("frame", frame),
        ("begun_in_the_middle", [&whole[5..], &whole[..]].concat()),
        ("cut_off", [&whole[..9], &[0], &whole[..]].concat()),
        ("zeros", vec![0; 5]),
        ("longest_block", line(&[7; 100])),
        ("code_beyond_the_end", vec![200, 1, 2, 0, 255, 3, 0]),
    ]
}

/// A frame of each kind between a node and its host.
pub(super) fn of_a_host() -> Vec<Seed> {
    fn fixed<S: Service>(tick: u32, service: &S) -> Vec<u8> {
        wire::encode_service::<f32, S>(Tick(tick), service, &mut [0; BUFFER]).expect("there is room").to_vec()
    }
    let status = Status {
        role: Role::Actuator,
        cycles: 1000,
        realigned: 1,
        rejected: 2,
        overruns: 3,
        stack: 4096,
        variables: u32::MAX,
    };
    let applied = Applied { tick: Tick(5), input: SVector::from([1.5_f32]), age: Age::Steps(2) };
    let applied = wire::encode_applied(&applied, &mut [0; BUFFER]).expect("there is room").to_vec();
    let samples = [[1.0, 2.0], [3.0, 4.0]].map(|sample: [f64; 2]| SVector::from(sample));
    let reference = Reference::<f64, 2, 4> { tick: Tick(9), samples: samples.into_iter().collect() };
    let reference = wire::encode_reference(&reference, &mut [0; BUFFER]).expect("there is room").to_vec();
    let part = GainsPart { transfer: 3, offset: 4, total: 10, bytes: &[1, 2, 3, 4, 5, 6] };
    let part = wire::encode_gains_part::<f32>(&part, &mut [0; BUFFER]).expect("there is room").to_vec();
    vec![
        ("clock", fixed(7, &Clock { begins: true, period_us: 20_000 })),
        ("ran", fixed(7, &Ran { sent: false, duration: 12_345 })),
        ("answer", fixed(3, &GainsAnswer { received: 10, verdict: Verdict::InForce })),
        ("question", fixed(0, &Question {})),
        ("status", fixed(1000, &status)),
        ("tuned", fixed(7, &Tuned { step: TuningStep::Switched, steps: 17, value: 0.5 })),
        ("applied", applied),
        ("reference", reference),
        ("part_of_gains", part),
    ]
}
