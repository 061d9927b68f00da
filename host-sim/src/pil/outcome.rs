//! What a run with boards came to. How it is told, `telling` says.

use super::{
    difference::Difference,
    emulator::{Board, Transport},
    ends::Durations,
    restart::Restart,
    telling::said,
};
use nalgebra::SVector;
use slqg::wire::{Status, Tuned, Verdict};

/// Cycles that the state must stay near that of the undisturbed run to count as recovered.
const CALM: usize = 10;

/// What a run came to.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Name of the design.
    pub name: String,
    /// Inputs per sequence.
    pub sequence_length: usize,
    /// Cycles run.
    pub cycles: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// The boards.
    pub board: Board,
    /// The lines to them.
    pub transport: Transport,
    /// Cost of the run without boards, and without restarts.
    pub host_cost: f64,
    /// Cost of the run with the boards.
    pub board_cost: f64,
    /// Whether the state left all bounds.
    pub diverged: bool,
    /// Whether every applied input was finite.
    pub all_finite: bool,
    /// Control frames sent.
    pub sent: usize,
    /// The first difference between boards and simulator, if there is any.
    pub difference: Option<Difference>,
    /// What became of gains that were sent to the controller, and in which cycle it said so.
    pub replaced: Option<(Verdict, usize)>,
    /// What the controller did that tunes itself, and in which cycle.
    pub tuned: Vec<(usize, Tuned)>,
    /// What became of the loop after each restart.
    pub recoveries: Vec<Recovery>,
    /// What the controller's cycles cost, where instructions were counted.
    pub instructions: Option<Instructions>,
    /// The controller node at the end.
    pub controller: Status,
    /// The actuator node at the end.
    pub actuator: Status,
}

/// What became of the loop after a restart.
#[derive(Debug, Clone)]
pub struct Recovery {
    /// Which.
    pub restart: Restart,
    /// Cycles from the node's return until the state is, for ten cycles, nearer to that of the undisturbed run than the standard
    /// deviation of that; `None` if that does not come before the next restart.
    pub cycles: Option<usize>,
}

/// Instructions of the controller's cycles, frames taken in included.
#[derive(Debug, Clone, Copy)]
pub struct Instructions {
    /// Of a cycle in the mean.
    pub mean: f64,
    /// Of the longest cycle.
    pub longest: f64,
}

impl Instructions {
    pub(super) fn of(durations: &Durations, board: Board) -> Self {
        let instructions = |ticks: f64| ticks / board.ticks_per_instruction();
        Self {
            mean: instructions(durations.total as f64 / f64::from(durations.cycles.max(1))),
            longest: instructions(f64::from(durations.longest)),
        }
    }
}

/// When the state was near that of the undisturbed run again.
pub(super) fn recoveries<const NX: usize>(
    restarts: &[Restart],
    undisturbed: &[SVector<f64, NX>],
    states: &[SVector<f64, NX>],
) -> Vec<Recovery> {
    let count = undisturbed.len().max(1) as f64;
    let mean = undisturbed.iter().sum::<SVector<f64, NX>>() / count;
    let variance = |row: usize| undisturbed.iter().map(|x| (x[row] - mean[row]).powi(2)).sum::<f64>() / count;
    let deviation = SVector::<f64, NX>::from_fn(|row, _| variance(row).sqrt());
    let is_near = |cycle: &usize| {
        (0..NX).all(|row| (states[*cycle][row] - undisturbed[*cycle][row]).abs() <= deviation[row])
    };
    let next = restarts.iter().skip(1).map(|restart| restart.away.start).chain([states.len()]);
    restarts
        .iter()
        .zip(next)
        .map(|(restart, end)| {
            let after = restart.away.end.min(end)..end;
            let mut calm = 0;
            let last = after.clone().find(|cycle| {
                calm = if is_near(cycle) { calm + 1 } else { 0 };
                calm == CALM
            });
            let cycles = last.map(|cycle| cycle + 1 - CALM - after.start);
            Recovery { restart: restart.clone(), cycles }
        })
        .collect()
}

impl Outcome {
    /// What went wrong; nothing if boards and simulator agree to the bit, the loop is stable, and gains that were sent are in
    /// force.
    pub fn failures(&self) -> Vec<String> {
        let replaced = self.replaced.filter(|(verdict, _)| *verdict != Verdict::InForce);
        [
            self.difference
                .as_ref()
                .map(|found| format!("boards and simulator differ in cycle {}", found.cycle)),
            self.diverged.then(|| "the state left all bounds".to_owned()),
            (!self.all_finite).then(|| "an applied input was not finite".to_owned()),
            replaced.map(|(verdict, _)| format!("gains sent: {}", said(verdict))),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slqg::wire::Role;

    fn outcome() -> Outcome {
        let status = |role| Status {
            role,
            cycles: 100,
            realigned: 0,
            rejected: 0,
            overruns: 0,
            stack: 1000,
            variables: 500,
        };
        Outcome {
            name: "motor".to_owned(),
            sequence_length: 4,
            cycles: 100,
            seed: 1,
            board: Board::Mps2An386,
            transport: Transport::Bulk,
            host_cost: 1.0,
            board_cost: 1.0,
            diverged: false,
            all_finite: true,
            sent: 100,
            difference: None,
            replaced: None,
            tuned: Vec::new(),
            recoveries: Vec::new(),
            instructions: None,
            controller: status(Role::Controller),
            actuator: status(Role::Actuator),
        }
    }

    #[test]
    fn gains_that_are_not_in_force_are_a_failure_and_are_told() {
        let with = |verdict| Outcome { replaced: Some((verdict, 7)), ..outcome() };
        assert!(with(Verdict::InForce).failures().is_empty());
        let refused = with(Verdict::Design);
        assert_eq!(refused.failures(), ["gains sent: refused: for another plant"]);
        assert!(refused.text().contains("cycle 7: refused: for another plant"), "{}", refused.text());
        let json = refused.json();
        assert_eq!((&json["gains"]["in_force"], &json["gains"]["cycle"]), (&false.into(), &7.into()));
        assert_eq!(with(Verdict::Incomplete).failures(), ["gains sent: not all sent"]);
    }

    #[test]
    fn a_difference_is_a_failure_and_one_failure_does_not_hide_another() {
        assert!(outcome().failures().is_empty());
        let [what, host, board] = ["applied input 1", "1", "2"].map(str::to_owned);
        let difference = Some(Difference { cycle: 9, what, host, board });
        let failed = Outcome { difference, diverged: true, all_finite: false, ..outcome() };
        assert_eq!(failed.failures().len(), 3);
        assert_eq!(failed.failures()[0], "boards and simulator differ in cycle 9");
    }

    #[test]
    fn recovery_counts_from_the_return_to_the_first_of_ten_calm_cycles() {
        let undisturbed: Vec<_> = (0..100).map(|cycle| SVector::from([f64::from(cycle % 2)])).collect();
        let mut states = undisturbed.clone();
        states[20..33].iter_mut().for_each(|state| state[0] += 5.0);
        let restart = |away| Restart { role: Role::Controller, away };
        let found = recoveries(&[restart(20..30), restart(95..98)], &undisturbed, &states);
        assert_eq!(found[0].cycles, Some(3));
        assert_eq!(found[1].cycles, None, "the run ends before ten cycles are over");
    }
}
