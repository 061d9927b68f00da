//! An emitted blob is loaded: it is the law that is emitted as Rust, to the bit, and knows which design it is of.

mod draws;
mod lent;

use assert_cmd::cargo::cargo_bin_cmd;
use draws::Draws;
use gain_gen::design::Design;
use gain_gen::emit::design_id;
use slqg::Age;
use slqg::blob::{self, BlobError, DesignId, Shape};
use slqg::gains::Gains;
use slqg::nalgebra::SVector;
use slqg::played::Played;
use slqg::{DefaultInput, Scalar};
use std::path::{Path, PathBuf};

#[allow(dead_code, unreachable_pub)]
mod pendulum {
    include!("generated/pendulum.rs");
}

#[allow(dead_code, unreachable_pub)]
mod crane {
    include!("generated/crane.rs");
}

const DRAWS: usize = 1000;

/// An input that moves next to nothing needs gains beyond single precision.
const TINY_INPUT: &str = "
    name = 'tiny'
    [plant]
    sample_time = 1
    discrete = { a = [[1.2]], b = [[1e-40]] }
    c = [[1]]
    process_noise = [[1]]
    measurement_noise = [[1]]
    initial_mean = [0]
    initial_covariance = [[1]]
    [cost]
    q = [[1]]
    r = [[1e-80]]
    [network]
    controller_to_actuator.delays = [0.8, 0.1]
    sensor_to_controller.delays = [1]
    [controller]
    sequence_length = 2
";

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// What `gain-gen emit --to blob` writes for `design`.
fn emitted(design: &Path, options: &[&str]) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("gains.blob");
    let output = cargo_bin_cmd!("gain-gen")
        .args(["emit", "--accept-undecided-stability", "--to", "blob", "--output"])
        .args([&file, design])
        .args(options)
        .output()
        .unwrap();
    assert!(output.status.success() && output.stdout.is_empty(), "{output:?}");
    std::fs::read(file).unwrap()
}

fn id(design: &Path) -> DesignId {
    design_id(&Design::load(design).unwrap())
}

/// Compares two laws on random states, sequences sent and ages, to the bit.
fn compute_the_same<T: Scalar, const NX: usize, const NU: usize, const N: usize>(
    one: &Gains<'_, T, NX, NU>,
    other: &Gains<'_, T, NX, NU>,
) {
    let mut draws = Draws(3);
    for draw in 0..DRAWS {
        let (state, last_input) = (draws.vector(), draws.vector());
        let sent: [Vec<SVector<T, NU>>; N] =
            core::array::from_fn(|_| (0..N).map(|_| draws.vector()).collect());
        let mode = draws.below(N + 1);
        let age = if mode < N { Age::Steps(mode as u8) } else { Age::Empty };
        let run = |gains: &Gains<'_, T, NX, NU>| -> Vec<u64> {
            let in_flight = lent::sent(N, sent.iter().rev().cloned().map(Some));
            let (mut room, mut sequence) = ([SVector::zeros(); N], [SVector::zeros(); N]);
            let expected = in_flight.fill_expected(gains, &Played::Known(age, last_input), &mut room);
            gains.fill_sequence(&state, expected, &mut sequence);
            sequence.iter().flat_map(|input| input.iter()).map(|value| value.widen().to_bits()).collect()
        };
        assert_eq!(run(one), run(other), "draw {draw}");
    }
}

#[test]
fn a_loaded_single_precision_law_is_the_one_emitted_as_rust() {
    let design = here("../designs/pendulum.toml");
    let bytes = emitted(&design, &[]);
    const SHAPE: Shape = Shape { length: 4, states: 4, inputs: 1, default_input: DefaultInput::Zero };
    let mut storage = [0.0_f32; blob::storage_len(&SHAPE)];
    let law = blob::load::<f32, 4, 1>(&bytes, &mut storage, Some(id(&design))).unwrap();
    assert_eq!(law, pendulum::GAINS);
    compute_the_same::<_, 4, 1, 4>(&law, &pendulum::GAINS);
}

#[test]
fn a_loaded_double_precision_law_is_the_one_emitted_as_rust() {
    let design = here("tests/data/crane.toml");
    let bytes = emitted(&design, &[]);
    const SHAPE: Shape = Shape { length: 3, states: 3, inputs: 2, default_input: DefaultInput::Hold };
    let mut storage = [0.0_f64; blob::storage_len(&SHAPE)];
    let law = blob::load::<f64, 3, 2>(&bytes, &mut storage, Some(id(&design))).unwrap();
    assert_eq!(law, crane::GAINS);
    compute_the_same::<_, 3, 2, 3>(&law, &crane::GAINS);
}

#[test]
fn a_loaded_law_drives_the_controller_of_the_design() {
    let bytes = emitted(&here("../designs/pendulum.toml"), &[]);
    // On a device, a static.
    let storage = Box::leak(Box::new([0.0; 64]));
    let gains = blob::load(&bytes, storage, None).unwrap();
    let design = slqg::controller::Design { gains, ..pendulum::DESIGN };
    let first = |design| {
        let mut memory = pendulum::Memory::new();
        let mut controller = pendulum::Controller::new(design, slqg::Tick(0), memory.lend()).unwrap();
        let mut frame = [0; 256];
        controller.cycle(&mut frame).unwrap().expect("it is finite").to_vec()
    };
    assert_eq!(first(design), first(pendulum::DESIGN));
}

#[test]
fn todays_generator_writes_the_committed_blobs() {
    for design in ["../designs/pendulum.toml", "tests/data/crane.toml"] {
        let design = here(design);
        let committed = here("tests/generated").join(design.file_name().unwrap()).with_extension("blob");
        assert!(
            emitted(&design, &[]) == std::fs::read(&committed).unwrap_or_default(),
            "{committed} is not what the generator writes today. If the change is wanted:\n\
             cargo run -p gain-gen -- emit --accept-undecided-stability {design} --to blob --output {committed}",
            committed = committed.display(),
            design = design.display(),
        );
    }
}

#[test]
fn gains_for_another_plant_are_refused_and_those_for_another_network_or_length_are_not() {
    let (good, bad) = (here("../designs/pendulum.toml"), here("../designs/pendulum_bad.toml"));
    let other = here("../designs/double_integrator.toml");
    let storage = &mut [0.0_f32; 256];
    let outcome = blob::load::<f32, 4, 1>(&emitted(&other, &[]), storage, Some(id(&good))).map(|_| ());
    assert_eq!(outcome, Err(BlobError::Design(id(&other))));
    let for_bad = emitted(&bad, &[]);
    assert_ne!(for_bad, emitted(&good, &["--sequence-length", "8"]));
    assert_eq!(blob::load::<f32, 4, 1>(&for_bad, storage, Some(id(&good))).unwrap().length(), 8);
    let longer = emitted(&good, &["--sequence-length", "6", "--default-input", "hold"]);
    let law = blob::load::<f32, 4, 1>(&longer, storage, Some(id(&good))).unwrap();
    assert_eq!((law.length(), law.default_input()), (6, DefaultInput::Hold));
}

#[test]
fn a_gain_that_the_device_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let design = folder.path().join("tiny.toml");
    std::fs::write(&design, TINY_INPUT).unwrap();
    let file = folder.path().join("gains.blob");
    let output = cargo_bin_cmd!("gain-gen")
        .args(["emit", "--to", "blob", "--output"])
        .args([&file, &design])
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("Lx: found") && stderr.contains("controller.scalar"), "{stderr}");
    assert!(!file.exists());
}
