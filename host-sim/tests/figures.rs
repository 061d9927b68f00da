//! `host-sim figures` recomputes the thesis' figures.

use assert_cmd::Command;
use std::fs;

fn figures(arguments: &[&str]) -> (String, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.arg("figures").arg("--output").arg(folder.path()).args(arguments);
    let output = command.assert().success().get_output().stdout.clone();
    (String::from_utf8(output).expect("UTF-8"), folder)
}

#[test]
fn costs_of_too_short_sequences_grow_exponentially_and_those_of_longer_ones_settle() {
    let (printed, folder) = figures(&["--only", "3.10", "--runs", "4000"]);
    let written = fs::read_to_string(folder.path().join("figure-3.10.txt")).expect("a table");
    assert_eq!(written.trim_end(), printed.trim_end());
    let row = |step: &str| -> Vec<f64> {
        let line = printed.lines().find(|line| line.split_whitespace().next() == Some(step)).expect("a row");
        line.split_whitespace().skip(1).map(|figure| figure.parse().expect("a number")).collect()
    };
    let (early, middle, late) = (row("10"), row("20"), row("30"));
    for length in 0..2 {
        assert!(middle[length] > 3.0 * early[length], "N = {}: {early:?} {middle:?}", length + 1);
    }
    for length in 2..4 {
        assert!(late[length] < early[length], "N = {}: {early:?} {late:?}", length + 1);
    }
}

#[test]
fn a_figure_that_is_not_there_is_answered_with_those_that_are() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.args(["figures", "--output", "nowhere", "--only", "9.9"]);
    let output = command.assert().code(2).get_output().clone();
    let message = String::from_utf8(output.stderr).expect("UTF-8");
    assert!(
        message.contains("there is no figure `9.9` here; there are: 3.9, 3.10, 3.11, 4.5, 5.3"),
        "{message}"
    );
}
