//! Choosing the sequence length: `gain-gen sweep`, and `sequence_length = "auto"` in a design.

use assert_cmd::cargo::cargo_bin_cmd;
use gain_gen::design::Design;
use gain_gen::lengths::LongSequences;
use gain_gen::solve::{LoopProblem, Method, solve};
use gain_gen::sweep::Sweep;
use serde_json::Value;
use slqg::DefaultInput;
use std::path::{Path, PathBuf};
use std::process::Output;

/// The fields of an entry of `sweep --json` that scripts depend on, in their order.
const FIELDS: [&str; 7] = [
    "sequence_length",
    "converged",
    "mean_square_rate",
    "control_cost",
    "table_floats",
    "table_bytes",
    "coupled_table_floats",
];

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name).with_extension("toml")
}

/// The example with its sequence length left open, and other `changes`.
fn open(name: &str, changes: &[(&str, &str)]) -> String {
    let text = std::fs::read_to_string(example(name)).unwrap();
    let (before, after) = text.split_once("sequence_length = ").expect("a length");
    let mut text = format!("{before}sequence_length = \"auto\"\n# {after}");
    for (from, to) in changes {
        assert!(text.contains(from), "{name} has no {from}");
        text = text.replacen(from, to, 1);
    }
    text
}

fn design(text: &str) -> Design {
    Design::parse(text, "open.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn cost(design: &Design, length: usize) -> f64 {
    let solution = solve(&LoopProblem::of(design).with_length(length), Method::InFlight);
    let cost = solution.control_cost(&design.plant.process_noise);
    if solution.is_stabilising() { cost } else { f64::INFINITY }
}

/// Runs `gain-gen COMMAND DESIGN OPTIONS..`.
fn gain_gen(command: &str, design: &Path, options: &[&str]) -> Output {
    cargo_bin_cmd!("gain-gen").arg(command).arg(design).args(options).output().expect("gain-gen starts")
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

fn object(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).expect("one JSON object and nothing else")
}

fn written(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("open.toml");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn the_length_chosen_is_the_shortest_within_the_tolerance() {
    for (name, tolerance, hold) in [
        ("double_integrator_bad", 0.01, false),
        ("double_integrator_bad", 0.3, false),
        ("double_integrator_bad", 0.01, true),
        ("double_integrator", 1e-4, false),
        ("pendulum", 0.01, true),
        ("critical", 0.5, false),
    ] {
        let given = format!("[controller]\nlength_tolerance = {tolerance}");
        let mut design = design(&open(name, &[("[controller]", &given)]));
        if hold {
            design.set_default_input(DefaultInput::Hold);
        }
        let choice = *design.length_choice().expect("chosen");
        let LongSequences::Settled { length: long, cost: limit } = choice.limit else { panic!("{choice:?}") };
        assert!((cost(&design, long) / limit - 1.0).abs() < 1e-12);
        assert!(cost(&design, 2 * long) > (1.0 - 0.1 * tolerance) * limit, "{name}: not yet settled");
        let bound = (1.0 + tolerance) * limit;
        let shortest = (1..=long).find(|&length| cost(&design, length) <= bound);
        assert_eq!(Some(design.controller.sequence_length), shortest, "{name} {tolerance}");
    }
}

#[test]
fn a_long_delay_that_only_long_sequences_can_use_is_not_overlooked() {
    // Sequences of up to eight inputs have no effect at all: their costs are equal, which is no sign of convergence.
    let delays = "controller_to_actuator.delays = [0, 0, 0, 0, 0, 0, 0, 0, 1]";
    let stable = "a = [[0.5, 0], [1, 0.98]], b = [[1], [0]]";
    let changes = [
        ("controller_to_actuator.delays = [0.25, 0.25, 0.25, 0.25]", delays),
        ("a = [[0.5, 0], [1, 1.5]], b = [[1], [0]]", stable),
    ];
    assert_eq!(design(&open("critical", &changes)).controller.sequence_length, 9);
}

#[test]
fn reports_say_that_the_length_was_chosen_and_options_override_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), &open("double_integrator_bad", &[]));
    let shown = gain_gen("report", &path, &[]);
    let chosen =
        "sequences of N = 7 inputs (chosen: within 1 % of the cost of long sequences), default input zero";
    assert!(text(&shown.stdout).contains(chosen), "{}", text(&shown.stdout));
    assert_eq!(object(&gain_gen("report", &path, &["--json"]))["length_tolerance"], 0.01);
    for length in ["3", "7"] {
        let shown = gain_gen("report", &path, &["--sequence-length", length, "--default-input", "hold"]);
        let given = format!("sequences of N = {length} inputs, default input hold");
        assert!(text(&shown.stdout).contains(&given), "{}", text(&shown.stdout));
    }
    let target = folder.path().join("gains.rs");
    let emitted = gain_gen("emit", &path, &["--to", "rust", "--output", target.to_str().unwrap()]);
    assert_eq!(emitted.status.code(), Some(0), "{}", text(&emitted.stderr));
    assert!(std::fs::read_to_string(&target).unwrap().contains("SEQUENCE_LENGTH: usize = 7;"));
}

#[test]
fn a_design_that_no_length_stabilises_is_status_3_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let lossy = [(
        "controller_to_actuator.delays = [0.25, 0.25, 0.25, 0.25]",
        "controller_to_actuator.delays = [0.3, 0.2]",
    )];
    let path = written(folder.path(), &open("critical", &lossy));
    let output = gain_gen("report", &path, &[]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("(chosen: no length stabilises)"), "{}", text(&output.stdout));
    let stderr = text(&output.stderr);
    assert!(stderr.contains("Theorem 3.4 b)") && stderr.contains("every length is ruled out"), "{stderr}");
}

#[test]
fn json_sweep_has_one_entry_per_length_with_its_fields_in_order() {
    let options = ["--lengths", "1..=4", "--json"];
    let output = gain_gen("sweep", &example("critical"), &options);
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), ""));
    let shown = text(&output.stdout);
    let places: Vec<_> =
        FIELDS.iter().map(|field| shown.find(&format!("\"{field}\": ")).expect(field)).collect();
    assert!(places.is_sorted(), "{places:?}");
    let found = object(&output);
    assert_eq!((&found["name"], &found["default_input"]), (&"critical".into(), &"zero".into()));
    let results = found["results"].as_array().unwrap();
    let lengths: Vec<_> = results.iter().map(|entry| entry["sequence_length"].as_u64().unwrap()).collect();
    assert_eq!(lengths, [1, 2, 3, 4]);
    for entry in &results[..2] {
        assert_eq!((&entry["converged"], &entry["control_cost"]), (&false.into(), &Value::Null));
    }
    for entry in &results[2..] {
        let length = entry["sequence_length"].to_string();
        let reported =
            object(&gain_gen("report", &example("critical"), &["--json", "--sequence-length", &length]));
        for field in FIELDS.iter().filter(|field| **field != "table_bytes") {
            assert_eq!(entry[field], reported[field], "{field}");
        }
        assert_eq!(entry["table_bytes"].as_u64(), entry["table_floats"].as_u64().map(|floats| 4 * floats));
    }
}

#[test]
fn both_default_inputs_come_in_one_table() {
    let options = ["--lengths", "2,1", "--default-input", "both"];
    let output = gain_gen("sweep", &example("double_integrator"), &options);
    let rows: Vec<Vec<_>> =
        text(&output.stdout).lines().skip(3).map(|line| line.split_whitespace().take(2).collect()).collect();
    assert_eq!(rows, [["1", "zero"], ["2", "zero"], ["1", "hold"], ["2", "hold"]]);
    let found =
        object(&gain_gen("sweep", &example("double_integrator"), &[&options[..], &["--json"]].concat()));
    assert_eq!(found["default_input"], "both");
    let inputs: Vec<_> =
        found["results"].as_array().unwrap().iter().map(|entry| &entry["default_input"]).collect();
    assert_eq!(inputs, ["zero", "zero", "hold", "hold"]);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let design = Design::load(&example("double_integrator_bad")).unwrap();
    let lengths: Vec<usize> = (1..=10).collect();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Sweep::new(&design, &lengths, &[DefaultInput::Zero, DefaultInput::Hold]))
    };
    assert_eq!(on(1), on(4));
}

#[test]
fn plots_show_cost_rate_and_bytes_with_labelled_axes() {
    let folder = tempfile::tempdir().unwrap();
    let plot = folder.path().join("lengths.svg");
    let options = ["--lengths", "1..=5", "--default-input", "both", "--plot", plot.to_str().unwrap()];
    assert_eq!(gain_gen("sweep", &example("critical"), &options).status.code(), Some(0));
    let svg = std::fs::read_to_string(&plot).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    for label in [
        "critical: what each sequence length brings",
        "inputs per packet, N",
        "cost per step, tr(P W)",
        "rate per step, stable below 1",
        "tables in bytes",
        "coupled form, default input hold",
    ] {
        assert!(svg.contains(label), "no {label:?}");
    }
    // Lengths 1 and 2 have no finite cost: three points in the first panel, five in each other line.
    assert_eq!(svg.matches("<circle").count(), 2 * (3 + 5 + 5 + 5));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "something was left behind");
}

#[test]
fn a_sweep_without_any_stable_length_is_status_3_and_still_shows_its_table() {
    let output = gain_gen("sweep", &example("critical"), &["--lengths", "1,2"]);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(text(&output.stdout).lines().count(), 5);
    let stderr = text(&output.stderr);
    assert!(stderr.contains("N_crit = 3") || stderr.contains("not ruled out is N = 3"), "{stderr}");
}

#[test]
fn what_cannot_be_swept_is_status_2_with_what_is_allowed() {
    for (options, part) in [
        (
            &["--lengths", "0..=3"][..],
            "found `0..=3`; give lengths from 1 to 128: one as 4, a range as 1..=12",
        ),
        (&["--lengths", "1,7..3"], "found `7..3`"),
        (&["--lengths", "1..=129"], "found `1..=129`"),
        (&["--lengths", "some"], "found `some`"),
        (&[], "--lengths"),
        (&["--lengths", "3", "--default-input", "none"], "zero, hold, both"),
        (&["--lengths", "3", "--plot", "/nowhere/a.svg"], "/nowhere/a.svg: cannot be written"),
    ] {
        let output = gain_gen("sweep", &example("critical"), options);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{options:?}: {stderr}");
        assert!(stderr.contains(part), "{options:?}: {stderr}");
        assert!(output.stdout.is_empty());
    }
}
