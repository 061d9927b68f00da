//! Designs that make no sense, each one change away from a sensible one: a warning names file, line and key, and changes no
//! status. Sensible designs have none.

use gain_gen::{
    design::Design,
    report::Report,
    solve::Method,
    warnings::{Warning, of_design},
};
use std::path::{Path, PathBuf};

const PENDULUM: &str = include_str!("../../designs/pendulum.toml");
const DOUBLE_INTEGRATOR: &str = include_str!("../../designs/double_integrator.toml");
const HYDRAULIC: &str = "
    name = 'hydraulic'
    [plant]
    sample_time = 0.001
    continuous = { a = [[0, 1, 0], [0, -38, 2.525e-5], [0, -3.0963503649635e9, -3.06569343]], b = [[0], [0], [1042335.76]] }
    c = [[1, 0, 0], [0, 0, 1]]
    process_noise = [[1e-10, 0, 0], [0, 1e-6, 0], [0, 0, 1e6]]
    measurement_noise = [[1e-10, 0], [0, 1e6]]
    initial_mean = [0, 0, 0]
    initial_covariance = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
    [cost]
    q = [[1e6, 0, 0], [0, 1e3, 0], [0, 0, 1e-14]]
    r = [[1]]
    [network]
    controller_to_actuator = { delays = [1.0] }
    sensor_to_controller = { delays = [1.0] }
    [controller]
    sequence_length = 1
    scalar = 'f64'
";

/// A light structure with one resonance of a given frequency in Hz and damping, sampled at 1 kHz, beside a slow lag.
fn structure(frequency: f64, damping: f64) -> String {
    let omega = 2.0 * std::f64::consts::PI * frequency;
    let (stiffness, friction) = (omega * omega, 2.0 * damping * omega);
    format!(
        "name = 'structure'
        [plant]
        sample_time = 0.001
        continuous = {{ a = [[0, 1, 0], [-{stiffness}, -{friction}, 0], [0, 0, -5]], b = [[0], [1000], [5]] }}
        c = [[1, 0, 0], [0, 0, 1]]
        process_noise = [[1e-8, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]]
        measurement_noise = [[1e-8, 0], [0, 1e-4]]
        initial_mean = [0, 0, 0]
        initial_covariance = [[0, 0, 0], [0, 0, 0], [0, 0, 0]]
        [cost]
        q = [[100, 0, 0], [0, 1e-4, 0], [0, 0, 1]]
        r = [[1]]
        [network]
        controller_to_actuator = {{ delays = [0.9, 0.1] }}
        sensor_to_controller = {{ delays = [0.9, 0.1] }}
        [controller]
        sequence_length = 2
        "
    )
}

fn changed(base: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(base.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "no {from:?}");
        text.replacen(from, to, 1)
    })
}

fn warnings(text: &str) -> Vec<Warning> {
    let design = Design::parse(text, "design.toml").expect("a design");
    Report::new(&design, Method::InFlight).warnings
}

/// The one warning of this design: of `key`, in the line that begins with `line`, and it says `phrase`.
fn warns(design: &str, key: &str, line: &str, phrase: &str) {
    let found = warnings(design);
    assert_eq!(found.len(), 1, "{key}, {phrase}: {found:?}");
    let number =
        1 + design.lines().position(|text| text.trim_start().starts_with(line)).expect("the key's line");
    let told = found[0].to_string();
    assert!(told.starts_with(&format!("design.toml:{number}: {key}: ")), "{told}");
    assert!(told.contains(phrase), "{told}");
}

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut files: Vec<_> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    files.sort();
    files
}

#[test]
fn the_examples_make_sense() {
    for path in files("../designs") {
        let design = Design::load(&path).expect("a design");
        assert_eq!(of_design(&design), [], "{}", path.display());
    }
    for text in [PENDULUM, DOUBLE_INTEGRATOR] {
        assert_eq!(warnings(text), []);
    }
}

#[test]
fn units_of_pascals_and_metres_make_sense() {
    assert_eq!(warnings(HYDRAULIC), []);
}

#[test]
fn a_resonance_beyond_half_the_sampling_frequency_is_told_with_what_it_looks_like() {
    warns(&structure(800.0, 0.01), "plant.sample_time", "sample_time", "a resonance at 799.96 Hz");
    warns(&structure(800.0, 0.01), "plant.sample_time", "sample_time", "look like 200.04 Hz");
    // It is over before the next sample, and still is nothing the samples tell of.
    warns(&structure(9300.0, 0.1), "plant.sample_time", "sample_time", "look like");
}

#[test]
fn a_resonance_with_fewer_than_three_samples_a_period_is_told() {
    warns(&structure(400.0, 0.01), "plant.sample_time", "sample_time", "2.50013 samples a period");
    let rotation = "a = [[-0.9, 0.4], [-0.4, -0.9]], b = [[0], [1]]";
    let discrete = changed(DOUBLE_INTEGRATOR, &[("a = [[1, 1], [0, 1]], b = [[0], [1]]", rotation)]);
    warns(&discrete, "plant.sample_time", "sample_time", "samples a period");
}

#[test]
fn resonances_that_are_sampled_or_damped_are_not_told() {
    for (frequency, damping) in [(200.0, 0.001), (300.0, 0.01), (900.0, 0.9)] {
        assert_eq!(warnings(&structure(frequency, damping)), [], "{frequency} Hz");
    }
}

#[test]
fn a_discrete_plant_that_alternates_has_no_resonance() {
    let alternates = changed(DOUBLE_INTEGRATOR, &[("a = [[1, 1], [0, 1]]", "a = [[-0.95, 1], [0, 1]]")]);
    assert_eq!(warnings(&alternates), []);
}

#[test]
fn growth_within_a_cycle_is_told() {
    let slow = changed(PENDULUM, &[("sample_time = 0.02", "sample_time = 0.2")]);
    let found = of_design(&Design::parse(&slow, "design.toml").expect("a design"));
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].to_string().contains("grows by a factor of"), "{}", found[0]);
}

#[test]
fn a_loop_that_settles_within_a_cycle_is_told() {
    let lag = |weight: &str| {
        format!(
            "name = 'lag'
            [plant]
            sample_time = 0.02
            continuous = {{ a = [[-5]], b = [[5]] }}
            c = [[1]]
            process_noise = [[1e-4]]
            measurement_noise = [[1e-4]]
            initial_mean = [0]
            initial_covariance = [[0]]
            [cost]
            q = [[1]]
            r = [[{weight}]]
            [network]
            controller_to_actuator = {{ delays = [1.0] }}
            sensor_to_controller = {{ delays = [1.0] }}
            [controller]
            sequence_length = 1
            "
        )
    };
    assert_eq!(warnings(&lag("0.1")), []);
    let lag = lag("1e-4");
    warns(&lag, "plant.sample_time", "sample_time", "the closed loop settles within that time");
}

#[test]
fn a_delay_line_is_not_sampled_too_slowly() {
    let line = changed(DOUBLE_INTEGRATOR, &[("a = [[1, 1], [0, 1]]", "a = [[0, 1], [0, 0]]")]);
    assert_eq!(warnings(&line), []);
}

#[test]
fn noise_of_zero_is_told() {
    let silent = changed(DOUBLE_INTEGRATOR, &[("[[0.01, 0], [0, 0.01]]", "[[0, 0], [0, 0]]")]);
    warns(&silent, "plant.process_noise", "process_noise", "no noise at all");
    // Position noise does not reach the velocity; velocity noise does reach the position.
    let position = changed(DOUBLE_INTEGRATOR, &[("[[0.01, 0], [0, 0.01]]", "[[0.01, 0], [0, 0]]")]);
    warns(&position, "plant.process_noise", "process_noise", "stops listening");
    let velocity = changed(DOUBLE_INTEGRATOR, &[("[[0.01, 0], [0, 0.01]]", "[[0, 0], [0, 0.01]]")]);
    assert_eq!(warnings(&velocity), []);
}

#[test]
fn an_initial_covariance_of_zero_makes_sense() {
    let known = changed(DOUBLE_INTEGRATOR, &[("[[0.25, 0], [0, 0.25]]", "[[0, 0], [0, 0]]")]);
    assert_eq!(warnings(&known), []);
}

#[test]
fn weights_far_apart_are_told() {
    let identity = "    [0, 1, 0, 0],\n    [0, 0, 1, 0],\n    [0, 0, 0, 1],\n]\nr = [[1]]";
    let with = |q: &str, r: &str| {
        let weights = format!("    [0, {q}, 0, 0],\n    [0, 0, 1, 0],\n    [0, 0, 0, 1],\n]\nr = [[{r}]]");
        changed(PENDULUM, &[(identity, &weights)])
    };
    warns(&with("1e-12", "1"), "cost.q", "q =", "the smallest has no say");
    warns(&with("1e12", "1e6"), "cost.q", "q =", "the smallest has no say");
    warns(&with("1", "1e-14"), "cost.r", "r =", "they have no say");
    warns(&with("1", "1e12"), "cost.r", "r =", "keep itself from diverging");
    assert_eq!(warnings(&with("1e-6", "1e3")), []);
}

#[test]
fn an_oscillation_that_no_weight_sees_is_told() {
    let blind = changed(&structure(50.0, 0.002), &[("[[100, 0, 0], [0, 1e-4, 0]", "[[0, 0, 0], [0, 0, 0]")]);
    warns(&blind, "cost.q", "q =", "ignores an oscillation at 49.9999 Hz");
    // Position alone shows it.
    let position = changed(&structure(50.0, 0.002), &[("[0, 1e-4, 0]", "[0, 0, 0]")]);
    assert_eq!(warnings(&position), []);
}

#[test]
fn measurement_noise_far_apart_is_told() {
    let precise = changed(&structure(50.0, 0.002), &[("[[1e-8, 0], [0, 1e-4]]", "[[1e-20, 0], [0, 1e4]]")]);
    warns(&precise, "plant.measurement_noise", "measurement_noise", "are not listened to");
}
