//! `report --certificate` and `report --margins` as users and scripts see them.

use assert_cmd::cargo::cargo_bin_cmd;
use gain_gen::certificate::Certificate;
use gain_gen::design::Design;
use gain_gen::solve::LoopProblem;
use nalgebra::DMatrix;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Output;

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name).with_extension("toml")
}

fn report(name: &str, options: &[&str]) -> Output {
    cargo_bin_cmd!("gain-gen")
        .arg("report")
        .arg(example(name))
        .args(options)
        .output()
        .expect("gain-gen starts")
}

fn text(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).expect("UTF-8")
}

fn matrices(list: &Value) -> Vec<DMatrix<f64>> {
    let matrix = |rows: &Value| {
        let rows: Vec<Vec<f64>> = serde_json::from_value(rows.clone()).expect("rows of numbers");
        DMatrix::from_fn(rows.len(), rows[0].len(), |row, column| rows[row][column])
    };
    list.as_array().expect("one matrix per mode").iter().map(matrix).collect()
}

#[test]
fn a_certificate_read_back_from_its_file_is_verified() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["critical", "pendulum", "double_integrator_bad"] {
        let path = folder.path().join(name);
        let output = report(name, &["--certificate", path.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(0), "{name}");
        let file: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).expect("JSON");
        assert_eq!((&file["format"], &file["format_version"]), (&"slqg-certificate".into(), &1.into()));
        let problem = LoopProblem::of(&Design::load(&example(name)).expect("a design"));
        let (gains, x) = (matrices(&file["gains"]), matrices(&file["x"]));
        let verified = Certificate::verify(&problem, &gains, x).expect(name);
        assert_eq!(file["rate_bound"], verified.rate_bound());
        let (count, size) = (problem.length + 1, verified.matrices()[0].nrows());
        let line =
            format!("certificate         verified by Cholesky, N+1 = {count} matrices of {size} x {size}");
        assert!(text(&output).contains(&line), "{name}: {}", text(&output));
        for field in ["a_hat", "b_hat", "transition_matrix"] {
            assert_eq!(file[field].as_array().expect(field).len(), count, "{name}: {field}");
        }
    }
}

#[test]
fn an_unstable_loop_writes_no_certificate_and_has_no_margins() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.json");
    let options = ["--sequence-length", "2", "--json", "--margins", "--certificate", path.to_str().unwrap()];
    let output = report("critical", &options);
    assert_eq!(output.status.code(), Some(3));
    assert!(!path.exists());
    let found: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(found["margins"].is_null());
}

#[test]
fn margins_are_told_when_asked_for() {
    let found = |options: &[&str]| -> Value {
        serde_json::from_slice(&report("critical", &[options, &["--json"]].concat()).stdout).expect("JSON")
    };
    assert!(found(&[])["margins"].is_null());
    let margins = &found(&["--margins"])["margins"];
    let figure = |name: &str| margins[name].as_f64().expect("a number");
    assert!(figure("extra_loss") > 0.0 && figure("extra_loss") < 1.0);
    assert!(figure("input_gain_min") < 1.0 && figure("input_gain_max") > 1.0);
    assert!(margins["extra_delay_steps"].is_u64());
    let flashed = &margins["flashed"];
    assert!(margins["flashed_not_given"].is_null());
    // Wired to its controller, the sensor is as good as the state.
    assert_eq!(flashed["control"]["extra_loss"], margins["extra_loss"]);
    for (of, least, greatest) in [(&flashed["input_gain"], 0.78, 1.3), (&flashed["entries"][2], 0.87, 1.05)] {
        let bound = |name: &str| of[name].as_f64().expect("a number");
        assert!(least < bound("min") && bound("min") < 1.0 && 1.0 < bound("max") && bound("max") < greatest);
    }
    assert!(flashed["accuracy"].is_null());
    let output = report("critical", &["--margins"]);
    for line in [
        "Margins of the loop as flashed",
        "  a[2,2] = 1.5",
        "Margins, state known",
        "  extra loss",
        "  extra delay",
        "  input gain",
    ] {
        assert!(text(&output).contains(line), "{line}");
    }
    assert!(!text(&report("critical", &[])).contains("Margins"));
}

#[test]
fn margins_of_the_flashed_loop_that_are_not_known_are_not_told_and_say_why() {
    let output = report("pendulum_event", &["--margins"]);
    assert!(text(&output).contains("not given           with an event trigger"), "{}", text(&output));
    assert!(text(&output).contains("Margins, state known"));
}
