//! An outcome in words and as JSON.

use super::{
    difference::Difference,
    outcome::{Instructions, Outcome, Recovery},
    remote::name,
};
use serde_json::{Value, json};
use slqg::wire::{Status, Tuned, TuningStep, Verdict};
use std::fmt::Write;

impl Outcome {
    /// For people.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{}, N = {}, {} cycles, seed {}, two boards {} over {}\n",
            self.name,
            self.sequence_length,
            self.cycles,
            self.seed,
            self.board.name(),
            self.transport.name()
        );
        let mut line = |name: &str, value: String| {
            // Writing to a string does not fail.
            let _ = writeln!(text, "  {name:<22} {value}");
        };
        match &self.difference {
            None => {
                line("boards and simulator", "every frame and every applied input equal, to the bit".into())
            }
            Some(Difference { cycle, what, host, board }) => {
                line("FIRST DIFFERENCE", format!("cycle {cycle}, {what}"));
                line("  simulator", host.clone());
                line("  board", board.clone());
            }
        }
        line("cost", format!("{:.6} with the boards, {:.6} without", self.board_cost, self.host_cost));
        line("control frames", format!("{} in {} cycles", self.sent, self.cycles));
        if self.diverged {
            line("STATE", "left all bounds".into());
        }
        if !self.all_finite {
            line("INPUT", "not finite".into());
        }
        if let Some((verdict, cycle)) = self.replaced {
            line("gains sent", format!("cycle {cycle}: {}", said(verdict)));
        }
        for (cycle, tuned) in &self.tuned {
            line("tuned", format!("cycle {cycle}: {}", done(*tuned)));
        }
        if !self.recoveries.is_empty() {
            line("restarts", self.recovered());
        }
        if let Some(Instructions { mean, longest }) = self.instructions {
            line("controller's cycle", format!("{mean:.0} instructions in the mean, {longest:.0} at most"));
        }
        for status in [&self.controller, &self.actuator] {
            let Status { stack, variables, rejected, overruns, .. } = status;
            line(
                name(status.role),
                format!(
                    "RAM {} bytes (stack {stack}, variables {variables}); frames refused {rejected}, lost {overruns}",
                    stack + variables
                ),
            );
        }
        text
    }

    fn recovered(&self) -> String {
        let mut cycles: Vec<usize> = self.recoveries.iter().filter_map(|recovery| recovery.cycles).collect();
        cycles.sort_unstable();
        let all = self.recoveries.len();
        match cycles.as_slice() {
            [] => format!("{all}, the loop recovered from none of them before the next"),
            [.., most] => format!(
                "{all}; the loop recovered from {} of them, within {} cycles in the median, {most} at most",
                cycles.len(),
                cycles[cycles.len() / 2]
            ),
        }
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let status = |status: &Status| {
            json!({
                "cycles": status.cycles, "realigned": status.realigned, "rejected": status.rejected,
                "overruns": status.overruns, "stack": status.stack, "variables": status.variables,
            })
        };
        let recovery = |recovery: &Recovery| {
            json!({
                "node": name(recovery.restart.role), "killed": recovery.restart.away.start,
                "back": recovery.restart.away.end, "recovered_within": recovery.cycles,
            })
        };
        json!({
            "name": self.name, "sequence_length": self.sequence_length, "cycles": self.cycles, "seed": self.seed,
            "board": self.board.name(), "transport": self.transport.name(),
            "identical": self.difference.is_none(), "first_difference": self.difference,
            "host_cost": self.host_cost, "board_cost": self.board_cost,
            "diverged": self.diverged, "all_finite": self.all_finite, "sent": self.sent,
            "restarts": self.recoveries.iter().map(recovery).collect::<Vec<_>>(),
            "gains": self.replaced.map(|(verdict, cycle)| json!({
                "verdict": said(verdict), "in_force": verdict == Verdict::InForce, "cycle": cycle,
            })),
            "tuned": self.tuned.iter().map(|(cycle, tuned)| json!({ "cycle": cycle, "did": done(*tuned) })).collect::<Vec<_>>(),
            "instructions": self.instructions.map(|count| json!({ "mean": count.mean, "longest": count.longest })),
            "controller": status(&self.controller), "actuator": status(&self.actuator),
        })
    }
}

/// What was done about the gains, in words.
fn done(Tuned { step, steps, value }: Tuned) -> String {
    match step {
        TuningStep::Started => format!("the link has changed (distance {value:.1}), solving"),
        TuningStep::Switched => {
            format!("new gains in force after {steps} steps, mean-square rate at most {value:.4}")
        }
        TuningStep::Kept => "no gains found, those in force stay".to_owned(),
    }
}

/// A verdict in words.
pub(super) fn said(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Incomplete => "not all sent",
        Verdict::InForce => "in force",
        Verdict::TooLong => "refused as too long",
        Verdict::Damaged => "refused as damaged",
        Verdict::Format => "refused: another version or scalar",
        Verdict::Design => "refused: for another plant",
        Verdict::Dimensions => "refused: for another length or default input, or the node takes none",
        Verdict::Numbers => "refused: no gains",
    }
}
