//! Links whose every packet is known, their logs, and what `host-sim identify` says of them.
#![allow(dead_code, reason = "each test uses its part")]

use assert_cmd::Command;
use gain_gen::design::{DelayDistribution, Design};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};
use tempfile::TempDir;

pub(crate) fn design(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name)
}

pub(crate) fn network(name: &str) -> DelayDistribution {
    Design::load(&design(name)).expect("a design").network.controller_to_actuator.delays
}

pub(crate) fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

pub(crate) fn written(folder: &TempDir, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, content).expect("written");
    path
}

pub(crate) fn identify(files: &[&Path], arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.arg("identify").args(files).args(["--sample-time", "0.01"]).args(arguments);
    command
}

pub(crate) fn stdout(files: &[&Path], arguments: &[&str]) -> String {
    let mut command = identify(files, arguments);
    String::from_utf8(command.assert().success().get_output().stdout.clone()).expect("UTF-8")
}

pub(crate) fn json(files: &[&Path], arguments: &[&str]) -> Value {
    serde_json::from_str(&stdout(files, &[arguments, &["--json"]].concat())).expect("one JSON object")
}

/// Fails with status 2 and says `expected`.
pub(crate) fn refused(files: &[&Path], arguments: &[&str], expected: &[&str]) {
    let mut command = identify(files, arguments);
    let message = String::from_utf8(command.assert().code(2).get_output().stderr.clone()).expect("UTF-8");
    for part in expected {
        assert!(message.contains(part), "{part} in {message}");
    }
}

/// A fate per packet: the delay in cycles or lost.
pub(crate) fn drawn(
    distribution: &DelayDistribution,
    packets: usize,
    random: &mut ChaCha8Rng,
) -> Vec<Option<usize>> {
    let draw = |_| {
        let mut left: f64 = random.random();
        distribution.probabilities().iter().position(|probability| {
            left -= probability;
            left < 0.0
        })
    };
    (0..packets).map(draw).collect()
}

/// Nanoseconds of sending and arrival: a packet per cycle of 10 ms, anywhere in the cycle it arrives in.
pub(crate) fn times(fates: &[Option<usize>], random: &mut ChaCha8Rng) -> Vec<(u64, Option<u64>)> {
    let cycle = 10_000_000;
    let mut time = |(index, fate): (usize, &Option<usize>)| {
        let sent = 1_000_000_000 + index as u64 * cycle;
        (sent, fate.map(|delay| sent + delay as u64 * cycle + random.random_range(0..cycle)))
    };
    fates.iter().enumerate().map(&mut time).collect()
}

pub(crate) fn decimal(time: u64) -> String {
    format!("{}.{:09}", time / 1_000_000_000, time % 1_000_000_000)
}

pub(crate) fn csv(times: &[(u64, Option<u64>)]) -> String {
    let mut text = String::from("sequence,sent,received\n");
    for (sequence, (sent, received)) in times.iter().enumerate() {
        let received = received.map(decimal).unwrap_or_default();
        writeln!(text, "{sequence},{},{received}", decimal(*sent)).expect("a string");
    }
    text
}

pub(crate) fn trace(fates: &[Option<usize>], random: &mut ChaCha8Rng) -> String {
    csv(&times(fates, random))
}

pub(crate) fn warns(json: &Value, of: &str) -> bool {
    json["warnings"]
        .as_array()
        .expect("a list")
        .iter()
        .any(|warning| warning.as_str().is_some_and(|text| text.contains(of)))
}
