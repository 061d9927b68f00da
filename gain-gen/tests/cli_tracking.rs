//! The command line on designs with `[tracking]` and `[event]`: text, JSON, tasks, and formats that do not carry them.

use command::{altered, gain_gen, object, shape, text};
use serde_json::Value;
use std::path::{Path, PathBuf};

mod command;

/// Two inputs, two tracked outputs with a reference, hold, `[event]`.
fn lift() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/lift.toml")
}

/// One input at a set point, zero.
fn hoist() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hoist.toml")
}

/// What takes `[event]` out of `lift`.
const NO_EVENT: (&str, &str) = ("[event]\nsend_cost = 3\n", "");
/// What takes the reference out of it.
const NO_REFERENCE: (&str, &str) =
    ("reference = [[0, 0, 0], [0.25, 1, -2], [1, 3, 0.5]]\ninterpolation = \"linear\"\n", "");

fn shown(design: &Path, options: &[&str]) -> String {
    let output = gain_gen("report", design, options);
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), ""));
    text(&output.stdout).into()
}

fn reported(design: &Path, options: &[&str]) -> Value {
    let output = gain_gen("report", design, &[options, &["--json"]].concat());
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), ""));
    object(&output)
}

fn contains(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no {part:?} in\n{text}");
    }
}

#[test]
fn the_report_tells_preview_send_cost_and_their_tables() {
    let report = shown(&lift(), &[]);
    let parts = [
        "Tracking: 2 outputs, reference of the design\n  preview             4 steps = 0.4 s ahead\n",
        "beyond the preview  30.84 %     of the gains",
        "Closed loop, state known, a packet sent in every step",
        "Event trigger\n  send cost           3           per packet, in units of the stage cost",
        "preview gains       96 numbers, 384 bytes",
        "event trigger       67 numbers, 268 bytes",
    ];
    contains(&report, &parts);
    // Without the trigger half of the preview gains is not needed.
    let folder = tempfile::tempdir().unwrap();
    let report = shown(&altered(folder.path(), &lift(), &[NO_EVENT, NO_REFERENCE]), &[]);
    contains(&report, &["reference given at run time", "preview gains       48 numbers, 192 bytes"]);
    assert!(!report.contains("vent trigger") && !report.contains("sent in every step"), "{report}");
}

#[test]
fn a_set_point_is_told_with_its_input_and_price_and_hold_as_the_way_out() {
    let report = shown(&hoist(), &[]);
    let parts = [
        "Tracking: 1 output at the set point [1.5]\n  input that holds it [-0.0882353]\n",
        "  standing cost       0.000497937 per step, on top of the long-run cost\n",
        "with default input hold it is 0",
    ];
    contains(&report, &parts);
    let report = shown(&hoist(), &["--default-input", "hold"]);
    contains(&report, &["  standing cost       0           per step"]);
    assert!(!report.contains("with default input hold"), "{report}");
}

#[test]
fn a_trigger_is_told_what_sending_always_costs_where_that_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let design = altered(folder.path(), &hoist(), &[("[tracking]", "[event]\nsend_cost = 2\n\n[tracking]")]);
    let found = reported(&design, &[]);
    let cost = found["estimation"]["expected_cost_upper"].as_f64().unwrap()
        + found["tracking"]["standing_cost"].as_f64().unwrap()
        + 2.0;
    contains(
        &shown(&design, &[]),
        &[&format!("long-run cost       at most {cost:.5} per step, packets and")],
    );
    assert!(!shown(&lift(), &[]).contains("that of sending always"), "it depends on the reference");
}

#[test]
fn json_has_the_tables_of_tracking_and_trigger() {
    // N = 3, nx = nu = nz = 2, T = 4, and with hold n_v = 3.
    let found = reported(&lift(), &[]);
    let fields: Vec<_> = found.as_object().unwrap().keys().map(String::as_str).collect();
    assert!(fields.contains(&"tracking") && fields.contains(&"event"), "{fields:?}");
    let tracking = &found["tracking"];
    assert_eq!(tracking["z"], serde_json::json!([[1.0, 0.0], [0.5, -1.0]]));
    assert_eq!((&tracking["preview"], &tracking["standing_cost"]), (&4.into(), &Value::Null));
    assert!(tracking["tail"].as_f64().is_some_and(|tail| 0.0 < tail && tail < 1.0));
    assert_eq!((shape(&tracking["gains"]), shape(&tracking["displaced"])), ((6, 8), (6, 8)));
    let event = &found["event"];
    assert_eq!((&event["send_cost"], shape(&event["state"])), (&3.0.into(), (2, 6)));
    let triangle = |matrix: &Value| -> Vec<_> {
        matrix.as_array().unwrap().iter().map(|row| row.as_array().unwrap().len()).collect()
    };
    let in_flight: Vec<_> = event["in_flight"].as_array().unwrap().iter().map(triangle).collect();
    assert_eq!(in_flight, [vec![6, 5, 4, 3, 2, 1], vec![4, 3, 2, 1], vec![2, 1]]);
    assert_eq!(triangle(&event["sequence"]), [6, 5, 4, 3, 2, 1]);

    let found = reported(&hoist(), &[]);
    let tracking = &found["tracking"];
    assert_eq!((&tracking["preview"], &tracking["displaced"]), (&1.into(), &Value::Null));
    assert_eq!(shape(&tracking["gains"]), (3, 1));
    assert!(tracking["standing_cost"].as_f64().is_some_and(|cost| cost > 0.0));
    assert_eq!(found["event"], Value::Null);
}

#[test]
fn a_loop_that_is_not_stable_has_no_such_tables() {
    let folder = tempfile::tempdir().unwrap();
    let design = altered(folder.path(), &lift(), &[("[0.5, 0.25, 0.1]", "[0.1]")]);
    let output = gain_gen("report", &design, &["--json"]);
    assert_eq!(output.status.code(), Some(3));
    let found = object(&output);
    assert_eq!((&found["tracking"]["gains"], &found["tracking"]["tail"]), (&Value::Null, &Value::Null));
    assert_eq!((shape(&found["tracking"]["z"]), &found["event"]["send_cost"]), ((2, 2), &3.0.into()));
    assert_eq!((&found["event"]["state"], &found["event"]["sequence"]), (&Value::Null, &Value::Null));
}

#[test]
fn the_coupled_method_tells_the_same_of_tracking_and_trigger() {
    let (ours, reference) = (reported(&lift(), &[]), reported(&lift(), &["--method", "coupled"]));
    assert_eq!((&ours["tracking"], &ours["event"]), (&reference["tracking"], &reference["event"]));
}

#[test]
fn a_task_follows_the_reference_and_tells_what_knowing_it_ahead_is_worth() {
    let folder = tempfile::tempdir().unwrap();
    let design = altered(folder.path(), &lift(), &[NO_EVENT]);
    let task = &reported(&design, &["--horizon", "12"])["task"];
    assert_eq!((&task["cycles"], shape(&task["feedforward"])), (&12.into(), (12, 6)));
    let (cost, surprise) = (task["control_cost"].as_f64().unwrap(), task["surprise_cost"].as_f64().unwrap());
    assert!(cost > 0.0 && surprise > 0.0, "{cost} {surprise}");
    let report = shown(&design, &["--horizon", "12"]);
    let parts =
        ["Task of 12 steps = 1.2 s", "state known, reference known ahead", "not known ahead", "Lx, M, Uff"];
    contains(&report, &parts);
    // A set point is never a surprise.
    assert_eq!(reported(&hoist(), &["--horizon", "5"])["task"]["surprise_cost"], 0.0);
    // Without a reference there is neither.
    let pendulum = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs/pendulum.toml");
    let task = &reported(&pendulum, &["--horizon", "2"])["task"];
    assert_eq!((&task["feedforward"], &task["surprise_cost"]), (&Value::Null, &Value::Null));
}

#[test]
fn what_a_task_cannot_have_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let unknown = altered(folder.path(), &lift(), &[NO_EVENT, NO_REFERENCE]);
    let target = folder.path().join("task.rs");
    let to_target = ["--to", "rust", "--output", target.to_str().unwrap(), "--horizon", "3"];
    for (design, part) in [
        (
            &lift(),
            "--horizon: found [event]: what sending a packet is worth is known for a loop that goes on",
        ),
        (
            &unknown,
            "--horizon: tracking.reference is missing: the feedforward of a task is computed beforehand",
        ),
    ] {
        for output in [gain_gen("report", design, &["--horizon", "3"]), gain_gen("emit", design, &to_target)]
        {
            assert_eq!((output.status.code(), text(&output.stdout)), (Some(2), ""));
            contains(text(&output.stderr), &[part]);
        }
    }
    assert!(!target.exists());
}

#[test]
fn a_preview_without_end_is_refused_by_its_key() {
    // An integrator whose input is dear takes its time: ten thousand samples are not enough.
    let folder = tempfile::tempdir().unwrap();
    let changes = [
        ("a = [[1.1, 0.3], [0, 0.8]], b = [[0.2], [1]]", "a = [[1, 0], [0, 0.8]], b = [[1], [0]]"),
        ("c = [[1, 0]]", "c = [[1, 1]]"),
        ("q = [[2]]", "q = [[1e-8]]"),
        ("r = [[0.5]]", "r = [[1]]"),
        ("set_point = [1.5]", ""),
    ];
    let design = altered(folder.path(), &hoist(), &changes);
    let target = folder.path().join("gains.rs");
    let to_target = ["--to", "rust", "--output", target.to_str().unwrap()];
    for output in [gain_gen("report", &design, &[]), gain_gen("emit", &design, &to_target)] {
        assert_eq!((output.status.code(), text(&output.stdout)), (Some(2), ""));
        contains(text(&output.stderr), &["error: tracking.preview_tolerance: 10000 samples ahead leave"]);
    }
    assert!(!target.exists());
    let shorter = altered(folder.path(), &design, &[("z = [[1, 0]]", "z = [[1, 0]]\npreview = 100")]);
    contains(&shown(&shorter, &[]), &["preview             100 steps = 10 s ahead"]);
}

#[test]
fn formats_of_the_law_alone_refuse_what_they_would_leave_out() {
    let folder = tempfile::tempdir().unwrap();
    let only_event = folder.path().join("event");
    std::fs::create_dir(&only_event).unwrap();
    let pendulum = Path::new(env!("CARGO_MANIFEST_DIR")).join("../designs/pendulum.toml");
    let event =
        altered(&only_event, &pendulum, &[("[controller]", "[event]\nsend_cost = 1\n\n[controller]")]);
    for (design, key, missing) in
        [(&hoist(), "tracking", "the feedforward"), (&event, "event", "the decision whether to send")]
    {
        for format in ["c", "blob"] {
            let target = folder.path().join("law.h");
            let options = ["--to", format, "--output", target.to_str().unwrap()];
            let output = gain_gen("emit", design, &options);
            assert_eq!(output.status.code(), Some(2));
            let sentence = format!(
                "error: {key}: {format} carries the law alone: {missing} would be missing; write rust or json\n"
            );
            assert_eq!(text(&output.stderr), sentence);
        }
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is written");
}

#[test]
fn a_price_or_set_point_that_the_device_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("gains.rs");
    for (design, change, part) in [
        (lift(), ("send_cost = 3", "send_cost = 1e39"), "event.send_cost: found 1e39"),
        // Rounded to zero it would send always.
        (lift(), ("send_cost = 3", "send_cost = 1e-50"), "event.send_cost: found 1e-50"),
        (hoist(), ("set_point = [1.5]", "set_point = [1e39]"), "tracking.set_point: found 1e39"),
    ] {
        let scalar = if design == hoist() { ("scalar = \"f64\"", "") } else { ("", "") };
        let design = altered(folder.path(), &design, &[change, scalar]);
        let output = gain_gen("emit", &design, &["--to", "rust", "--output", target.to_str().unwrap()]);
        assert_eq!(output.status.code(), Some(2));
        contains(text(&output.stderr), &[part, "which f32 cannot hold", "controller.scalar = \"f64\""]);
        assert!(!target.exists());
    }
}
