//! Whether another node's clock is apart from this one's, and by how much, as the ticks of its packets tell.

use super::clock::{Timetable, WallTime};
use super::statistics::Figure;
use slqg::Tick;
use std::collections::VecDeque;

/// Packets that are looked back at.
const RECENT: usize = 50;
/// Packets before anything is said.
const ENOUGH: usize = 10;
/// Ticks that are further away are of other loops, in cycles.
const HORIZON: u64 = 1 << 16;

/// How packets come from another node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Over a link that may delay them: only ticks of cycles that have not begun tell that the clocks are apart.
    Link,
    /// Over a wire, in the cycle they are of or at its end: ticks of older cycles tell it, too.
    Wire,
}

/// What the ticks of another node's packets tell of its clock.
#[derive(Debug, Clone)]
pub struct ClockOffset {
    way: Way,
    /// Cycles that each of the recent packets was old when it came; below zero if its cycle had not begun.
    ages: VecDeque<i64>,
}

impl ClockOffset {
    /// Of a node whose packets come this way.
    pub fn new(way: Way) -> Self {
        Self { way, ages: VecDeque::with_capacity(RECENT) }
    }

    /// Takes note of a packet about `tick` that arrives at `now`.
    pub fn note(&mut self, tick: Tick, timetable: &Timetable, now: WallTime) {
        let current = timetable.cycle(now);
        let Some(cycle) = timetable.cycle_of(tick, now).filter(|of| of.abs_diff(current) < HORIZON) else {
            return;
        };
        if self.ages.len() == RECENT {
            self.ages.pop_front();
        }
        self.ages.push_back(current as i64 - cycle as i64);
    }

    /// Cycles by which the other clock is ahead of this one, below zero behind; 0 if they are together as far as can be told.
    ///
    /// Nine tenths of the packets were this old or older: what is late by chance does not count, nor does a packet that
    /// was forged.
    pub fn cycles_ahead(&self) -> i64 {
        if self.ages.len() < ENOUGH {
            return 0;
        }
        let mut ages: Vec<i64> = self.ages.iter().copied().collect();
        ages.sort_unstable();
        match ages[ages.len() / 10] {
            early @ ..=-1 => -early,
            // A packet may come at the very end of its cycle.
            late @ 2.. if self.way == Way::Wire => -late,
            _ => 0,
        }
    }

    /// To print.
    pub fn figure(&self) -> Figure {
        Figure::Cycles(self.cycles_ahead())
    }

    /// A sentence about the clock of the node `whose`; `None` if there is nothing to say.
    pub fn sentence(&self, whose: &str) -> Option<String> {
        let ahead = self.cycles_ahead();
        let cycles = match ahead.unsigned_abs() {
            0 => return None,
            1 => "1 cycle".to_owned(),
            cycles => format!("{cycles} cycles"),
        };
        let side = if ahead > 0 { "ahead of" } else { "behind" };
        Some(format!(
            "the {whose}'s clock is {cycles} {side} this node's: what is told of other cycles is rejected or late; \
             synchronise the machines' clocks (PTP, chrony), docs/real-time.md"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noted(way: Way, ages: impl IntoIterator<Item = i64>) -> i64 {
        let timetable = Timetable::new(0.01, 0.0).expect("10 ms");
        let mut offset = ClockOffset::new(way);
        for age in ages {
            offset.note(Tick((1_000_000 - age) as u32), &timetable, timetable.begin(1_000_000));
        }
        offset.cycles_ahead()
    }

    #[test]
    fn packets_of_cycles_to_come_tell_of_a_clock_that_is_ahead() {
        assert_eq!([Way::Link, Way::Wire].map(|way| noted(way, [-5; 20])), [5; 2]);
    }

    #[test]
    fn old_packets_tell_of_a_clock_that_is_behind_only_where_nothing_delays_them() {
        assert_eq!([Way::Link, Way::Wire].map(|way| noted(way, [5; 20])), [0, -5]);
        assert_eq!(noted(Way::Wire, [1; 20]), 0, "the end of the cycle");
    }

    #[test]
    fn delays_and_single_packets_tell_nothing() {
        assert_eq!(noted(Way::Wire, (0..20).map(|packet| if packet % 3 == 0 { 0 } else { 7 })), 0);
        assert_eq!(noted(Way::Link, [0, 0, 0, -5, 0, 0, 0, 0, 0, 0, 0, 0]), 0);
        assert_eq!(noted(Way::Wire, [5; 9]), 0, "too few");
    }

    #[test]
    fn a_clock_that_was_put_right_is_forgotten() {
        assert_eq!(noted(Way::Wire, [5; 50].into_iter().chain([0; 10])), 0);
    }
}
