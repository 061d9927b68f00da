//! The command line keeps its contract: JSON, exit status, files, determinism.

use assert_cmd::Command;
use serde_json::Value;
use std::{fs, path::PathBuf};

fn design(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name)
}

fn host_sim(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.args(arguments);
    command
}

fn run(name: &str, arguments: &[&str]) -> Command {
    let mut command = host_sim(&["run"]);
    command.arg(design(name)).args(["--runs", "20", "--steps", "40"]).args(arguments);
    command
}

fn stdout(mut command: Command) -> String {
    String::from_utf8(command.assert().success().get_output().stdout.clone()).expect("UTF-8")
}

#[test]
fn json_has_every_field_of_the_contract_and_nothing_else_is_printed() {
    let text = stdout(run("pendulum.toml", &["--json", "--seed", "5"]));
    let json: Value = serde_json::from_str(&text).expect("one JSON object");
    assert_eq!(json["name"], "pendulum");
    assert_eq!((&json["seed"], &json["runs"], &json["steps"]), (&5.into(), &20.into(), &40.into()));
    let results = json["results"].as_array().expect("results");
    assert_eq!(results.len(), 2);
    assert_eq!((&results[0]["controller"], &results[1]["controller"]), (&"slqg".into(), &"lqg".into()));
    for result in results {
        for key in ["mean_cost", "std_error", "median_cost", "p95_cost", "send_rate", "mean_input_age"] {
            assert!(result[key].is_f64(), "{key} in {result}");
        }
        assert!(result["sequence_length"].is_u64() && result["diverged"].is_u64(), "{result}");
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let with_threads = |threads: &str| {
        let mut command = run("double_integrator_bad.toml", &["--json"]);
        command.env("RAYON_NUM_THREADS", threads);
        stdout(command)
    };
    assert_eq!(with_threads("1"), with_threads("3"));
}

#[test]
fn another_seed_gives_other_numbers() {
    let with_seed = |seed: &str| stdout(run("double_integrator.toml", &["--json", "--seed", seed]));
    assert_ne!(with_seed("1").replace("\"seed\": 1", ""), with_seed("2").replace("\"seed\": 2", ""));
}

#[test]
fn the_sequence_length_can_be_overridden() {
    let text =
        stdout(run("double_integrator.toml", &["--controllers", "slqg", "--sequence-length", "2", "--json"]));
    let json: Value = serde_json::from_str(&text).expect("one JSON object");
    assert_eq!(json["results"][0]["sequence_length"], 2);
}

#[test]
fn a_loop_that_cannot_be_stabilised_exits_with_3() {
    let assertion = run("critical.toml", &["--sequence-length", "2"]).assert().code(3);
    let stderr = String::from_utf8_lossy(&assertion.get_output().stderr).into_owned();
    assert!(stderr.contains("critical.toml") && stderr.contains("stabilise"), "{stderr}");
}

#[test]
fn wrong_input_exits_with_2_and_says_why() {
    let says = |mut command: Command, expected: &str| {
        let assertion = command.assert().code(2);
        let stderr = String::from_utf8_lossy(&assertion.get_output().stderr).into_owned();
        assert!(stderr.contains(expected), "{stderr}");
        assert!(assertion.get_output().stdout.is_empty());
    };
    says(run("missing.toml", &[]), "missing.toml");
    says(
        run("pendulum.toml", &["--controllers", "pid"]),
        "no controller is called `pid`; there are: slqg, slqg-always, slqg-periodic, slqg-no-preview, slqg-channel, slqg-tuning, slqg-told, slqg-task, slqg-udp, slqg-udp-rounded, lqg",
    );
    says(run("pendulum.toml", &["--sequence-length", "0"]), "--sequence-length");
    says(run("pendulum.toml", &["--sequence-length", "40"]), "controller.sequence_length: found 40");
}

#[test]
fn a_sweep_has_a_row_for_each_length_that_can_be_stabilised_and_one_without_network() {
    let sweep = |lengths: &str| {
        let mut command =
            host_sim(&["sweep", "--runs", "5", "--steps", "20", "--json", "--lengths", lengths]);
        command.arg(design("critical.toml"));
        command
    };
    let text = stdout(sweep("1..=4"));
    let json: Value = serde_json::from_str(&text).expect("one JSON object");
    let rows: Vec<_> = json["results"].as_array().expect("results").iter().collect();
    let found: Vec<_> =
        rows.iter().map(|row| (row["controller"].as_str(), row["sequence_length"].as_u64())).collect();
    assert_eq!(found, [(Some("slqg"), Some(3)), (Some("slqg"), Some(4)), (Some("lqg"), Some(1))]);
    let mut hopeless = sweep("1,2");
    let assertion = hopeless.args(["--controllers", "slqg"]).assert().code(3);
    let stderr = String::from_utf8_lossy(&assertion.get_output().stderr).into_owned();
    assert!(
        stderr.contains("N = 1") && stderr.contains("N = 2") && stderr.contains("Theorem 3.4 b)"),
        "{stderr}"
    );
}

#[test]
fn the_total_with_the_cost_of_sending_is_told_where_packets_have_a_price() {
    let result = |name: &str| -> Value {
        let text = stdout(run(name, &["--json", "--controllers", "slqg"]));
        serde_json::from_str::<Value>(&text).expect("one JSON object")["results"][0].clone()
    };
    let priced = result("pendulum_event.toml");
    let number = |key: &str| priced[key].as_f64().expect("a number");
    let sending = 1000.0 * number("send_rate") * 40.0;
    assert!((number("mean_total_cost") - number("mean_cost") - sending).abs() < 1e-6 * sending);
    assert!(priced["total_std_error"].is_f64());
    assert!(result("pendulum.toml").get("mean_total_cost").is_none());
}

#[test]
fn a_controller_that_makes_no_difference_is_refused_with_the_reason() {
    let says = |name: &str, controller: &str, expected: &str| {
        let assertion = run(name, &["--controllers", controller]).assert().code(2);
        let stderr = String::from_utf8_lossy(&assertion.get_output().stderr).into_owned();
        assert!(stderr.contains(name) && stderr.contains(expected), "{stderr}");
    };
    says("pendulum.toml", "slqg-always", "`slqg-always` is `slqg` here: the design has no [event]");
    says(
        "pendulum.toml",
        "slqg-no-preview",
        "`slqg-no-preview` is `slqg` here: the design has no [tracking]",
    );
    says("pendulum_event.toml", "slqg-task", "`slqg-task` cannot be event-triggered");
}

#[test]
fn a_design_that_tracks_what_it_does_not_give_is_refused_with_the_key() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("axis.toml");
    let text = fs::read_to_string(design("drive_tracking.toml")).expect("the design");
    let at_run_time = &text[..text.find("# 100 mm there").expect("the reference")];
    fs::write(&path, at_run_time).expect("written");
    let assertion = host_sim(&["run"]).arg(&path).assert().code(2);
    let stderr = String::from_utf8_lossy(&assertion.get_output().stderr).into_owned();
    assert!(stderr.contains("axis.toml: tracking.reference: missing"), "{stderr}");
}

#[test]
fn a_set_point_is_stood_at_and_the_report_shows_the_tracked_output() {
    let folder = tempfile::tempdir().expect("a folder");
    let [path, report] = ["axis.toml", "report.html"].map(|name| folder.path().join(name));
    let text = fs::read_to_string(design("drive_tracking.toml")).expect("the design");
    let from = text.find("preview =").expect("the preview");
    fs::write(&path, format!("{}set_point = [25]\n", &text[..from])).expect("written");
    let mut command =
        host_sim(&["run", "--controllers", "slqg", "--steps", "400", "--runs", "5", "--report"]);
    let text = stdout({
        command.arg(&report).arg(&path);
        command
    });
    assert!(text.contains("(z-ref)'Q(z-ref) + (u-u_ref)'R(u-u_ref)"), "{text}");
    let html = fs::read_to_string(&report).expect("the report");
    assert!(html.contains("tracked output 1") && html.contains("reference"));
}

#[test]
fn acknowledgements_are_the_designs_or_the_command_lines() {
    let cost = |design: &PathBuf, arguments: &[&str]| -> f64 {
        let mut command =
            host_sim(&["run", "--runs", "20", "--steps", "40", "--json", "--controllers", "slqg"]);
        let text = stdout({
            command.arg(design).args(arguments);
            command
        });
        let json: Value = serde_json::from_str(&text).expect("one JSON object");
        json["results"][0]["mean_cost"].as_f64().expect("a number")
    };
    let instant = design("double_integrator.toml");
    let folder = tempfile::tempdir().expect("a folder");
    let radio = folder.path().join("radio.toml");
    let text = fs::read_to_string(&instant).expect("the design");
    let without = text.replace("acknowledgement = \"instant\"", "acknowledgement = \"none\"");
    assert_ne!(without, text);
    fs::write(&radio, without).expect("written");
    let none = cost(&radio, &[]);
    assert_eq!(cost(&instant, &["--acknowledgement", "none"]), none);
    assert_eq!(cost(&radio, &["--acknowledgement", "instant"]), cost(&instant, &[]));
    assert_eq!(cost(&instant, &["--acknowledgement", "1"]), cost(&instant, &[]), "always in time");
    assert!(cost(&instant, &[]) < cost(&instant, &["--acknowledgement", "0.5,0.2"]));
    assert!(cost(&radio, &["--estimator", "gpb2"]) != none);
    let mut wrong = run("double_integrator.toml", &["--acknowledgement", "sometimes"]);
    let assertion = wrong.assert().code(2);
    let stderr = String::from_utf8_lossy(&assertion.get_output().stderr).into_owned();
    assert!(stderr.contains("give instant, none, or probabilities"), "{stderr}");
}

#[test]
fn a_controller_without_acknowledgements_can_be_named() {
    let text =
        stdout(run("double_integrator.toml", &["--json", "--controllers", "slqg-udp,slqg-udp-rounded"]));
    let json: Value = serde_json::from_str(&text).expect("one JSON object");
    let costs: Vec<_> =
        json["results"].as_array().expect("results").iter().map(|row| row["mean_cost"].as_f64()).collect();
    assert!(costs[0].is_some() && costs[1].is_some() && costs[0] != costs[1], "{costs:?}");
}

#[test]
fn the_report_is_one_file_with_pictures_in_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("report.html");
    fs::write(&path, "an older report").expect("written");
    let mut command = run("pendulum.toml", &["--report"]);
    stdout({
        command.arg(&path);
        command
    });
    let html = fs::read_to_string(&path).expect("the report");
    assert!(html.starts_with("<!doctype html>") && html.ends_with("</html>\n"));
    assert!(html.matches("<svg").count() >= 6, "distribution, four states, one input");
    assert!(!html.contains("src=") && !html.contains("href="), "nothing is loaded from elsewhere");
}

#[test]
fn a_failed_run_leaves_an_existing_report_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("report.html");
    fs::write(&path, "an older report").expect("written");
    run("critical.toml", &["--sequence-length", "1", "--report"]).arg(&path).assert().code(3);
    assert_eq!(fs::read_to_string(&path).expect("the report"), "an older report");
}

#[test]
fn a_design_on_its_own_network_costs_in_the_robustness_table_what_a_run_says() {
    let amount = ["--runs", "20", "--steps", "40", "--json"];
    let mut table = host_sim(&["robustness"]);
    table.args([design("double_integrator.toml"), design("double_integrator_bad.toml")]).args(amount);
    let table: Value = serde_json::from_str(&stdout(table)).expect("one JSON object");
    let cells = table["results"].as_array().expect("cells");
    assert_eq!(cells.len(), 4);
    for (cell, name) in [(&cells[0], "double_integrator"), (&cells[3], "double_integrator_bad")] {
        let alone = stdout(run(&format!("{name}.toml"), &["--json", "--controllers", "slqg"]));
        let alone: Value = serde_json::from_str(&alone).expect("one JSON object");
        assert_eq!((&cell["designed_for"], &cell["run_on"]), (&name.into(), &name.into()));
        assert_eq!(cell["mean_cost"], alone["results"][0]["mean_cost"]);
    }
    assert!(cells[1]["mean_cost"].as_f64() > cells[0]["mean_cost"].as_f64(), "{cells:?}");
}

#[test]
fn designs_of_different_plants_have_no_robustness_table() {
    let mut table = host_sim(&["robustness"]);
    table.args([design("pendulum.toml"), design("critical.toml")]);
    let output = table.assert().code(2).get_output().clone();
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(message.contains("critical: its [plant] differs from that of pendulum"), "{message}");
}

#[test]
fn a_controller_that_knows_the_channel_needs_one() {
    let output =
        run("pendulum.toml", &["--controllers", "slqg-channel"]).assert().code(2).get_output().clone();
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(
        message.contains("needs a link controller_to_actuator given as gilbert_elliott or markov"),
        "{message}"
    );
    let known = stdout(run("double_integrator_bursty.toml", &["--controllers", "slqg-channel", "--json"]));
    let known: Value = serde_json::from_str(&known).expect("one JSON object");
    assert_eq!(known["results"][0]["controller"], "slqg-channel");
}

#[test]
fn a_recorded_link_is_replayed_and_duplicates_change_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = fs::read_to_string(design("double_integrator_bad.toml")).expect("a design");
    let (start, end) =
        (text.find("controller_to_actuator.delays").expect("a link"), text.find("sensor_to").expect("one"));
    let with = |name: &str, link: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text[..start].to_string() + link + "\n" + &text[end..]).expect("written");
        let mut command = host_sim(&["run"]);
        command.arg(path).args(["--runs", "20", "--steps", "40", "--json", "--controllers", "slqg"]);
        let json: Value = serde_json::from_str(&stdout(command)).expect("one JSON object");
        json["results"][0].clone()
    };
    // Two cycles of 1 s late, always: a log says it as well as a distribution does.
    let log: String = (0..30).map(|k| format!("{k},{k}.0,{}.0\n", k + 2)).collect();
    fs::write(folder.path().join("log.csv"), "sequence,sent,received\n".to_string() + &log).expect("written");
    let late = with("late.toml", "controller_to_actuator.delays = [0, 0, 1]");
    assert_eq!(with("log.toml", "controller_to_actuator.trace = \"log.csv\""), late);
    // A copy of a packet tells the actuator nothing new.
    let twice = "controller_to_actuator = { delays = [0, 0, 1], duplicates = 0.5 }";
    assert_eq!(with("twice.toml", twice), late);
}

#[test]
fn a_controller_told_its_own_channel_is_not_put_on_another_network() {
    let mut table = host_sim(&["robustness", "--controller", "slqg-channel"]);
    table.args([design("double_integrator_bursty.toml"), design("double_integrator.toml")]);
    let output = table.assert().code(2).get_output().clone();
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(
        message.contains("told the states of its own channel") && message.contains("give --controller slqg"),
        "{message}"
    );
}

#[test]
fn losses_per_hour_foretell_how_many_of_longer_runs_are_lost() {
    let folder = tempfile::tempdir().expect("a folder for files");
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../gain-gen/tests/data/oscillator.toml");
    let design = fs::read_to_string(path).expect("an unstable plant under limits");
    // Begun at rest, not where the start alone may lose it.
    let design =
        design.replace("initial_mean = [2,0]", "initial_mean = [0,0]").replace("0.2,0.2]]", "0.22,0.22]]");
    let path = folder.path().join("oscillator.toml");
    fs::write(&path, design).expect("a folder for files");
    let result = |steps: &str, seed: &str| {
        let mut command = host_sim(&["run", "--controllers", "slqg", "--runs", "400", "--json"]);
        command.arg(&path).args(["--steps", steps, "--seed", seed]);
        let json: Value = serde_json::from_str(&stdout(command)).expect("one JSON object");
        json["results"][0].clone()
    };
    let (short, long) = (result("1000", "1"), result("3000", "2"));
    let number = |of: &Value| of.as_f64().expect("a number");
    let (lost, rate) = (number(&short["losses"]["lost"]), number(&short["losses"]["per_hour"]));
    assert!(lost > 20.0, "{short}");
    let time = 3000.0 * 0.05 / 3600.0;
    let kept = (-rate * time).exp();
    let found = number(&long["losses"]["lost"]) / 400.0;
    let error = (kept * (1.0 - kept) / 400.0 + (kept * rate * time).powi(2) / lost).sqrt();
    assert!((found - (1.0 - kept)).abs() < 4.0 * error, "{found} {kept} {error}");
    // Those lost near the end have not gone far yet; of all others the plain run shows that they never come back.
    let diverged = number(&long["diverged"]) / 400.0;
    assert!(diverged <= found && found - diverged < 0.05, "{found} {diverged}");
}

#[test]
fn a_linear_estimator_that_does_not_go_with_the_acknowledgements_is_refused() {
    let refused = run("double_integrator.toml", &["--estimator", "linear"]).output().expect("it runs");
    let told = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{told}");
    assert!(
        told.contains("controller.estimator: found \"linear\" beside acknowledgements; it takes no"),
        "{told}"
    );
    let none = ["--estimator", "linear", "--acknowledgement", "none"];
    assert_eq!(run("double_integrator.toml", &none).output().expect("it runs").status.code(), Some(0));
}
