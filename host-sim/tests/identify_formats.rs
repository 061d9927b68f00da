//! `host-sim identify` reads logs as the tools write them, or refuses them by name. `tests/logs` holds logs of known links, packed with gzip,
//! and beside them what became of every packet.

mod links;

use assert_cmd::Command;
use flate2::{Compression, write::GzEncoder};
use links::{folder, written};
use serde_json::Value;
use std::{fs, io::Write, path::PathBuf};

fn logs() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/logs")
}

/// The logs with what is known of them.
fn cases() -> Vec<(String, Value)> {
    let text = fs::read_to_string(logs().join("expected.json")).expect("expected.json");
    let cases: serde_json::Map<String, Value> = serde_json::from_str(&text).expect("JSON");
    cases.into_iter().collect()
}

fn words(list: &Value) -> Vec<String> {
    list.as_array().expect("a list").iter().map(|word| word.as_str().expect("a word").to_string()).collect()
}

fn identify(case: &Value, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command
        .current_dir(logs())
        .arg("identify")
        .args(words(&case["files"]))
        .args(words(&case["options"]))
        .args(more);
    command
}

fn json(case: &Value, more: &[&str]) -> Value {
    let output = identify(case, &[more, &["--json"]].concat()).assert().success().get_output().stdout.clone();
    serde_json::from_slice(&output).expect("JSON")
}

#[test]
fn what_became_of_every_packet_is_read_from_the_logs_of_every_tool() {
    for (name, case) in cases().iter().filter(|(_, case)| case.get("packets").is_some()) {
        let found = json(case, &[]);
        assert_eq!(
            (&found["packets"], &found["loss"]["packets"]),
            (&case["packets"], &case["lost"]),
            "{name}: {found}"
        );
        let shares = |list: &Value, key: Option<&str>| -> Vec<f64> {
            let shares = list.as_array().expect("a list").iter();
            shares.map(|share| key.map_or(share, |key| &share[key]).as_f64().expect("a number")).collect()
        };
        let (read, known) =
            (shares(&found["delays"], Some("probability")), shares(&case["probabilities"], None));
        let is_same = |(read, known): (&f64, &f64)| (read - known).abs() < 1e-9;
        assert!(
            read.len() == known.len() && read.iter().zip(&known).all(is_same),
            "{name}: {read:?}, not {known:?}"
        );
        let bursts =
            found["independence_of_losses"]["p_value"].as_f64().is_some_and(|p_value| p_value < 0.01);
        assert_eq!(bursts, case["bursts"], "{name}");
        if let Some(overtaken) = case.get("overtaken") {
            assert_eq!(&found["log"]["reordered"], overtaken, "{name}");
        }
    }
}

#[test]
fn what_cannot_be_read_is_refused_with_the_reason_and_what_to_do() {
    for (name, case) in cases().iter().filter(|(_, case)| case.get("refuses").is_some()) {
        let output = identify(case, &[]).assert().code(2).get_output().clone();
        let said = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(said.contains(case["refuses"].as_str().expect("words")), "{name}: {said}");
        assert!(output.stdout.is_empty(), "{name}");
    }
}

#[test]
fn what_a_logger_dropped_is_warned_of() {
    for (name, case) in cases().iter().filter(|(_, case)| case.get("warns").is_some()) {
        let found = json(case, &[]);
        let warning = case["warns"].as_str().expect("a word");
        assert!(
            found["warnings"].to_string().contains(warning) && found["log"]["dropped"] == 38,
            "{name}: {found}"
        );
    }
}

#[test]
fn what_is_no_packet_is_counted_by_kind() {
    let cases = cases();
    let found = |name: &str| {
        let (_, case) = cases.iter().find(|(other, _)| other == name).expect(name);
        json(case, &[])["log"]["skipped"].clone()
    };
    assert!(found("candump-errors-counter")["error_frames"].as_u64() > Some(0));
    assert!(found("candump-remote")["remote_frames"].as_u64() > Some(0));
    assert!(found("candump-std-and-ext")["other_identifiers"].as_u64() > Some(0));
    assert_eq!(found("candump-cut")["cut_off"], 1);
}

#[test]
fn half_a_round_trip_is_a_delay_only_where_it_is_asked_for() {
    for (name, packets, lost) in [("ping", 400, 30), ("fping", 200, 23)] {
        let (_, case) = cases().into_iter().find(|(other, _)| other == name).expect(name);
        let found = json(&case, &["--half-round-trip"]);
        assert_eq!(
            (&found["packets"], &found["loss"]["packets"]),
            (&packets.into(), &lost.into()),
            "{name}: {found}"
        );
        assert!(found["notes"].to_string().contains("half of each round trip"), "{name}");
    }
}

#[test]
fn a_counter_that_is_given_says_the_same_as_the_one_that_is_found() {
    let cases = cases();
    for (name, counter, id) in [("candump-counter16", "u16le@0", "123"), ("compact-bursts", "u16le@0", "701")]
    {
        let (_, case) = cases.iter().find(|(other, _)| other == name).expect(name);
        let found = json(case, &[]);
        assert_eq!(found["number"], format!("counter {counter} of identifier {id}"));
        assert_eq!(json(case, &["--counter", counter]), found);
        // The values behind it are none.
        let said = identify(case, &["--counter", "u8@5"]).assert().code(2).get_output().stderr.clone();
        assert!(String::from_utf8(said).expect("UTF-8").contains("--counter"), "{name}");
    }
}

#[test]
fn a_log_may_be_packed() {
    let folder = folder();
    let table = "sequence,sent,received\n1,0.01,0.012\n2,0.02,0.034\n";
    let plain = links::json(&[&written(&folder, "t", table)], &[]);
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(table.as_bytes()).expect("packed");
    assert_eq!(links::json(&[&written(&folder, "t", packed.finish().expect("packed"))], &[]), plain);
}
