//! The law in C is compiled under the names and sizes of designs, and run: it does what the core does, to the bit, over many cycles with lost, late and
//! invented acknowledgements.

mod c_compiler;
mod draws;
mod lent;

use c_compiler::{STRICT, answer, compile, compilers, emitted, solved};
use draws::Draws;
use gain_gen::report::Report;
use slqg::Age;
use slqg::actuator::{Limits, Settings};
use slqg::gains::{Gains, Tables};
use slqg::in_flight::InFlight;
use slqg::nalgebra::{DMatrix, SVector};
use slqg::played::Played;
use slqg::{DefaultInput, Scalar, Tick};

const CYCLES: usize = 1000;
/// Close to where ticks wrap.
const FIRST_TICK: Tick = Tick(u32::MAX - 300);

/// Runs a law on cycles read from stdin and prints what it does, a line a cycle.
const DRIVER: &str = include_str!("c_compiler/driver.c");

/// What becomes of a cycle's sequence.
#[derive(Debug, Clone, Copy)]
enum Action {
    Sent,
    Unsent,
    Skipped,
}

/// A cycle as the driver reads it.
struct Cycle<T: Scalar, const NX: usize> {
    acknowledgement: Option<Age>,
    action: Action,
    state: SVector<T, NX>,
}

impl<T: Scalar, const NX: usize> Cycle<T, NX> {
    fn drawn(draws: &mut Draws, length: usize) -> Self {
        let acknowledgement = match draws.below(8) {
            0 => None,
            1 => Some(Age::Empty),
            // Not always a sequence that was sent, or could have been.
            2 => Some(Age::Steps(draws.below(255) as u8)),
            _ => Some(Age::Steps(draws.below(length) as u8)),
        };
        let action = match draws.below(8) {
            0 => Action::Unsent,
            1 => Action::Skipped,
            _ => Action::Sent,
        };
        // Now and then beyond what a sequence can hold.
        let scale = match draws.below(64) {
            0 => T::nearest(f64::INFINITY),
            1 => T::nearest(f64::from(f32::MAX)),
            _ => T::nearest(10.0),
        };
        Self { acknowledgement, action, state: draws.vector() * scale }
    }

    fn line(&self) -> String {
        let age = match self.acknowledgement {
            None => 256,
            Some(Age::Empty) => 255,
            Some(Age::Steps(steps)) => steps.into(),
        };
        format!("{age} {}{}\n", self.action as u8, hex(&self.state))
    }
}

/// Entries as bit patterns, each after a space.
fn hex<T: Scalar, const D: usize>(vector: &SVector<T, D>) -> String {
    let bits = |value: &T| match T::BYTES {
        4 => format!(" {:x}", (value.widen() as f32).to_bits()),
        _ => format!(" {:x}", value.widen().to_bits()),
    };
    vector.iter().map(bits).collect()
}

/// The core's law over the same cycles, with the state given: what is not acknowledged is held to have played on.
struct Core<'g, T: Scalar, const NX: usize, const NU: usize> {
    gains: &'g Gains<'g, T, NX, NU>,
    actuator: Settings<T, NU>,
    tick: Tick,
    in_flight: InFlight<'g, T, NU>,
    /// What is held to have been played in the last cycle.
    played: (Age, SVector<T, NU>),
    /// The input of the cycle before the last.
    held: SVector<T, NU>,
}

impl<T: Scalar, const NX: usize, const NU: usize> Core<'_, T, NX, NU> {
    /// What was applied in cycle `tick`, if its age is believed.
    fn applied(&self, tick: Tick, age: Age) -> Option<SVector<T, NU>> {
        let input = self.in_flight.applied_input(self.actuator.default_input, tick, age, &self.held)?;
        Some(self.actuator.saturate(&input))
    }

    fn set_played(&mut self, age: Age, input: SVector<T, NU>) {
        self.played = (age, input);
    }

    fn cycle(&mut self, cycle: &Cycle<T, NX>) -> String {
        let applied =
            cycle.acknowledgement.map(|age| self.applied(self.tick - 1, age).map(|input| (age, input)));
        if let Some(Some((age, input))) = applied {
            self.set_played(age, input);
        }
        let believed = applied.map_or(2, |applied| u8::from(applied.is_some()));
        let mut line = format!("{believed}{}", hex(&self.played.1));
        let mut is_sent = false;
        if !matches!(cycle.action, Action::Skipped) {
            let mut room = vec![SVector::zeros(); self.gains.length()];
            let played = Played::Known(self.played.0, self.played.1);
            let expected = self.in_flight.fill_expected(self.gains, &played, &mut room);
            self.gains.fill_sequence(&cycle.state, expected, self.in_flight.candidate());
            let sequence = self.in_flight.proposed();
            if sequence.is_finite() {
                line.push_str(" finite");
                line.extend(sequence.inputs.iter().map(hex));
                is_sent = matches!(cycle.action, Action::Sent);
            } else {
                line.push_str(" not finite");
            }
        }
        self.in_flight.push(is_sent);
        self.held = self.played.1;
        let age = played_on(self.played.0, self.gains.length());
        let input = self.applied(self.tick, age).unwrap_or_else(SVector::zeros);
        self.set_played(age, input);
        self.tick += 1;
        line
    }
}

/// The age one cycle later if nothing newer arrives, for sequences of `length` inputs: the C law goes by it.
fn played_on(age: Age, length: usize) -> Age {
    match age {
        Age::Steps(steps) if usize::from(steps) + 1 < length => Age::Steps(steps + 1),
        _ => Age::Empty,
    }
}

fn rounded<T: Scalar>(values: &[f64]) -> Vec<T> {
    values.iter().map(|&value| T::nearest(value)).collect()
}

fn row_major<T: Scalar>(matrix: &DMatrix<f64>) -> Vec<T> {
    rounded(matrix.transpose().as_slice())
}

fn settings<T: Scalar, const NU: usize>(report: &Report) -> Settings<T, NU> {
    let settings = &report.design.controller;
    let limits = settings.input_limits.as_ref().map(|pairs| Limits {
        rate: None,
        min: SVector::from_fn(|input, _| T::nearest(pairs[input].0)),
        max: SVector::from_fn(|input, _| T::nearest(pairs[input].1)),
    });
    Settings { default_input: settings.default_input, limits, safe: None }
}

/// Compiles the law of `report` strictly, and again as a compiler likes it best, and runs it beside the core.
macro_rules! does_what_the_core_does {
    ($report:expr, $scalar:ty, $nx:literal, $nu:literal, $n:literal) => {{
        let report = $report;
        let law = &report.solution.law;
        let (lx, m, arrival) = (row_major(&law.lx), row_major(&law.m), rounded(&law.arrival));
        let tables = Tables::check(&lx, &m, &arrival).unwrap();
        let gains = Gains::<$scalar, $nx, $nu>::check(law.length, law.default_input, tables).unwrap();
        meets::<$scalar, $nx, $nu, $n>(&report, &gains);
    }};
}

fn meets<T: Scalar, const NX: usize, const NU: usize, const N: usize>(
    report: &Report,
    gains: &Gains<'_, T, NX, NU>,
) {
    let mut core = Core::<T, NX, NU> {
        gains,
        actuator: settings(report),
        tick: FIRST_TICK,
        in_flight: lent::nothing_sent(gains.length(), gains.length() + 2, FIRST_TICK),
        played: (Age::Empty, SVector::zeros()),
        held: SVector::zeros(),
    };
    let mut draws = Draws(7);
    let cycles: Vec<_> = (0..CYCLES).map(|_| Cycle::<T, NX>::drawn(&mut draws, N)).collect();
    let expected: Vec<_> = cycles.iter().map(|cycle| core.cycle(cycle)).collect();
    for part in ["0 ", "1 ", "2 ", " finite", " not finite"] {
        assert!(expected.iter().any(|line| line.contains(part)), "the run has no case {part:?}");
    }
    let input = format!("{}\n{}", FIRST_TICK.0, cycles.iter().map(Cycle::line).collect::<String>());

    let folder = tempfile::tempdir().unwrap();
    emitted(report, folder.path());
    let (scalar, bits) = if T::BYTES == 4 { ("float", "32") } else { ("double", "64") };
    let driver = DRIVER.replace("@scalar@", scalar).replace("@bits@", bits);
    std::fs::write(folder.path().join("driver.c"), driver).unwrap();
    // The second would fuse products and sums, were it not told not to.
    let mut eager = vec!["-std=gnu99", "-O3"];
    if cfg!(target_arch = "x86_64") {
        eager.push("-march=native");
    }
    for compiler in compilers() {
        for flags in [&STRICT[..], &eager] {
            compile(compiler, folder.path(), &[flags, &["driver.c", "law.c", "-o", "driver"]].concat());
            let answers = answer(&folder.path().join("driver"), &input);
            assert_eq!(answers.lines().count(), CYCLES);
            for (at, (found, expected)) in answers.lines().zip(&expected).enumerate() {
                assert_eq!(found, expected, "cycle {at}, {compiler} {flags:?}");
            }
        }
    }
    compile("c++", folder.path(), &["-std=c++11", "-x", "c++", "-c", "law.c", "-o", "law.o"]);
    let strict = [&["-std=c++11", "-x", "c++"], &STRICT[1..], &["-c", "law.c", "-o", "law.o"]].concat();
    compile("c++", folder.path(), &strict);
}

#[test]
fn a_single_precision_law_does_what_the_core_does() {
    does_what_the_core_does!(solved("../designs/pendulum.toml", None, None), f32, 4, 1, 4);
}

#[test]
fn a_double_precision_law_that_holds_within_limits_does_what_the_core_does() {
    does_what_the_core_does!(solved("tests/data/crane.toml", None, None), f64, 3, 2, 3);
}

#[test]
fn the_shortest_laws_do_what_the_core_does() {
    let integrator = |length, default_input| {
        solved("../designs/double_integrator.toml", Some(length), Some(default_input))
    };
    does_what_the_core_does!(integrator(1, DefaultInput::Zero), f32, 2, 1, 1);
    does_what_the_core_does!(integrator(1, DefaultInput::Hold), f32, 2, 1, 1);
    does_what_the_core_does!(integrator(2, DefaultInput::Zero), f32, 2, 1, 2);
    does_what_the_core_does!(solved("tests/data/crane.toml", Some(1), None), f64, 3, 2, 1);
}
