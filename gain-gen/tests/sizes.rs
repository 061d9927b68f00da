//! How large a plant may be: what is refused, with which words, and that the largest is solved.

use gain_gen::{
    design::{Design, DesignError, MOST_INPUTS, MOST_STATES},
    emit::{EmitError, Format, Output, emit},
    report::{Report, Verdict},
    solve::Method,
};
use slqg::estimator;
use std::path::Path;

/// Lags in a row, each driven by the one before, the first slower than the others; inputs drive lags that are
/// evenly spread, and every third one is measured.
fn row(states: usize, inputs: usize) -> String {
    let matrix = |rows: usize, columns: usize, entry: &dyn Fn(usize, usize) -> f64| {
        let row = |i| (0..columns).map(|j| entry(i, j).to_string()).collect::<Vec<_>>().join(", ");
        let rows: Vec<String> = (0..rows).map(|i| format!("[{}]", row(i))).collect();
        format!("[\n{}]", rows.join(",\n"))
    };
    let diagonal = |size, value| matrix(size, size, &move |i, j| if i == j { value } else { 0.0 });
    let a = |i: usize, j: usize| match (i, j) {
        (0, 0) => 0.97,
        _ if i == j => 0.9,
        _ if i == j + 1 => 0.05,
        _ => 0.0,
    };
    let outputs = states.div_ceil(3);
    format!(
        "name = 'row'
        [plant]
        sample_time = 0.01
        discrete.a = {}
        discrete.b = {}
        c = {}
        process_noise = {}
        measurement_noise = {}
        initial_mean = {:?}
        initial_covariance = {}
        [cost]
        q = {}
        r = {}
        [network]
        controller_to_actuator.delays = [1.0]
        sensor_to_controller.delays = [1.0]
        [controller]
        sequence_length = 1
        ",
        matrix(states, states, &a),
        matrix(states, inputs, &|i, j| if i == j * states / inputs { 1.0 } else { 0.0 }),
        matrix(outputs, states, &|i, j| if j == 3 * i { 1.0 } else { 0.0 }),
        diagonal(states, 1e-4),
        diagonal(outputs, 1e-4),
        vec![0.0; states],
        diagonal(states, 0.0),
        diagonal(states, 1.0),
        diagonal(inputs, 1.0),
    )
}

fn parsed(states: usize, inputs: usize) -> Result<Design, DesignError> {
    Design::parse(&row(states, inputs), "row.toml")
}

fn report(states: usize, inputs: usize) -> Report {
    Report::new(&parsed(states, inputs).expect("a design"), Method::InFlight)
}

#[test]
fn the_largest_plant_gets_a_report() {
    let report = report(MOST_STATES, MOST_INPUTS);
    assert_eq!(report.verdict(), Verdict::Stable);
    assert_eq!(report.solution.law.lx.shape(), (MOST_INPUTS, MOST_STATES));
    assert_eq!(report.warnings, []);
    assert!(report.to_string().contains("100 states, 8 inputs, 34 outputs"));
}

#[test]
fn more_states_or_inputs_are_refused_with_what_was_found_and_what_is_allowed() {
    let states = parsed(MOST_STATES + 1, 1).expect_err("too many states").to_string();
    assert!(
        states.starts_with("row.toml:4: plant.discrete.a: found 101 states; gains are found for up to 100"),
        "{states}"
    );
    let inputs = parsed(20, MOST_INPUTS + 1).expect_err("too many inputs").to_string();
    assert!(inputs.contains(": plant.discrete.b: found 9 inputs; gains are found for up to 8"), "{inputs}");
}

#[test]
fn what_no_device_runs_is_not_written_for_devices() {
    let report_of_largest = report(estimator::MOST_STATES, 1);
    let largest = report_of_largest.emission().unwrap();
    assert!(emit(&largest, "row.toml", Format::Rust).is_ok());
    let (blob, header) =
        (Output::blob(Path::new("row.blob")), Output::c(Path::new("row.h")).expect("a name"));
    assert!(blob.files(&largest, "row.toml").is_ok());

    let report_of_too_large = report(estimator::MOST_STATES + 1, 1);
    let too_large = report_of_too_large.emission().unwrap();
    let refused = |format| EmitError::TooManyStates { states: 33, format };
    assert_eq!(emit(&too_large, "row.toml", Format::Rust), Err(refused("rust")));
    assert_eq!(blob.files(&too_large, "row.toml"), Err(refused("blob")));
    assert_eq!(
        refused("rust").to_string(),
        "plant: found 33 states; rust is for devices, whose controller takes up to 32: reduce the model, or write json, or c \
         for the law alone"
    );
    assert!(emit(&too_large, "row.toml", Format::Json).is_ok());
    assert!(header.files(&too_large, "row.toml").is_ok());
}
