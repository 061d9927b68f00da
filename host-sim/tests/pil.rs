//! `host-sim pil` without boards: what it refuses beforehand, and what is left of a run whose emulator fails.

use assert_cmd::Command;
use std::{
    fs::{self, Permissions},
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

fn design(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../designs").join(name)
}

/// A run of 100 cycles with images that nobody reads.
fn pil(name: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.arg("pil").arg(design(name)).args(["--cycles", "100"]);
    command.args(["--controller-image", "none", "--actuator-image", "none"]).args(arguments);
    command
}

/// What it says as it ends with this status, without an answer.
fn failure(mut command: Command, status: i32) -> String {
    let output = command.assert().code(status).get_output().clone();
    assert!(output.stdout.is_empty());
    String::from_utf8(output.stderr).expect("UTF-8")
}

/// The same with no emulator to be found: what is refused then was refused before one was looked for.
fn refusal(arguments: &[&str]) -> String {
    let mut command = pil("double_integrator.toml", arguments);
    command.env("PATH", "/nowhere:/neither/here");
    failure(command, 2)
}

#[test]
fn a_missing_emulator_is_told_with_where_it_was_looked_for_and_what_to_install() {
    let message = refusal(&[]);
    for part in ["qemu-system-arm", "/nowhere:/neither/here", "apt-get install"] {
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn restarts_that_cannot_be_are_refused_before_anything_is_started() {
    let message = refusal(&["--restart", "actuator@5", "--restart", "controller@95"]);
    assert!(message.contains("--restart controller@95+10") && message.contains("0 to 89"), "{message}");
    let message = refusal(&["--restart", "actuator@14", "--restart", "actuator@5"]);
    assert!(message.contains("--restart actuator@14+10") && message.contains("in cycle 15"), "{message}");
    let message = refusal(&["--restarts", "51"]);
    assert!(message.contains("found 51") && message.contains("up to 50"), "{message}");
}

#[test]
fn a_link_that_changes_after_the_run_and_a_controller_that_never_solves_are_refused() {
    let other = design("double_integrator_bad.toml").display().to_string();
    let message = refusal(&["--changes-to", &other, "--at", "100"]);
    assert!(message.contains("--at: found 100") && message.contains("--cycles makes it longer"), "{message}");
    let message = refusal(&["--tuning", "--slices", "0"]);
    assert!(message.contains("'0' for '--slices"), "{message}");
}

#[test]
fn gains_of_a_plant_of_other_dimensions_are_refused_with_those_of_both() {
    let of = |name: &str, at: &str| {
        let other = design(name).display().to_string();
        refusal(&["--gains-of", &other, "--gains-at", at])
    };
    let message = of("pendulum.toml", "5");
    assert!(message.contains("the plant has 4 states, 1 inputs and 2 outputs"), "{message}");
    assert!(message.contains("2 states, 1 inputs and 1 outputs"), "{message}");
    // Those of the same plant would be sent.
    assert!(of("double_integrator_bad.toml", "5").contains("qemu-system-arm is in no folder"));
    let message = of("double_integrator_bad.toml", "99");
    assert!(message.contains("--gains-at: found 99") && message.contains("give 0 to"), "{message}");
}

/// A folder with an emulator that ends at once, and what it says.
fn failing_emulator(folder: &Path) {
    let program = folder.join("qemu-system-arm");
    fs::write(&program, "#!/bin/sh\necho 'no such machine' >&2\nexit 1\n").expect("written");
    fs::set_permissions(&program, Permissions::from_mode(0o755)).expect("executable");
}

/// Names of what is in a folder, in order.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let name = |entry: fs::DirEntry| entry.file_name().into_string().expect("UTF-8");
    let mut names: Vec<_> = entries.map(|entry| name(entry.expect("an entry"))).collect();
    names.sort();
    names
}

#[test]
fn the_log_that_a_failed_run_names_is_there_and_nothing_else_is_left() {
    let [programs, temporary] = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    failing_emulator(programs.path());
    // Nothing that QEMU could take for the end of an option, or the node for the end of a word.
    let temporary = temporary.path().join("of a, b=c");
    fs::create_dir(&temporary).expect("a folder");
    for transport in ["uart", "bulk"] {
        let mut command = pil("double_integrator.toml", &["--transport", transport]);
        command.env("PATH", programs.path()).env("TMPDIR", &temporary);
        let message = failure(command, 1);
        assert!(message.contains("no such machine"), "{message}");
        let (_, log) = message.trim_end().split_once("its log: ").expect("a log");
        assert!(Path::new(log).is_file(), "{log}");
        let left = names(&temporary);
        assert_eq!(left.len(), 1, "{left:?}");
        let kept = temporary.join(&left[0]);
        assert_eq!(names(&kept), ["actuator.log", "controller.log"]);
        fs::remove_dir_all(kept).expect("removed");
    }
}

#[test]
fn logs_go_to_the_folder_that_was_asked_for_and_lines_do_not() {
    let [programs, temporary, asked] = [(); 3].map(|()| tempfile::tempdir().expect("a folder"));
    failing_emulator(programs.path());
    let logs = asked.path().join("of this, run");
    let mut command = pil("double_integrator.toml", &["--logs"]);
    command.arg(&logs).env("PATH", programs.path()).env("TMPDIR", temporary.path());
    let message = failure(command, 1);
    assert!(message.contains(&logs.join("controller.log").display().to_string()), "{message}");
    assert_eq!(names(&logs), ["actuator.log", "controller.log"]);
    assert_eq!(names(temporary.path()), [""; 0]);
}
