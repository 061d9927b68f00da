//! A log that is given twice tells nothing that it does not tell once.

use slqg_links::identify::logs::{Selection, traces};
use std::path::PathBuf;

fn table(first: usize) -> Vec<u8> {
    let rows = (first..first + 50).map(|i| format!("{i},{},{}\n", i as f64 * 0.01, i as f64 * 0.01 + 0.004));
    format!("sequence,sent,received\n{}", rows.collect::<String>()).into_bytes()
}

#[test]
fn a_log_given_twice_is_refused_whatever_its_name() {
    let logs = [(PathBuf::from("run.csv"), table(0)), (PathBuf::from("copy.csv"), table(0))];
    let problem = traces(&logs, &Selection::default()).expect_err("the same").to_string();
    assert!(problem.contains("copy.csv: begins as run.csv does, so it is the same log"), "{problem}");
}

#[test]
fn two_runs_are_read() {
    let logs = [(PathBuf::from("run.csv"), table(0)), (PathBuf::from("later.csv"), table(50))];
    assert_eq!(traces(&logs, &Selection::default()).expect("two runs").len(), 2);
}
