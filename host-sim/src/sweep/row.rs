//! One run as a row of the file, and what is kept of it in memory.

use super::experiment::{CHECKSUM, Case, Experiment};
use crate::closed_loop::RunResult;
use serde::{Deserialize, Serialize};

/// What one run came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// The run.
    pub result: RunResult,
    /// Its cost with what its packets cost; `None` where the design does not price them.
    pub total_cost: Option<f64>,
}

/// A row; its fields are the columns, in this order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Row<'a> {
    design: &'a str,
    controller: &'a str,
    sequence_length: usize,
    run: u64,
    cost: f64,
    total_cost: Option<f64>,
    /// 0 or 1, which every tool reads as a number.
    diverged: u8,
    sent: usize,
    age_sum: usize,
    rejected: u64,
    /// CRC-32/ISCSI of the experiment and of the row with 0 here: a figure that was changed is noticed.
    check: u32,
}

impl<'a> Row<'a> {
    /// Heads of the columns.
    pub(super) const COLUMNS: [&'static str; 11] = [
        "design",
        "controller",
        "sequence_length",
        "run",
        "cost",
        "total_cost",
        "diverged",
        "sent",
        "age_sum",
        "rejected",
        "check",
    ];

    /// Run number `run` of `case` of the experiment with this fingerprint.
    pub(super) fn new(fingerprint: u32, case: &'a Case, run: u64, entry: &Entry) -> Self {
        let RunResult { cost, diverged, sent, age_sum, rejected, .. } = entry.result;
        let row = Self {
            design: &case.design,
            controller: case.controller.name(),
            sequence_length: case.sequence_length,
            run,
            cost,
            total_cost: entry.total_cost,
            diverged: diverged.into(),
            sent,
            age_sum,
            rejected,
            check: 0,
        };
        Self { check: row.expected_check(fingerprint), ..row }
    }

    fn expected_check(&self, fingerprint: u32) -> u32 {
        let mut digest = CHECKSUM.digest();
        digest.update(&fingerprint.to_le_bytes());
        digest.update(&bytes([Row { check: 0, ..*self }]));
        digest.finalize()
    }

    /// Whether it is as it was written, for the experiment with this fingerprint.
    pub(super) fn is_unchanged(&self, fingerprint: u32) -> bool {
        self.check == self.expected_check(fingerprint)
    }

    /// Whether it is of this run of this case.
    pub(super) fn is(&self, case: &Case, run: u64) -> bool {
        (self.design, self.controller, self.sequence_length, self.run)
            == (&case.design, case.controller.name(), case.sequence_length, run)
    }

    pub(super) fn entry(&self) -> Entry {
        let Self { cost, total_cost, diverged, sent, age_sum, rejected, .. } = *self;
        // Not in the file.
        let lost_after = None;
        let result = RunResult { cost, diverged: diverged != 0, lost_after, sent, age_sum, rejected };
        Entry { result, total_cost }
    }
}

/// Rows of runs from `first` on of a case of `experiment`, as bytes of the file.
pub(super) fn rows(experiment: &Experiment, case: usize, first: u64, entries: &[Entry]) -> Vec<u8> {
    let (fingerprint, case) = (experiment.fingerprint(), &experiment.cases[case]);
    bytes((first..).zip(entries).map(|(run, entry)| Row::new(fingerprint, case, run, entry)))
}

fn bytes<'a>(rows: impl IntoIterator<Item = Row<'a>>) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).expect("rows fit memory");
    }
    writer.into_inner().expect("memory can be written")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{contender::Kind, monte_carlo::Plan};

    #[test]
    fn a_row_reads_as_it_was_written_to_the_last_bit() {
        let case = Case { design: "a, b".into(), controller: Kind::SlqgUdp, sequence_length: 3 };
        let plan = Plan { runs: 40, steps: 1, seed: 1 };
        let experiment = Experiment::new(plan, vec![], vec![case.clone()]);
        let result =
            RunResult { cost: 0.1 + 0.2, diverged: true, lost_after: None, sent: 4, age_sum: 5, rejected: 6 };
        for (cost, total_cost) in
            [(0.1 + 0.2, None), (1e300, Some(f64::INFINITY)), (5e-324, Some(-0.0)), (1.0, Some(1.0 / 3.0))]
        {
            let entry = Entry { result: RunResult { cost, ..result }, total_cost };
            let bytes = rows(&experiment, 0, 7, &[entry]);
            let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(bytes.as_slice());
            let record = reader.records().next().expect("a row").expect("well formed");
            let row: Row<'_> = record.deserialize(None).expect("a row");
            assert!(row.is(&case, 7));
            assert!(row.is_unchanged(experiment.fingerprint()));
            let other = Experiment { seed: 2, ..experiment.clone() };
            assert!(!row.is_unchanged(other.fingerprint()));
            let changed = Row { sent: row.sent + 1, ..row.clone() };
            assert!(!changed.is_unchanged(experiment.fingerprint()));
            assert_eq!(rows(&experiment, 0, 7, &[row.entry()]), bytes);
            assert_eq!(row.entry(), entry);
        }
    }
}
