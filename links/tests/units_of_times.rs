//! In which unit the times of a table are, where no name tells.

use slqg_links::identify::logs::{Selection, traces};
use std::path::PathBuf;

/// A table whose packets are sent `step` apart and take `delay`, read for cycles of 20 ms.
fn read(step: f64, delay: f64) -> Result<(usize, Vec<String>), String> {
    let rows = (0..200).map(|i| format!("{i},{},{}\n", f64::from(i) * step, f64::from(i) * step + delay));
    let table = format!("sequence,sent,received\n{}", rows.collect::<String>()).into_bytes();
    let selection = Selection { sample_time: Some(0.02), ..Selection::default() };
    let traces =
        traces(&[(PathBuf::from("log.csv"), table)], &selection).map_err(|problem| problem.to_string())?;
    Ok((traces[0].packets().count(), traces[0].about.notes.clone()))
}

#[test]
fn packets_once_in_a_cycle_tell_it() {
    assert!(read(0.02, 0.005).expect("seconds").1.is_empty());
    assert!(read(20.0, 5.0).expect("milliseconds").1.concat().contains("milliseconds"));
}

#[test]
fn probes_slower_than_the_cycle_are_in_seconds_and_that_is_told() {
    let (packets, notes) = read(1.0, 0.004).expect("seconds");
    assert_eq!(packets, 200);
    assert!(notes.concat().contains("in seconds; then packets come once in 50.0 cycles"), "{notes:?}");
}

#[test]
fn what_makes_no_sense_in_any_unit_is_refused() {
    let problem = read(500.0, 4.0).expect_err("no unit");
    assert!(problem.contains("say the unit of the times with --unit"), "{problem}");
}
