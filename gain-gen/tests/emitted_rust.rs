//! Generated source is compiled and run: today's generator writes the committed files to the byte, and the laws in
//! them compute what the solver says. What a reference and an event trigger add is checked in `emitted_tracking.rs`.

use gain_gen::build::Compile;
use gain_gen::design::Design;
use gain_gen::solve::{LoopProblem, Method, Solution, solve};
use nalgebra::{DMatrix, DVector, SVector};
use slqg::Age;
use slqg::gains::{Gains, Tables};
use slqg::played::Played;
use slqg::{DefaultInput, Scalar, Tick, wire};
use std::path::{Path, PathBuf};

mod draws;
mod lent;

use draws::Draws;

#[allow(dead_code, unreachable_pub)]
mod pendulum {
    include!("generated/pendulum.rs");
}

/// Two inputs, hold, limits, `f64`.
#[allow(dead_code, unreachable_pub)]
mod crane {
    include!("generated/crane.rs");
}

/// Acknowledgements late and lost.
#[allow(dead_code, unreachable_pub)]
mod winch {
    include!("generated/winch.rs");
}

/// As many states as a device takes.
#[allow(dead_code, unreachable_pub)]
mod rope {
    include!("generated/rope.rs");
}

const DRAWS: usize = 1000;

/// Design file and committed source.
fn paths() -> [(PathBuf, PathBuf); 7] {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let pendulum = "../designs/pendulum.toml";
    let of_tests =
        ["crane", "lift", "hoist", "winch", "rope", "ferry"].map(|name| format!("tests/data/{name}.toml"));
    let [crane, lift, hoist, winch, rope, ferry] = of_tests.each_ref().map(String::as_str);
    [pendulum, crane, lift, hoist, winch, rope, ferry].map(|design| {
        let design = here.join(design);
        let source = here.join("tests/generated").join(design.file_name().unwrap()).with_extension("rs");
        (design, source)
    })
}

fn solved(design: &Path) -> Solution {
    solve(&LoopProblem::of(&Design::load(design).unwrap()), Method::InFlight)
}

fn rounded<T: Scalar>(matrix: &DMatrix<f64>) -> Vec<T> {
    matrix.transpose().iter().map(|&value| T::nearest(value)).collect()
}

/// Runs `law` on random states, sequences sent and ages, and compares with `at_run_time`, to the bit, and with
/// the solver's gain for that age, within `tolerance`.
fn computes_what_the_solver_says<T: Scalar, const NX: usize, const NU: usize, const N: usize>(
    law: &Gains<'_, T, NX, NU>,
    at_run_time: &Gains<'_, T, NX, NU>,
    solution: &Solution,
    tolerance: f64,
) {
    let mode_gains = solution.mode_gains();
    let mut draws = Draws(1);
    for draw in 0..DRAWS {
        let state: SVector<T, NX> = draws.vector();
        let last_input: SVector<T, NU> = draws.vector();
        let mode = draws.below(N + 1);
        let sent: [Vec<SVector<T, NU>>; N] =
            core::array::from_fn(|_| (0..N).map(|_| draws.vector()).collect());

        let age = if mode < N { Age::Steps(mode as u8) } else { Age::Empty };
        let run = |gains: &Gains<'_, T, NX, NU>| -> [SVector<T, NU>; N] {
            let in_flight = lent::sent(N, sent.iter().rev().cloned().map(Some));
            let (mut room, mut sequence) = ([SVector::zeros(); N], [SVector::zeros(); N]);
            let expected = in_flight.fill_expected(gains, &Played::Known(age, last_input), &mut room);
            gains.fill_sequence(&state, expected, &mut sequence);
            sequence
        };
        let sequence = run(law);
        assert_eq!(sequence, run(at_run_time), "draw {draw}");

        // [x; rho] of thesis (3.26), and with hold the input applied last.
        let old = (1..N).flat_map(|age| sent[age - 1].iter().skip(age)).flat_map(|input| input.iter());
        let hold = law.default_input() == DefaultInput::Hold;
        let augmented = state.iter().chain(old).chain(last_input.iter().filter(|_| hold)).map(|v| v.widen());
        let augmented = DVector::from_iterator(mode_gains[mode].ncols(), augmented);
        let exact = &mode_gains[mode] * augmented;
        let flat = DVector::from_iterator(N * NU, sequence.iter().flat_map(|u| u.iter()).map(|v| v.widen()));
        assert!((&flat - &exact).amax() <= tolerance * exact.amax().max(1.0), "draw {draw}: {flat} {exact}");
    }
}

#[test]
fn todays_generator_writes_the_committed_sources() {
    let folder = tempfile::tempdir().unwrap();
    for (design, source) in paths() {
        let compile = Compile::new(&design).accept_undecided_stability();
        let written = compile.run_into(folder.path()).unwrap();
        assert_eq!(written.file_name(), source.file_name());
        assert!(
            std::fs::read(&written).unwrap() == std::fs::read(&source).unwrap(),
            "{source} is not what the generator writes today. If the change is wanted:\n\
             cargo run -p gain-gen -- emit --accept-undecided-stability {design} --to rust --output {source}",
            source = source.display(),
            design = design.display(),
        );
    }
}

#[test]
fn rustfmt_leaves_generated_source_as_it_is() {
    for (_, source) in paths() {
        // With the project's settings, and from a folder without any.
        let folder = tempfile::tempdir().unwrap();
        let copy = folder.path().join("copy.rs");
        std::fs::copy(&source, &copy).unwrap();
        for file in [&source, &copy] {
            let check = std::process::Command::new("rustfmt")
                .args(["--check", "--edition", "2024"])
                .arg(file)
                .output();
            let Ok(check) = check else {
                eprintln!("rustfmt is not installed: layout not checked");
                return;
            };
            assert!(check.status.success(), "{}", String::from_utf8_lossy(&check.stdout));
        }
    }
}

#[test]
fn the_generated_single_precision_law_computes_what_the_solver_says() {
    let solution = solved(&paths()[0].0);
    let (lx, m) = (rounded(&solution.law.lx), rounded(&solution.law.m));
    let arrival: Vec<f32> = solution.law.arrival.iter().map(|&r| r as f32).collect();
    let tables = Tables::check(&lx, &m, &arrival).unwrap();
    let at_run_time = Gains::<f32, 4, 1>::check(4, DefaultInput::Zero, tables).unwrap();
    assert_eq!(pendulum::GAINS, at_run_time);
    computes_what_the_solver_says::<_, 4, 1, 4>(&pendulum::GAINS, &at_run_time, &solution, 1e-6);
}

#[test]
fn the_generated_double_precision_law_computes_what_the_solver_says() {
    let solution = solved(&paths()[1].0);
    let (lx, m) = (rounded(&solution.law.lx), rounded(&solution.law.m));
    let tables = Tables::check(&lx, &m, &solution.law.arrival).unwrap();
    let at_run_time = Gains::<f64, 3, 2>::check(3, DefaultInput::Hold, tables).unwrap();
    assert_eq!(crane::GAINS, at_run_time);
    computes_what_the_solver_says::<_, 3, 2, 3>(&crane::GAINS, &at_run_time, &solution, 1e-13);
}

#[test]
fn the_generated_law_of_32_states_computes_what_the_solver_says() {
    let solution = solved(&paths()[5].0);
    let (lx, m) = (rounded(&solution.law.lx), rounded(&solution.law.m));
    let arrival: Vec<f32> = solution.law.arrival.iter().map(|&r| r as f32).collect();
    let tables = Tables::check(&lx, &m, &arrival).unwrap();
    let at_run_time = Gains::<f32, 32, 1>::check(3, DefaultInput::Zero, tables).unwrap();
    assert_eq!(rope::GAINS, at_run_time);
    computes_what_the_solver_says::<_, 32, 1, 3>(&rope::GAINS, &at_run_time, &solution, 1e-6);
    assert!(rope::Controller::new(rope::DESIGN, Tick(0), rope::Memory::new().lend()).is_ok());
}

#[test]
fn the_generated_model_is_the_designs() {
    let plant = Design::load(&paths()[0].0).unwrap().plant;
    let model = &pendulum::MODEL;
    assert_eq!(model.a.transpose().as_slice(), rounded::<f32>(&plant.a));
    assert_eq!(model.b.transpose().as_slice(), rounded::<f32>(&plant.b));
    assert_eq!(model.c.transpose().as_slice(), rounded::<f32>(&plant.c));
    assert_eq!(model.process_noise.as_slice(), rounded::<f32>(&plant.process_noise));
    assert_eq!(model.measurement_noise.as_slice(), rounded::<f32>(&plant.measurement_noise));
    assert_eq!(model.initial_mean.as_slice(), [0.0, 0.2, 0.0, 0.2]);
    assert_eq!(model.initial_covariance.as_slice(), rounded::<f32>(&plant.initial_covariance));
    assert_eq!(pendulum::SAMPLE_TIME, plant.sample_time);
    assert_eq!(pendulum::ACTUATOR.limits, None);
    let limits = crane::ACTUATOR.limits.expect("the crane has limits");
    assert_eq!((limits.min.as_slice(), limits.max.as_slice()), (&[-2.0, 0.0][..], &[2.5, 1.0][..]));
}

#[test]
fn generated_nodes_close_the_loop() {
    let (mut memory, mut of_actuator) = (pendulum::Memory::new(), pendulum::ACTUATOR_MEMORY);
    let controller = pendulum::Controller::new(pendulum::DESIGN, Tick(0), memory.lend());
    let mut controller = controller.expect("it is made for the design");
    let mut actuator = pendulum::Actuator::new(pendulum::ACTUATOR, Tick(0), &mut of_actuator);
    let mut frame = [0; 256];
    let sent = controller.cycle(&mut frame).expect("a sequence of four inputs fits").expect("it is finite");
    actuator.receive(sent).expect("both ends are made for the same design");
    let mut expected = [SVector::zeros(); 4];
    pendulum::GAINS.fill_sequence(&pendulum::MODEL.initial_mean, &[SVector::zeros(); 3], &mut expected);
    let applied = actuator.step();
    assert_eq!((applied.age, applied.input), (Age::Steps(0), expected[0]));
    assert!(crane::Controller::new(crane::DESIGN, Tick(0), crane::Memory::new().lend()).is_ok());
}

#[test]
fn a_generated_estimator_reckons_with_all_that_may_have_been_played_until_it_is_told() {
    let (mut memory, mut of_actuator) = (winch::Memory::new(), winch::ACTUATOR_MEMORY);
    let controller = winch::Controller::new(winch::DESIGN, Tick(0), memory.lend());
    let mut controller = controller.expect("it is made for the design");
    let mut actuator = winch::Actuator::new(winch::ACTUATOR, Tick(0), &mut of_actuator);
    let mut buffer = [0; 64];
    for _ in 0..2 {
        let sent = controller.cycle(&mut buffer).expect("three inputs fit").expect("they are finite");
        actuator.receive(sent).expect("both ends are made for the same design");
        actuator.step();
    }
    // Nothing was acknowledged. Beside the packet of cycle 1 that of cycle 0 may have been played, or the default input.
    let untold = *controller.propose().posterior_mean;
    let ages: Vec<_> = controller.estimator().modes().expect("a cycle is over").iter().collect();
    assert!(ages.iter().map(|(age, _)| *age).eq([Age::Steps(0), Age::Steps(1), Age::Empty]), "{ages:?}");
    assert!((ages[0].1 - winch::DESIGN.arrives_at_once).abs() < 1e-6, "{ages:?}");

    let told = actuator.acknowledgement(winch::ACKNOWLEDGED_CYCLES).expect("two cycles are over");
    assert_eq!(told.ages, [Age::Steps(0); 2]);
    let frame = wire::encode_acknowledgement::<f32>(&told, &mut buffer).expect("it fits");
    controller.receive(frame).expect("the last cycle is remembered");
    controller.cycle(&mut buffer).expect("three inputs fit").expect("they are finite");
    assert_eq!(controller.estimator().modes().and_then(|modes| modes.known()), Some(Age::Steps(0)));
    assert_ne!(*controller.estimator().posterior_mean(), untold);
}
