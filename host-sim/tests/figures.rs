//! `host-sim figures` recomputes the thesis' figures.

use assert_cmd::Command;
use host_sim::figures::single_run;
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
        message.contains("there is no figure `9.9` here; there are: 3.9, 3.10, 3.11, 4.4, 4.5, 5.3"),
        "{message}"
    );
}

#[test]
fn with_preview_the_cart_turns_before_the_reference_does_and_without_it_after() {
    let all = single_run::simulate(1);
    for runs in &all {
        let [with, without] = runs.reactions();
        let change = single_run::CHANGE as f64 * runs.sample_time;
        assert!(with.turn < change - 1.0, "{}: {with:?}", runs.design);
        assert!(without.turn > change, "{}: {without:?}", runs.design);
        assert!(with.position < without.position - 30.0, "{}: {with:?} {without:?}", runs.design);
        assert!(with.angle < without.angle && with.input < without.input, "{with:?} {without:?}");
        // Nothing is to be seen ahead at first.
        assert!(runs.apart(50) < 0.02 * 50.0, "{}: {}", runs.design, runs.apart(50));
    }
    let [with, without] = all[0].reactions();
    assert!(with.rate < 0.2 * without.rate, "{with:?} {without:?}");
}

#[test]
fn a_single_run_is_a_table_a_file_of_every_cycle_and_a_picture_for_each_network() {
    let (printed, folder) = figures(&["--only", "4.4"]);
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a file");
    assert_eq!(read("figure-4.4.txt").trim_end(), printed.trim_end());
    for design in ["pendulum_tracking", "pendulum_tracking_bad"] {
        let csv = read(&format!("figure-4.4-{design}.csv"));
        let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(rows.len(), 1 + single_run::STEPS);
        assert_eq!(rows[0][..3], ["time", "reference", "slqg_position"]);
        assert!(rows.iter().all(|row| row.len() == 12));
        let cell = |row: usize, column: usize| rows[row][column].parse::<f64>().expect("a number");
        for (cycle, reference) in [(0, 50.0), (249, 50.0), (250, -50.0)] {
            assert_eq!((cell(1 + cycle, 0), cell(1 + cycle, 1)), (cycle as f64 / 50.0, reference));
        }
        let svg = read(&format!("figure-4.4-{design}.svg"));
        for part in ["slqg-no-preview", "reference", "position s (m)", "input u (N)", "time in s"] {
            assert!(svg.contains(part), "{part}");
        }
        assert!(!svg.contains("NaN"));
    }
}
