//! Standard output that is full or has no reader: an error with status 2, or a quiet end; never a panic.
#![cfg(target_os = "linux")]

use std::fs::OpenOptions;
use std::io::pipe;
use std::process::{Command, Stdio};

const SUBCOMMANDS: &[&str] = &["report", "emit", "sweep"];

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gain-gen"));
    command.args(arguments);
    command
}

/// Status and what was said on standard error.
fn ended(arguments: &[&str], stdout: impl Into<Stdio>) -> (Option<i32>, String) {
    let output = command(arguments).stdout(stdout).stderr(Stdio::piped()).output().expect("it starts");
    (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
}

fn full() -> Stdio {
    OpenOptions::new().write(true).open("/dev/full").expect("Linux has it").into()
}

/// A pipe whose reader has gone.
fn closed() -> Stdio {
    let (reader, writer) = pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

fn is_told(arguments: &[&str]) {
    let (status, said) = ended(arguments, full());
    assert_eq!(status, Some(2), "{arguments:?}: {said}");
    assert!(said.contains("cannot be written: No space left on device"), "{arguments:?}: {said}");
    let (status, said) = ended(arguments, closed());
    assert_eq!(status, Some(0), "{arguments:?}: {said}");
    assert!(!said.contains("error") && !said.contains("panicked"), "{arguments:?}: {said}");
}

#[test]
fn every_answer_that_cannot_be_written_is_an_error_and_a_reader_that_has_gone_is_none() {
    let design = concat!(env!("CARGO_MANIFEST_DIR"), "/../designs/pendulum.toml");
    let answers = [
        vec!["report", design],
        vec!["report", design, "--json"],
        vec!["sweep", design, "--lengths", "3..=4"],
        vec!["sweep", design, "--lengths", "3..=4", "--json"],
        vec!["emit", design, "--to", "rust", "--output", "/dev/stdout"],
    ];
    answers.iter().for_each(|arguments| is_told(arguments));
}

#[test]
fn help_and_version_that_cannot_be_written_are_an_error() {
    is_told(&["--help"]);
    is_told(&["--version"]);
    SUBCOMMANDS.iter().for_each(|subcommand| is_told(&[subcommand, "--help"]));
}

#[test]
fn an_error_that_nobody_can_hear_still_has_its_status() {
    for arguments in [&["no-such-command"][..], &[SUBCOMMANDS[0], "/no/such/file"]] {
        let status = command(arguments).stdout(full()).stderr(full()).status().expect("it starts");
        assert_eq!(status.code(), Some(2), "{arguments:?}");
    }
}
