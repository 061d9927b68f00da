//! What comes of a sensor that errs: a loop that is to survive it survives, and what it cannot survive it tells.

#[path = "random/dice.rs"]
mod dice;
mod lent;
#[allow(dead_code, unreachable_pub)]
mod pendulum {
    include!("../../../gain-gen/tests/generated/pendulum.rs");
}

use dice::Dice;
use pendulum::{ACTUATOR, DESIGN, MODEL, PLAUSIBILITY, SEQUENCE_LENGTH};
use slqg::Tick;
use slqg::controller::Design;
use slqg::estimator::Plausibility;
use slqg::nalgebra::SVector;
use slqg::wire::{self, Measurement};

const RUNS: u64 = 200;
/// The cycle in which a sensor begins to err.
const BEGIN: usize = 100;
/// Cycles that are looked at after it has ended.
const AFTER: usize = 200;
/// Beyond this angle, in radians, the rod has fallen.
const FALLEN: f64 = 0.5;

type Output = SVector<f32, 2>;

/// What is wrong, and for how many cycles.
#[derive(Debug, Clone, Copy)]
enum Fault {
    None,
    /// The angle reads this.
    Reads(f32, usize),
    /// The frame's numbers are none.
    NoNumber(usize),
    /// The angle is not measured.
    Missing(usize),
    /// The position, or the angle, reads what it read before.
    Stuck(usize, usize),
    /// The angle reads its negative.
    SwappedSign(usize),
    /// The angle reads this much too large.
    Offset(f32, usize),
    /// The rod is pushed, by this angle: the sensors are right.
    Pushed(f64),
}

impl Fault {
    fn name(self) -> String {
        match self {
            Self::None => "nothing".into(),
            Self::Reads(reading, cycles) => format!("angle reads {reading:e} rad for {cycles}"),
            Self::NoNumber(cycles) => format!("no numbers for {cycles}"),
            Self::Missing(cycles) => format!("angle not measured for {cycles}"),
            Self::Stuck(0, cycles) => format!("position stuck for {cycles}"),
            Self::Stuck(_, cycles) => format!("angle stuck for {cycles}"),
            Self::SwappedSign(cycles) => format!("angle's wire swapped for {cycles}"),
            Self::Offset(by, cycles) => format!("angle {by} rad too large for {cycles}"),
            Self::Pushed(by) => format!("rod pushed by {by} rad"),
        }
    }

    fn cycles(self) -> usize {
        match self {
            Self::None => 0,
            Self::Pushed(_) => 1,
            Self::Reads(_, cycles)
            | Self::NoNumber(cycles)
            | Self::Missing(cycles)
            | Self::Stuck(_, cycles)
            | Self::SwappedSign(cycles)
            | Self::Offset(_, cycles) => cycles,
        }
    }

    fn read(self, mut right: Output, before: Output) -> Output {
        match self {
            Self::None | Self::Pushed(_) => (),
            Self::Reads(reading, _) => right[1] = reading,
            Self::NoNumber(_) => right.fill(f32::NAN),
            Self::Missing(_) => right[1] = f32::NAN,
            Self::Stuck(output, _) => right[output] = before[output],
            Self::SwappedSign(_) => right[1] = -right[1],
            Self::Offset(by, _) => right[1] += by,
        }
        right
    }
}

/// What came of it in all runs.
#[derive(Debug, Default)]
struct Outcome {
    fallen: usize,
    /// Runs in which it was told before the rod fell, at all.
    told: usize,
    /// Largest angle of those that did not fall, in radians.
    largest: f64,
}

fn normal(dice: &mut Dice) -> f64 {
    (0..12).map(|_| dice.roll()).sum::<f64>() - 6.0
}

/// One run over a link on which a tenth of the measurements is lost, and a control packet in ten.
fn run(plausibility: &'static Plausibility<f32, 2>, fault: Fault, seed: u64, outcome: &mut Outcome) {
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15 ^ (seed + 1).wrapping_mul(0xD134_2543_DE82_EF95));
    let design = Design { plausibility, ..DESIGN };
    let mut controller = lent::controller(design, Tick(0)).expect("a design that fits");
    let mut actuator = lent::actuator(ACTUATOR, Tick(0), SEQUENCE_LENGTH);
    let model = (MODEL.a.map(f64::from), MODEL.b.map(f64::from), MODEL.c.map(f64::from));
    let deviation = |variance: f32| f64::from(variance).sqrt();
    let mut state = MODEL.initial_mean.map(f64::from);
    let (mut before, mut was_told) = (Output::zeros(), false);
    let mut largest: f64 = 0.0;
    let mut buffer = [0; 64];
    let end = BEGIN + fault.cycles();
    for cycle in 0..end + AFTER {
        let is_wrong = (BEGIN..end).contains(&cycle);
        if let (Fault::Pushed(by), true) = (fault, is_wrong) {
            state[2] += by;
        }
        let noise =
            MODEL.measurement_noise.diagonal().map(|variance| deviation(variance) * normal(&mut dice));
        let right = (model.2 * state + noise).map(|value| value as f32);
        let output = if is_wrong { fault.read(right, before) } else { right };
        before = output;
        if dice.roll() < 0.9 {
            let measurement = Measurement { tick: controller.tick(), output };
            // What is refused is as good as lost.
            let _ = match fault {
                // A frame says of no output that it is not measured.
                Fault::Missing(_) => controller.measured(&measurement),
                _ => {
                    let frame = wire::encode_measurement(&measurement, &mut buffer).expect("there is room");
                    controller.receive(frame)
                }
            };
        }
        if let Some(frame) = controller.cycle(&mut buffer).expect("there is room")
            && dice.roll() < 0.9
        {
            actuator.receive(frame).expect("newer than the one before");
        }
        // Once it has been told an application may stop; here it goes on.
        was_told |= is_wrong && !controller.health().is_nominal();
        let applied = actuator.step();
        let told = actuator.acknowledgement(1).expect("it has played");
        controller.acknowledged(&told).expect("it was sent");
        let noise = MODEL.process_noise.diagonal().map(|variance| deviation(variance) * normal(&mut dice));
        state = model.0 * state + model.1 * f64::from(applied.input[0]) + noise;
        largest = if cycle < BEGIN { 0.0 } else { largest.max(state[2].abs()) };
        if state[2].is_nan() || state[2].abs() > FALLEN {
            outcome.fallen += 1;
            outcome.told += usize::from(was_told);
            return;
        }
    }
    outcome.told += usize::from(was_told);
    outcome.largest = outcome.largest.max(largest);
}

fn outcome(plausibility: &'static Plausibility<f32, 2>, fault: Fault) -> Outcome {
    let mut outcome = Outcome::default();
    (0..RUNS).for_each(|seed| run(plausibility, fault, seed, &mut outcome));
    outcome
}

/// Believes all that is a number.
static CREDULOUS: Plausibility<f32, 2> = Plausibility::NONE;
/// Judges more sharply, and knows besides what its sensors can read, and that they are never quite still.
static INFORMED: Plausibility<f32, 2> = Plausibility {
    // The quantile of the chi-square distribution with one degree of freedom at 1 - 1e-9.
    gate: Some(37.324894),
    range: Some([[-20.0, 20.0], [-0.6, 0.6]]),
    stuck_after: [3, 3],
    rejects_stuck: true,
    ..PLAUSIBILITY
};

const FAULTS: [Fault; 24] = [
    Fault::None,
    Fault::Reads(0.1, 1),
    Fault::Reads(10.0, 1),
    Fault::Reads(10.0, 3),
    Fault::Reads(10.0, 10),
    Fault::Reads(1e37, 1),
    Fault::Reads(1e37, 10),
    Fault::NoNumber(1),
    Fault::NoNumber(10),
    Fault::Stuck(0, 10),
    Fault::Stuck(0, 100),
    Fault::Stuck(0, 1000),
    Fault::Missing(10),
    Fault::Missing(100),
    Fault::Stuck(1, 10),
    Fault::Stuck(1, 100),
    Fault::Stuck(1, 1000),
    Fault::SwappedSign(10),
    Fault::SwappedSign(1000),
    Fault::Offset(0.02, 10),
    Fault::Offset(0.05, 1000),
    Fault::Pushed(0.02),
    Fault::Pushed(0.05),
    Fault::Pushed(0.1),
];

const PAGE: &str = include_str!("../../../docs/sensor-faults.md");

/// Largest angle of the runs in which the rod stands, if it does in any.
fn angle(outcome: &Outcome) -> String {
    if outcome.fallen as u64 == RUNS { "-".into() } else { format!("{:.3}", outcome.largest) }
}

#[test]
fn the_page_shows_what_comes_of_each_fault() {
    let mut missing = Vec::new();
    for fault in FAULTS {
        let [before, gated, informed] =
            [&CREDULOUS, &PLAUSIBILITY, &INFORMED].map(|plausibility| outcome(plausibility, fault));
        let told =
            |outcome: &Outcome| format!("{:7} {:>6} {:4}", outcome.fallen, angle(outcome), outcome.told);
        let line = format!(
            "    {:40} {:4} {:>6} {} {}",
            fault.name(),
            before.fallen,
            angle(&before),
            told(&gated),
            told(&informed)
        );
        println!("{line}");
        if !PAGE.lines().any(|other| other == line) {
            missing.push(line);
        }
    }
    assert!(missing.is_empty(), "not in docs/sensor-faults.md:\n{}", missing.join("\n"));
}

#[test]
fn readings_that_are_far_off_and_pushes_lose_no_run() {
    for fault in [Fault::Reads(10.0, 1), Fault::Reads(10.0, 3), Fault::Reads(1e37, 10), Fault::Pushed(0.1)] {
        let Outcome { fallen, largest, .. } = outcome(&PLAUSIBILITY, fault);
        assert!(fallen == 0 && largest < 0.2, "{fault:?}: {fallen} fall, {largest} rad");
    }
}
