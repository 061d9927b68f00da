//! A solution that would take gigabytes or hours is told of before it is begun, and not begun unasked.

use gain_gen::design::Design;
use gain_gen::effort::Effort;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// A chain of integrators that leak, with sequences of `length` inputs over a link of `delays` delays.
fn design(states: usize, inputs: usize, length: usize, delays: usize) -> String {
    let matrix = |rows: usize, columns: usize, entry: &dyn Fn(usize, usize) -> f64| {
        let row = |row| {
            (0..columns).map(|column| format!("{:?}", entry(row, column))).collect::<Vec<_>>().join(", ")
        };
        format!("[{}]", (0..rows).map(|at| format!("[{}]", row(at))).collect::<Vec<_>>().join(", "))
    };
    let scaled = |by: f64| move |row: usize, column: usize| if row == column { by } else { 0.0 };
    let a = matrix(states, states, &|row, column| match column {
        _ if row == column => {
            if row == 0 {
                1.05
            } else {
                0.9
            }
        }
        _ if column == row + 1 => 0.2,
        _ => 0.0,
    });
    let b = matrix(states, inputs, &|row, column| match row {
        _ if row == states - 1 - column => 1.0,
        0 => 0.5,
        _ => 0.0,
    });
    let outputs = states.div_ceil(2);
    let c = matrix(outputs, states, &scaled(1.0));
    let (noise, of_sensors, weight, of_inputs) = (
        matrix(states, states, &scaled(0.01)),
        matrix(outputs, outputs, &scaled(0.01)),
        matrix(states, states, &scaled(1.0)),
        matrix(inputs, inputs, &scaled(1.0)),
    );
    let mean = vec!["0"; states].join(", ");
    let shares: Vec<f64> = (0..delays).map(|delay| 0.99_f64.powi(delay as i32)).collect();
    let sum: f64 = shares.iter().sum();
    let shares: Vec<_> = shares.iter().map(|share| format!("{:?}", 0.95 * share / sum)).collect();
    format!(
        "name = 'chain'
[plant]
sample_time = 0.01
discrete = {{ a = {a}, b = {b} }}
c = {c}
process_noise = {noise}
measurement_noise = {of_sensors}
initial_mean = [{mean}]
initial_covariance = {noise}
[cost]
q = {weight}
r = {of_inputs}
[network]
controller_to_actuator.delays = [{}]
sensor_to_controller.delays = [0.9]
[controller]
sequence_length = {length}
",
        shares.join(", ")
    )
}

fn written(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("chain.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn gain_gen(arguments: &[&str], design: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gain-gen"));
    command.arg(arguments[0]).arg(design).args(&arguments[1..]);
    command
}

#[test]
fn what_would_take_gigabytes_is_refused_with_what_it_takes_and_a_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), &design(16, 4, 128, 1000));
    let file = folder.path().join("gains.rs");
    let output = ["emit", "--to", "rust", "--output", file.to_str().unwrap()];
    for arguments in [&["report"][..], &["report", "--json"], &["sweep", "--lengths", "120..=128"], &output] {
        let output = gain_gen(arguments, &path).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{said}");
        assert!(said.contains("solving takes about 3.2 GB of memory and "), "{said}");
        assert!(said.contains("give shorter sequences, or --accept-effort"), "{said}");
    }
}

#[test]
fn an_accepted_effort_is_begun_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), &design(16, 4, 128, 20));
    let mut command = gain_gen(&["report", "--accept-effort"], &path);
    let mut running = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(running.stderr.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.starts_with("note: solving takes about 3.2 GB of memory and "), "{line}");
    assert!(running.try_wait().unwrap().is_none(), "it goes on");
    running.kill().unwrap();
    running.wait().unwrap();
}

#[test]
fn what_takes_little_is_solved_without_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), &design(4, 1, 16, 20));
    let output = gain_gen(&["report"], &path).output().unwrap();
    assert_eq!((output.status.code(), String::from_utf8(output.stderr).unwrap().as_str()), (Some(0), ""));
}

/// Most memory that the process has had, while it runs.
#[cfg(target_os = "linux")]
fn peak(running: &mut Child) -> f64 {
    let status = format!("/proc/{}/status", running.id());
    let mut most = 0.0;
    while running.try_wait().unwrap().is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let found = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<f64>().ok());
        most = found.map_or(most, |kilobytes| 1024.0 * kilobytes).max(most);
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    most
}

#[test]
#[cfg(target_os = "linux")]
fn the_memory_that_is_told_is_right_within_a_factor_of_three() {
    let folder = tempfile::tempdir().unwrap();
    for (states, inputs, length) in [(4, 1, 64), (4, 2, 64), (16, 1, 48), (8, 4, 32), (2, 1, 100)] {
        let text = design(states, inputs, length, 20);
        let told = Effort::of(&Design::parse(&text, "chain.toml").unwrap(), &[length]).bytes;
        let mut command = gain_gen(&["report"], &written(folder.path(), &text));
        let found = peak(&mut command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
        assert!(
            (1.0 / 3.0..3.0).contains(&(told / found)),
            "{states} {inputs} {length}: told {told:.2e}, {found:.2e}"
        );
    }
}
