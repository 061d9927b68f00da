//! What has arrived of one kind of frame: how many, how many cycles without one, how long after their cycle began.
//!
//! Whether a frame is of any use is the core's to say.

use super::{
    clock::{Timetable, WallTime},
    statistics::{Figure, Mean},
};
use slqg::Tick;

/// Cycles among which repetitions are told from frames that are late.
const WINDOW: u64 = 128;
/// Frames of cycles further away from the current one are of other loops.
const HORIZON: u64 = 1 << 16;

/// Frames of one kind as they arrive.
#[derive(Debug, Clone, Default)]
pub struct Arrivals {
    received: u64,
    repeated: u64,
    first: Option<u64>,
    newest: u64,
    /// Bit `i`: the frame of cycle `newest - i` has arrived.
    window: u128,
    distinct: u64,
    delay: Mean,
}

impl Arrivals {
    /// Takes note of a frame about `tick` that arrives at `now`.
    pub fn note(&mut self, tick: Tick, timetable: &Timetable, now: WallTime) {
        self.received += 1;
        let Some(cycle) = timetable.cycle_of(tick, now) else { return };
        if cycle.abs_diff(timetable.cycle(now)) > HORIZON {
            return;
        }
        let first = *self.first.get_or_insert(cycle);
        if self.window == 0 {
            self.newest = cycle;
        }
        if cycle > self.newest {
            let ahead = u32::try_from(cycle - self.newest).unwrap_or(u32::MAX);
            self.window = self.window.checked_shl(ahead).unwrap_or(0);
            self.newest = cycle;
        }
        let place = self.newest - cycle;
        if cycle < first || place >= WINDOW {
            // Before what is counted, or too late to tell whether it is a repetition.
            return;
        }
        if self.window >> place & 1 == 1 {
            self.repeated += 1;
            return;
        }
        self.window |= 1 << place;
        self.distinct += 1;
        self.delay.add(timetable.begin(cycle).until(now).as_secs_f64());
    }

    /// Cycles between the first and the newest frame of which none has arrived.
    pub fn gaps(&self) -> u64 {
        self.first.map_or(0, |first| (self.newest + 1 - first).saturating_sub(self.distinct))
    }

    /// To print.
    pub fn figures(&self) -> Vec<(&'static str, Figure)> {
        vec![
            ("received", Figure::Count(self.received)),
            ("repeated", Figure::Count(self.repeated)),
            ("gaps", Figure::Count(self.gaps())),
            ("mean_delay", Figure::Seconds(self.delay.mean())),
            ("worst_delay", Figure::Seconds(self.delay.worst())),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noted(cycles: &[u64]) -> Arrivals {
        let timetable = Timetable::new(0.01, 0.0).expect("10 ms");
        let mut arrivals = Arrivals::default();
        for &cycle in cycles {
            let now = timetable.begin(1_000_000 + 20);
            arrivals.note(Tick((1_000_000 + cycle) as u32), &timetable, now);
        }
        arrivals
    }

    #[test]
    fn cycles_without_a_frame_are_gaps() {
        assert_eq!(noted(&[3, 4, 7, 8]).gaps(), 2);
        assert_eq!(noted(&[]).gaps(), 0);
    }

    #[test]
    fn a_late_frame_closes_its_gap_and_a_repeated_one_does_not() {
        let arrivals = noted(&[3, 5, 4, 7, 5]);
        assert_eq!((arrivals.gaps(), arrivals.repeated, arrivals.received), (1, 1, 5));
    }

    #[test]
    fn a_frame_of_another_loop_opens_no_gap() {
        let mut arrivals = noted(&[3, 4]);
        let timetable = Timetable::new(0.01, 0.0).expect("10 ms");
        arrivals.note(Tick(0x8000_0000), &timetable, timetable.begin(1_000_004));
        assert_eq!((arrivals.gaps(), arrivals.received), (0, 3));
    }
}
