//! The command line as scripts see it: JSON fields and shapes, exit statuses, what is said where, what is written.

use command::{altered, gain_gen, object, shape, text};
use serde_json::Value;
use std::path::{Path, PathBuf};

mod command;

/// The fields of `report --json` that scripts depend on, in their order.
const FIELDS: [&str; 19] = [
    "name",
    "sequence_length",
    "default_input",
    "method",
    "converged",
    "iterations",
    "residual",
    "transition_matrix",
    "mean_square_rate",
    "control_cost",
    "lx",
    "m",
    "r",
    "gains",
    "cost_to_go",
    "n_min",
    "n_crit",
    "table_floats",
    "coupled_table_floats",
];

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name).with_extension("toml")
}

fn report(name: &str, options: &[&str]) -> Value {
    let output = gain_gen("report", &example(name), &[options, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "{name}");
    object(&output)
}

#[test]
fn json_report_has_every_field_in_its_order_and_shape() {
    // Name, options, then N, nx, nu, n_v and the inputs in rho.
    for (name, options, length, states, expected, sent) in [
        ("pendulum", &[][..], 4, 4, 3, 6),
        ("critical", &["--sequence-length", "3"], 3, 2, 2, 3),
        ("critical", &["--sequence-length", "4"], 4, 2, 3, 6),
        ("critical", &["--default-input", "hold"], 4, 2, 4, 7),
        ("double_integrator", &["--sequence-length", "1"], 1, 2, 0, 0),
        ("double_integrator", &["--sequence-length", "1", "--default-input", "hold"], 1, 2, 1, 1),
    ] {
        let output = gain_gen("report", &example(name), &[options, &["--json"]].concat());
        let places: Vec<_> = FIELDS
            .iter()
            .map(|field| text(&output.stdout).find(&format!("\"{field}\": ")).expect(field))
            .collect();
        assert!(places.is_sorted(), "{name}: {places:?}");

        let found = report(name, options);
        assert_eq!(found["name"], name);
        assert_eq!(found["sequence_length"], length);
        assert_eq!(found["default_input"], if options.contains(&"hold") { "hold" } else { "zero" });
        assert_eq!(found["method"], "in-flight");
        assert_eq!((&found["converged"], &found["verdict"]), (&true.into(), &"stable".into()));
        assert_eq!(found["failed_conditions"], Value::Array(vec![]));
        assert_eq!(found["n_v"], expected);
        assert!(found["iterations"].as_u64().unwrap() > 0);
        assert!(found["residual"].as_f64().unwrap() < 1e-10);
        assert!(found["mean_square_rate"].as_f64().unwrap() < 1.0);
        assert!(found["control_cost"].as_f64().unwrap() > 0.0);
        assert!(found["n_min"].as_u64().unwrap() <= found["n_crit"].as_u64().unwrap());
        assert_eq!(shape(&found["transition_matrix"]), (length + 1, length + 1));
        assert_eq!(shape(&found["lx"]), (length, states));
        assert_eq!(shape(&found["m"]), (length, expected));
        assert_eq!(shape(&found["r"]), (length - 1, if length == 1 { 0 } else { expected }));
        assert_eq!(shape(&found["cost_to_go"]), (states, states));
        // Tables of up to 10000 numbers are spelled out unasked.
        let gains = found["gains"].as_array().unwrap();
        assert_eq!(gains.len(), length + 1);
        assert!(gains.iter().all(|gain| shape(gain) == (length, states + sent)), "{name}");
        let floats = length * (states + expected) + length * (length - 1) / 2;
        assert_eq!(found["table_floats"], floats);
        assert_eq!(found["coupled_table_floats"], (length + 1) * length * (states + sent));
    }
}

#[test]
fn gains_for_every_age_are_spelled_out_where_they_are_few_or_asked_for() {
    let gains = |options: &[&str]| report("double_integrator", options)["gains"].take();
    // (N + 1) N (2 + N (N - 1) / 2) numbers: 7524 and 10608.
    assert_eq!(gains(&["--sequence-length", "11"]).as_array().unwrap().len(), 12);
    for method in ["in-flight", "coupled"] {
        let twelve = ["--sequence-length", "12", "--method", method];
        assert!(gains(&twelve).is_null(), "{method}");
        let spelled = gains(&[&twelve[..], &["--mode-gains"]].concat());
        let shapes: Vec<_> = spelled.as_array().unwrap().iter().map(shape).collect();
        assert_eq!(shapes, [(12, 2 + 66); 13], "{method}");
    }
    let text = gain_gen("report", &example("double_integrator"), &["--mode-gains"]);
    assert_eq!(text.status.code(), Some(2), "asked for without --json");
}

#[test]
fn the_page_of_json_fields_names_every_field() {
    let page = include_str!("../../docs/report-json.md");
    for name in ["pendulum", "drive_tracking", "pendulum_event", "pendulum_can"] {
        // Whatever the verdict.
        for field in object(&gain_gen("report", &example(name), &["--json"])).as_object().unwrap().keys() {
            assert!(page.contains(&format!("`{field}`")), "{field}");
        }
    }
}

#[test]
fn both_methods_report_the_same_gains() {
    let (ours, reference) = (report("critical", &[]), report("critical", &["--method", "coupled"]));
    assert_eq!(reference["method"], "coupled");
    for field in ["control_cost", "mean_square_rate"] {
        let (ours, reference) = (ours[field].as_f64().unwrap(), reference[field].as_f64().unwrap());
        assert!((ours / reference - 1.0).abs() < 1e-9, "{field}: {ours} {reference}");
    }
}

#[test]
fn the_double_integrator_with_twenty_inputs_takes_610_numbers_instead_of_80640() {
    let found = report("double_integrator", &["--sequence-length", "20"]);
    assert_eq!((&found["table_floats"], &found["coupled_table_floats"]), (&610.into(), &80640.into()));
}

#[test]
fn sequences_too_short_for_the_critical_plant_fail_by_theorem_3_4_b() {
    for (length, growth) in [("1", "1.6875"), ("2", "1.125")] {
        let options = ["--json", "--sequence-length", length];
        let output = gain_gen("report", &example("critical"), &options);
        assert_eq!(output.status.code(), Some(3));
        let found = object(&output);
        assert_eq!((&found["converged"], &found["verdict"]), (&false.into(), &"unstable".into()));
        assert_eq!((&found["n_min"], &found["n_crit"]), (&3.into(), &3.into()));
        assert!(found["control_cost"].is_null());
        let sentence = format!(
            "Theorem 3.4 b): (1 - Q(N-1)) |lambda_max(A)|^2 = {growth} > 1: the actuator's buffer runs dry too \
             often; the shortest length not ruled out is N = 3"
        );
        assert_eq!(found["failed_conditions"], Value::Array(vec![sentence.clone().into()]));
        assert!(text(&output.stderr).contains(&sentence), "{}", text(&output.stderr));
    }
}

#[test]
fn a_recursion_that_diverges_fails_by_theorem_3_3_b() {
    // One input for two unstable modes: their product decides, which Theorem 3.4 b) does not see.
    let folder = tempfile::tempdir().unwrap();
    let changes = [
        ("a = [[0.5, 0], [1, 1.5]], b = [[1], [0]]", "a = [[1.3, 0], [0, 1.2]], b = [[1], [1]]"),
        ("delays = [0.25, 0.25, 0.25, 0.25]", "delays = [0.55]"),
        ("sequence_length = 4", "sequence_length = 1"),
    ];
    let design = altered(folder.path(), &example("critical"), &changes);
    let output = gain_gen("report", &design, &["--json"]);
    assert_eq!(output.status.code(), Some(3));
    let found = object(&output);
    let critical = &found["n_crit"];
    assert_eq!(found["n_min"], 1);
    assert!(critical.as_u64().is_some_and(|length| length > 1), "{critical}");
    let stderr = text(&output.stderr);
    assert!(stderr.contains("Theorem 3.3 b): the recursion does not converge; mean-square rate"), "{stderr}");
    assert!(
        stderr.contains(&format!("the shortest length that stabilises is N_crit = {critical}")),
        "{stderr}"
    );
}

#[test]
fn a_sensor_link_that_loses_too_much_fails_by_theorem_3_4_a() {
    let folder = tempfile::tempdir().unwrap();
    let changes = [
        ("sensor_to_controller.delays = [1.0]", "sensor_to_controller.delays = [0.2, 0, 0, 0.6]"),
        ("measurement_buffer = 11", "measurement_buffer = 2"),
    ];
    let design = altered(folder.path(), &example("critical"), &changes);
    let output = gain_gen("report", &design, &["--json"]);
    assert_eq!(output.status.code(), Some(3));
    assert_eq!(object(&output)["converged"], false);
    let stderr = text(&output.stderr);
    assert!(stderr.contains("Theorem 3.4 a): (1 - q_arr) |lambda_max(A)|^2 = 1.8 >= 1"), "{stderr}");
    assert!(stderr.contains("within the buffer of N^B = 2 steps"), "{stderr}");
    assert!(stderr.contains("the shortest buffer not ruled out is N^B = 3"), "{stderr}");
}

#[test]
fn text_report_gives_the_figures_with_their_units() {
    let output = gain_gen("report", &example("pendulum"), &[]);
    assert_eq!(output.status.code(), Some(0));
    let shown = text(&output.stdout);
    for part in [
        "pendulum: sequences of N = 4 inputs, default input zero",
        "4 states, 1 input, 2 outputs",
        "sample time         0.02 s",
        "Stability: stable",
        "mean-square rate    0.966134",
        "29.02 steps = 0.5805 s",
        "34 numbers, 136 bytes",
        "200 numbers, 800 bytes",
    ] {
        assert!(shown.contains(part), "no {part:?} in\n{shown}");
    }
    assert!(shown.lines().count() <= 42, "more than a screen");
}

#[test]
fn the_report_says_what_is_acknowledged_and_what_its_figures_hold_for() {
    let folder = tempfile::tempdir().unwrap();
    let caveat = "costs hold for instant acknowledgement; here the costs are lower bounds";
    for (acknowledgement, line, estimator, cycles) in [
        ("\"instant\"", "acknowledgement     instant; estimator single\n", "single", Some(8)),
        ("\"none\"", "acknowledgement     none; estimator linear\n", "linear", None),
        (
            "{ delays = [0.5, 0.25] }\nacknowledged_cycles = 3",
            "acknowledgement     mean delay 0.3333 steps = 0.006667 s, 25.00 % lost, 3 cycles in each; estimator single\n",
            "single",
            Some(3),
        ),
    ] {
        let changes = [("acknowledgement = \"instant\"", format!("acknowledgement = {acknowledgement}"))];
        let changes = changes.each_ref().map(|(from, to)| (*from, to.as_str()));
        let design = altered(folder.path(), &example("pendulum"), &changes);
        let output = gain_gen("report", &design, &[]);
        let is_instant = acknowledgement == "\"instant\"";
        assert_eq!(output.status.code(), Some(if is_instant { 0 } else { 3 }), "{}", text(&output.stderr));
        let shown = text(&output.stdout);
        assert!(shown.contains(line), "no {line:?} in\n{shown}");
        assert_eq!(shown.contains(caveat), acknowledgement.starts_with('{'), "{shown}");
        let is_linear = shown.contains("Without acknowledgements, estimation included\n  mean-square rate");
        assert_eq!(is_linear, estimator == "linear", "{shown}");
        let found = object(&gain_gen("report", &design, &["--json"]));
        assert_eq!((&found["estimator"], &found["acknowledged_cycles"]), (&estimator.into(), &cycles.into()));
    }
}

#[test]
fn a_wrong_design_names_file_line_and_key_and_leaves_the_output_alone() {
    let folder = tempfile::tempdir().unwrap();
    let design = altered(folder.path(), &example("pendulum"), &[("sample_time = 0.02", "sample_time = -1")]);
    let target = folder.path().join("gains.rs");
    std::fs::write(&target, "as before").unwrap();
    let output = gain_gen("emit", &design, &["--to", "rust", "--output", target.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let stderr = text(&output.stderr);
    let design = std::fs::read_to_string(&design).unwrap();
    let line = 1 + design.lines().position(|line| line.starts_with("sample_time")).unwrap();
    assert!(stderr.contains(&format!("altered.toml:{line}: plant.sample_time: found")), "{stderr}");
    assert_eq!(std::fs::read_to_string(&target).unwrap(), "as before");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "something was left behind");
}

#[test]
fn a_design_that_cannot_be_stabilised_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("gains.json");
    let to_target = ["--to", "json", "--sequence-length", "2", "--output", target.to_str().unwrap()];
    let output = gain_gen("emit", &example("critical"), &to_target);
    assert_eq!(output.status.code(), Some(3));
    assert!(text(&output.stderr).contains("Theorem 3.4 b)"), "{}", text(&output.stderr));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn emission_is_the_same_to_the_byte_every_time_and_replaces_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    for format in ["rust", "json"] {
        let target = folder.path().join(format);
        std::fs::write(&target, "something else").unwrap();
        let written: Vec<_> = (0..2)
            .map(|_| {
                let options = ["--to", format, "--output", target.to_str().unwrap()];
                let output = gain_gen("emit", &example("double_integrator"), &options);
                assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
                assert!(output.stdout.is_empty());
                std::fs::read(&target).unwrap()
            })
            .collect();
        assert_eq!(written[0], written[1]);
        assert!(text(&written[0]).contains("double_integrator"));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "temporary files were left behind");
}

#[test]
fn emitted_json_is_the_report_with_model_and_settings() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("gains.json");
    let output =
        gain_gen("emit", &example("pendulum"), &["--to", "json", "--output", target.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let written: Value = serde_json::from_slice(&std::fs::read(&target).unwrap()).unwrap();
    for (field, value) in report("pendulum", &[]).as_object().unwrap() {
        assert_eq!(&written[field], value, "{field}");
    }
    assert_eq!((&written["format"], &written["format_version"]), (&"slqg-gains".into(), &1.into()));
    assert_eq!((&written["sample_time"], &written["scalar"]), (&0.02.into(), &"f32".into()));
    assert_eq!((&written["measurement_buffer"], &written["input_limits"]), (&11.into(), &Value::Null));
    assert_eq!((&written["estimator"], &written["acknowledged_cycles"]), (&"single".into(), &8.into()));
    let model = &written["model"];
    for (field, expected) in [
        ("a", (4, 4)),
        ("b", (4, 1)),
        ("c", (2, 4)),
        ("process_noise", (4, 4)),
        ("measurement_noise", (2, 2)),
        ("initial_covariance", (4, 4)),
    ] {
        assert_eq!(shape(&model[field]), expected, "{field}");
    }
    assert_eq!(model["initial_mean"], serde_json::json!([0.0, 0.2, 0.0, 0.2]));
}

#[test]
fn a_number_that_the_device_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let design = altered(folder.path(), &example("pendulum"), &[("[0, 0, 0, 0],\n]", "[0, 0, 0, 1e39],\n]")]);
    let target = folder.path().join("gains.rs");
    let output = gain_gen("emit", &design, &["--to", "rust", "--output", target.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let stderr = text(&output.stderr);
    assert!(stderr.contains("plant.process_noise") && stderr.contains("controller.scalar"), "{stderr}");
    assert!(!target.exists());
}

#[test]
fn what_cannot_be_read_written_or_understood_is_status_2() {
    let pendulum = example("pendulum");
    for (command, design, options, part) in [
        ("report", &pendulum, &["--sequence-length", "0"][..], "from 1 to 128"),
        ("report", &pendulum, &["--sequence-length", "129"], "from 1 to 128"),
        ("report", &pendulum, &["--default-input", "none"], "zero, hold"),
        ("report", &pendulum, &["--method", "guess"], "in-flight, coupled"),
        ("report", &PathBuf::from("nowhere.toml"), &[], "nowhere.toml: cannot be read"),
        ("emit", &pendulum, &["--to", "rust"], "--output"),
        (
            "emit",
            &pendulum,
            &["--to", "rust", "--output", "/nowhere/gains.rs"],
            "/nowhere/gains.rs: cannot be written",
        ),
        ("advise", &pendulum, &[], "unrecognized subcommand"),
    ] {
        let output = gain_gen(command, design, options);
        let stderr = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{options:?}: {stderr}");
        assert!(stderr.contains(part), "{options:?}: {stderr}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn a_warning_goes_to_stderr_report_and_json_and_changes_no_status() {
    let folder = tempfile::tempdir().expect("a folder");
    let example = example("double_integrator");
    let design = altered(folder.path(), &example, &[("[[0.01, 0], [0, 0.01]]", "[[0, 0], [0, 0]]")]);
    let said = format!("warning: {}:13: plant.process_noise: found no noise at all", design.display());
    let report = gain_gen("report", &design, &[]);
    assert_eq!(report.status.code(), Some(0));
    assert!(text(&report.stderr).starts_with(&said), "{}", text(&report.stderr));
    assert!(
        text(&report.stdout).contains("\nWarnings\n  plant.process_noise (line 13): found no noise at all"),
        "{}",
        text(&report.stdout)
    );
    let json = gain_gen("report", &design, &["--json"]);
    let told = object(&json)["warnings"][0].as_str().expect("a text").to_owned();
    assert!(told.starts_with("plant.process_noise (line 13): found no noise at all"), "{told}");
    assert!(text(&json.stderr).starts_with(&said));
    let sensible = gain_gen("report", &example, &["--json"]);
    assert_eq!(object(&sensible)["warnings"], Value::Array(vec![]));
}
