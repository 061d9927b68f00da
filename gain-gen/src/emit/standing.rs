//! What generated source says of the loop's stability: the verdict, what it rests on, and what was accepted.

use crate::report::{Report, Verdict, wrapped};

/// Width of a line, without what makes it a comment.
const WIDTH: usize = 110;

/// Lines of a comment.
pub(super) fn lines(report: &Report) -> Vec<String> {
    if let Some(task) = &report.task {
        let cycles = task.laws.len();
        return vec![format!("Stability: not asked for, as this is a task that ends after {cycles} cycles.")];
    }
    match report.verdict() {
        Verdict::Stable => wrapped(
            "Stability: stable in the mean square, if plant and noise are as the design has them and packets are \
             independent of each other, with its delays. docs/certificate.md says what is not proved.",
            WIDTH,
        ),
        verdict => {
            let mut lines = vec![format!("Stability: {}, which was accepted. Not shown:", verdict.name())];
            for condition in &report.failed_conditions {
                lines.extend(wrapped(&format!("- {condition}"), WIDTH));
            }
            lines
        }
    }
}
