//! What the verdict rests on besides the theorems, and what is written for a device without it.

use command::{altered, gain_gen, object, shape, text};
use gain_gen::build::Compile;
use serde_json::Value;
use std::path::{Path, PathBuf};

mod command;

const ACCEPT: &str = "--accept-undecided-stability";

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name).with_extension("toml")
}

fn of_tests(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name).with_extension("toml")
}

/// Verdict, whether the loop of the theorems is stable, and the conditions; the status must be that of the verdict.
fn judged(design: &Path) -> (String, bool, Vec<String>) {
    let output = gain_gen("report", design, &["--json"]);
    let found = object(&output);
    let verdict = found["verdict"].as_str().unwrap().to_owned();
    let expected = if verdict == "stable" { 0 } else { 3 };
    assert_eq!(output.status.code(), Some(expected), "{}", text(&output.stderr));
    let conditions = found["failed_conditions"].as_array().unwrap();
    let conditions: Vec<_> = conditions.iter().map(|text| text.as_str().unwrap().to_owned()).collect();
    for condition in &conditions {
        assert!(text(&output.stderr).contains(condition), "{}", text(&output.stderr));
    }
    (verdict, found["converged"].as_bool().unwrap(), conditions)
}

#[test]
fn an_unstable_plant_under_limits_is_not_stable() {
    let (verdict, converged, conditions) = judged(&of_tests("oscillator"));
    assert_eq!((verdict.as_str(), converged), ("undecided", true));
    let [condition] = conditions.as_slice() else { panic!("{conditions:?}") };
    assert!(condition.starts_with("controller.input_limits: |lambda_max(A)| = 1.05 > 1"), "{condition}");
}

#[test]
fn a_plant_that_comes_back_by_itself_is_stable_under_limits() {
    let folder = tempfile::tempdir().unwrap();
    let changes = [("0.803084297", "0.6"), ("0.803084297", "0.6")];
    let (verdict, converged, conditions) = judged(&altered(folder.path(), &of_tests("oscillator"), &changes));
    assert_eq!((verdict.as_str(), converged, conditions), ("stable", true, vec![]));
}

#[test]
fn acknowledgements_that_are_not_all_in_time_leave_it_undecided() {
    let folder = tempfile::tempdir().unwrap();
    for (acknowledgement, expected) in [
        ("\"none\"", Some("none comes in time")),
        ("{ delays = [0.75, 0.25] }", Some("75.00 % come in time")),
        ("{ delays = [1.0] }", None),
    ] {
        let changed = format!("acknowledgement = {acknowledgement}");
        let changes = [
            ("acknowledgement = \"instant\"", changed.as_str()),
            ("[controller]", "[controller]\nestimator = \"single\""),
        ];
        let (verdict, converged, conditions) =
            judged(&altered(folder.path(), &example("pendulum"), &changes));
        assert!(converged);
        assert_eq!(verdict, if expected.is_some() { "undecided" } else { "stable" });
        assert_eq!(conditions.len(), usize::from(expected.is_some()));
        for condition in conditions {
            assert!(condition.starts_with("network.acknowledgement: "), "{condition}");
            assert!(condition.contains(expected.unwrap()), "{condition}");
        }
    }
}

#[test]
fn an_estimate_whose_error_grows_does_not_make_a_stable_loop() {
    let (verdict, converged, conditions) = judged(&of_tests("quarter_turn"));
    assert_eq!((verdict.as_str(), converged), ("unstable", false));
    let [condition] = conditions.as_slice() else { panic!("{conditions:?}") };
    assert!(condition.contains("q_arr = 40.00 % of the measurements count"), "{condition}");
    let folder = tempfile::tempdir().unwrap();
    let above = [("sensor_to_controller.delays = [0.4]", "sensor_to_controller.delays = [0.52]")];
    let (verdict, ..) = judged(&altered(folder.path(), &of_tests("quarter_turn"), &above));
    assert_eq!(verdict, "stable");
}

#[test]
fn an_axis_with_one_integrator_is_on_the_limit_wherever_it_is_told() {
    for name in ["drive_tracking", "double_integrator"] {
        let output = gain_gen("report", &example(name), &[]);
        let shown = text(&output.stdout);
        assert!(shown.contains("per step: on the limit of stability"), "{shown}");
        assert!(!shown.contains("doubles in"), "{shown}");
    }
}

#[test]
fn an_undecided_loop_is_written_only_if_that_is_accepted_and_the_source_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for (format, file) in [("rust", "law.rs"), ("c", "law.h"), ("json", "law.json"), ("blob", "law.blob")] {
        let target = folder.path().join(file);
        let options = ["--to", format, "--output", target.to_str().unwrap()];
        let refused = gain_gen("emit", &of_tests("oscillator"), &options);
        assert_eq!(refused.status.code(), Some(3));
        assert!(text(&refused.stderr).contains(ACCEPT), "{}", text(&refused.stderr));
        assert!(text(&refused.stderr).contains("controller.input_limits"), "{}", text(&refused.stderr));
        assert!(!target.exists());
        let accepted = gain_gen("emit", &of_tests("oscillator"), &[&options[..], &[ACCEPT]].concat());
        assert_eq!(accepted.status.code(), Some(0), "{}", text(&accepted.stderr));
        let written = std::fs::read(&target).unwrap();
        match format {
            "rust" | "c" => {
                let written = text(&written);
                assert!(
                    written.contains("Stability: undecided, which was accepted. Not shown:"),
                    "{written}"
                );
                assert!(
                    written.contains("- controller.input_limits: |lambda_max(A)| = 1.05 > 1"),
                    "{written}"
                );
            }
            "json" => {
                let written: Value = serde_json::from_slice(&written).unwrap();
                assert_eq!(written["accepted_undecided_stability"], true);
                assert_eq!((&written["verdict"], shape(&written["lx"])), (&"undecided".into(), (4, 2)));
            }
            _ => {}
        }
    }
}

#[test]
fn an_unstable_loop_is_not_written_even_if_undecided_ones_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("law.rs");
    let options = ["--sequence-length", "2", "--to", "rust", "--output", target.to_str().unwrap(), ACCEPT];
    let refused = gain_gen("emit", &example("critical"), &options);
    assert_eq!(refused.status.code(), Some(3));
    assert!(!text(&refused.stderr).contains(ACCEPT), "{}", text(&refused.stderr));
    assert!(!target.exists());
}

#[test]
fn a_build_script_accepts_undecided_stability_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let compile = Compile::new(of_tests("oscillator"));
    let refused = compile.run_into(folder.path()).unwrap_err().to_string();
    assert!(refused.contains("Compile::accept_undecided_stability"), "{refused}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    assert!(compile.accept_undecided_stability().run_into(folder.path()).is_ok());
}

#[test]
fn source_of_a_stable_loop_says_what_that_assumes() {
    let folder = tempfile::tempdir().unwrap();
    let written =
        Compile::new(example("pendulum")).accept_undecided_stability().run_into(folder.path()).unwrap();
    let written = std::fs::read_to_string(written).unwrap();
    assert!(
        written.contains("// Stability: stable in the mean square, if plant and noise are as"),
        "{written}"
    );
    assert!(!written.contains("accepted"));
}

/// A plant on which gains with a seventh digit more would do: its growth is met to within 1e-8.
const FINE: &str = "name = \"fine\"
[plant]
sample_time = 1
discrete = { a = [[1.00001, 0], [0, 0.5]], b = [[1e-3], [1]] }
c = [[1, 0], [0, 1]]
process_noise = [[1, 0], [0, 1]]
measurement_noise = [[1, 0], [0, 1]]
initial_mean = [0, 0]
initial_covariance = [[1, 0], [0, 1]]
[cost]
q = [[1e-12, 0], [0, 1e-12]]
r = [[1]]
[network]
controller_to_actuator.delays = [0.7, 0.2]
sensor_to_controller.delays = [1]
[controller]
sequence_length = 2
scalar = \"f32\"
";

#[test]
fn the_rate_that_decides_is_that_of_the_numbers_emitted() {
    use gain_gen::{
        design::Design,
        report::Report,
        solve::{LoopProblem, Method, mean_square_rate},
    };
    for text in [FINE.to_owned(), std::fs::read_to_string(example("pendulum")).unwrap()] {
        let design = Design::parse(&text, "design.toml").unwrap();
        let mut report = Report::new(&design, Method::InFlight);
        let law = report.solution.law.rounded_to(design.controller.scalar);
        assert!(law.lx.iter().all(|&gain| f64::from(gain as f32) == gain));
        assert_ne!(law.lx, report.solution.law.lx);
        let dense = mean_square_rate(&LoopProblem::of(&design), &law.mode_gains());
        assert!((report.emitted_rate / dense - 1.0).abs() < 1e-9, "{} {dense}", report.emitted_rate);
        assert_ne!(report.emitted_rate, report.solution.mean_square_rate);
        report.certify().unwrap();
        let file: Value = serde_json::from_str(&report.certificate_json().unwrap()).unwrap();
        let emitted = file["gains"][0][0][0].as_f64().unwrap();
        assert_eq!(emitted, law.lx[(0, 0)]);
    }
}

#[test]
fn rounding_is_seen_alike_through_the_dense_moments_and_through_the_recursion() {
    use gain_gen::{
        design::Design,
        report::Report,
        solve::{LoopProblem, Method, mean_square_rate},
    };
    // Too long for the dense ones in a report.
    let mut design = Design::load(&example("pendulum")).unwrap();
    design.set_sequence_length(8);
    let report = Report::new(&design, Method::InFlight);
    let law = report.solution.law.rounded_to(design.controller.scalar);
    let dense = mean_square_rate(&LoopProblem::of(&design), &law.mode_gains());
    // But for the rounding of r.
    assert!((report.emitted_rate - dense).abs() < 1e-7, "{} {dense}", report.emitted_rate);
}

#[test]
fn a_loop_that_rounding_makes_unstable_is_not_stable_and_not_written() {
    // The gain is all but the plant's growth, and f32 misses it by 3.
    let fast = "name = \"fast\"
[plant]
sample_time = 1
discrete = { a = [[123456789]], b = [[1]] }
c = [[1]]
process_noise = [[1]]
measurement_noise = [[1]]
initial_mean = [0]
initial_covariance = [[1]]
[cost]
q = [[1]]
r = [[1]]
[network]
controller_to_actuator.delays = [1]
sensor_to_controller.delays = [1]
[controller]
sequence_length = 1
scalar = \"f32\"
";
    let folder = tempfile::tempdir().unwrap();
    let design = folder.path().join("fast.toml");
    std::fs::write(&design, fast).unwrap();
    let (verdict, converged, conditions) = judged(&design);
    assert_eq!((verdict.as_str(), converged), ("unstable", true));
    assert!(conditions[0].starts_with("controller.scalar: the gains rounded to f32"), "{conditions:?}");
    let target = folder.path().join("law.rs");
    let options = ["--to", "rust", "--output", target.to_str().unwrap(), ACCEPT];
    assert_eq!(gain_gen("emit", &design, &options).status.code(), Some(3));
    assert!(!target.exists());
    let exact = altered(folder.path(), &design, &[("f32", "f64")]);
    assert_eq!(judged(&exact).0, "stable");
}
