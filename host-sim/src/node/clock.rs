//! Cycles on the wall clock: which cycle it is, when a node acts in it, and what becomes of cycles that were missed.
//!
//! Nothing here asks for the time; it is always a parameter, so that all of it can be tested without waiting.

use slqg::Tick;
use std::time::{Duration, SystemTime};

const SECOND: f64 = 1e9;
/// Shorter cycles are not for an operating system that schedules by its own lights, in ns.
const SHORTEST: f64 = 1e5;
/// One cycle a day, in ns.
const LONGEST: f64 = 86_400.0 * SECOND;

/// Nanoseconds since the Unix epoch, leap seconds not counted. Lasts until the year 2554.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct WallTime(pub u64);

impl WallTime {
    /// The machine's wall clock.
    pub fn now() -> Self {
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        Self(u64::try_from(since.as_nanos()).unwrap_or(u64::MAX))
    }

    /// How long until `later`; zero if it is over.
    pub fn until(self, later: Self) -> Duration {
        Duration::from_nanos(later.0.saturating_sub(self.0))
    }

    /// `duration` later.
    pub fn after(self, duration: Duration) -> Self {
        Self(self.0.saturating_add(u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)))
    }
}

/// When one node acts: once a cycle, a fixed part of the cycle after it began.
///
/// Cycle `n` begins `n` sample times after the Unix epoch, and its tick is `n mod 2^32`: every node that knows the time knows
/// the tick. Integers throughout: the sample time is rounded to whole nanoseconds first, and the phase after that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timetable {
    sample_time: u64,
    phase: u64,
}

impl Timetable {
    /// Acts `phase` cycles, in 0..1, after each cycle of `sample_time` seconds began.
    ///
    /// # Errors
    /// If the sample time is shorter than 0.1 ms or longer than a day.
    pub fn new(sample_time: f64, phase: f64) -> Result<Self, String> {
        let nanoseconds = (sample_time * SECOND).round();
        if !(SHORTEST..=LONGEST).contains(&nanoseconds) {
            return Err(format!(
                "plant.sample_time: found {sample_time} s; in real time it must be within 0.0001 s and a day"
            ));
        }
        let phase = (phase.clamp(0.0, 1.0) * nanoseconds).round().min(nanoseconds - 1.0) as u64;
        Ok(Self { sample_time: nanoseconds as u64, phase })
    }

    /// Length of a cycle.
    pub fn sample_time(&self) -> Duration {
        Duration::from_nanos(self.sample_time)
    }

    /// When `cycle` begins.
    pub fn begin(&self, cycle: u64) -> WallTime {
        WallTime(cycle.saturating_mul(self.sample_time))
    }

    /// When the node acts in `cycle`.
    pub fn acts(&self, cycle: u64) -> WallTime {
        WallTime(self.begin(cycle).0.saturating_add(self.phase))
    }

    /// The cycle that has begun last.
    pub fn cycle(&self, now: WallTime) -> u64 {
        now.0 / self.sample_time
    }

    /// The newest cycle in which the node was to act by now.
    pub fn newest(&self, now: WallTime) -> u64 {
        now.0.saturating_sub(self.phase) / self.sample_time
    }

    /// The cycle next to the current one that has this tick; `None` if it lies before the epoch.
    pub fn cycle_of(&self, tick: Tick, now: WallTime) -> Option<u64> {
        let current = self.cycle(now);
        current.checked_add_signed(i64::from(tick.since(tick_of(current))))
    }
}

/// The tick of a cycle.
pub fn tick_of(cycle: u64) -> Tick {
    Tick(cycle as u32)
}

/// What is to be done now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Due {
    /// Nothing yet.
    Nothing,
    /// Act in `cycle`.
    Act {
        /// Cycles before it that nobody woke up in; they are to be caught up with, oldest first.
        skipped: u64,
        /// The current cycle.
        cycle: u64,
        /// How long ago it was to be acted in.
        late: Duration,
    },
    /// Too many cycles are missing, or the clock was set back as far: begin anew in `cycle`.
    BeginAnew {
        /// The current cycle.
        cycle: u64,
        /// How long ago it was to be acted in.
        late: Duration,
    },
}

/// Acts in every cycle once and in order, however late it is asked.
#[derive(Debug, Clone)]
pub struct Pacer {
    timetable: Timetable,
    next: u64,
    begin_anew_after: u64,
}

impl Pacer {
    /// Joins in the first cycle whose phase is after `now`. Begins anew if `begin_anew_after` cycles or more are missing.
    pub fn new(timetable: Timetable, begin_anew_after: u64, now: WallTime) -> Self {
        Self { timetable, next: timetable.newest(now) + 1, begin_anew_after: begin_anew_after.max(1) }
    }

    /// When it acts.
    pub fn timetable(&self) -> &Timetable {
        &self.timetable
    }

    /// When it acts next.
    pub fn next(&self) -> WallTime {
        self.timetable.acts(self.next)
    }

    /// What is due at `now`; whatever it is, it is not due again.
    ///
    /// A clock that was set back a little is waited for: no cycle is acted in twice.
    pub fn due(&mut self, now: WallTime) -> Due {
        let cycle = self.timetable.newest(now);
        let late = self.timetable.acts(cycle).until(now);
        let due = if cycle < self.next {
            if self.next - cycle <= self.begin_anew_after {
                return Due::Nothing;
            }
            Due::BeginAnew { cycle, late }
        } else if cycle - self.next >= self.begin_anew_after {
            Due::BeginAnew { cycle, late }
        } else {
            Due::Act { skipped: cycle - self.next, cycle, late }
        };
        self.next = cycle + 1;
        due
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// 10 ms cycles, acting at 3 ms, begun anew after 64.
    fn pacer(now: u64) -> Pacer {
        Pacer::new(Timetable::new(0.01, 0.3).expect("10 ms"), 64, WallTime(now))
    }

    fn late(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn every_node_that_knows_the_time_knows_the_tick() {
        let timetable = Timetable::new(0.01, 0.3).expect("10 ms");
        let now = WallTime(1_800_000_000 * 1_000_000_000 + 7 * MS);
        let cycle = timetable.cycle(now);
        assert_eq!((cycle, tick_of(cycle)), (180_000_000_000, Tick(3_906_340_864)));
        for away in [-3_i64, 0, 2] {
            let other = cycle.checked_add_signed(away).expect("after the epoch");
            assert_eq!(timetable.cycle_of(tick_of(other), now), Some(other));
        }
    }

    #[test]
    fn ticks_wrap_and_cycles_go_on() {
        let timetable = Timetable::new(0.01, 0.0).expect("10 ms");
        let now = timetable.begin(1 << 32);
        assert_eq!(tick_of(timetable.cycle(now)), Tick(0));
        assert_eq!(timetable.cycle_of(Tick(u32::MAX), now), Some((1 << 32) - 1));
        assert_eq!(timetable.cycle_of(Tick(1), now), Some((1 << 32) + 1));
    }

    #[test]
    fn a_node_joins_in_the_next_cycle_whatever_the_time() {
        assert_eq!(pacer(1000 * MS).next(), WallTime(1003 * MS), "the phase is yet to come");
        assert_eq!(pacer(1003 * MS).next(), WallTime(1013 * MS), "the phase is now: it is too late");
    }

    #[test]
    fn a_cycle_is_due_once() {
        let mut pacer = pacer(1000 * MS);
        assert_eq!(pacer.due(WallTime(1002 * MS)), Due::Nothing);
        assert_eq!(pacer.due(WallTime(1004 * MS)), Due::Act { skipped: 0, cycle: 100, late: late(1) });
        assert_eq!(pacer.due(WallTime(1005 * MS)), Due::Nothing);
        assert_eq!(pacer.next(), WallTime(1013 * MS));
    }

    #[test]
    fn missed_cycles_are_counted_and_the_newest_is_acted_in() {
        let mut pacer = pacer(1000 * MS);
        assert_eq!(pacer.due(WallTime(1038 * MS)), Due::Act { skipped: 3, cycle: 103, late: late(5) });
        assert_eq!(pacer.next(), WallTime(1043 * MS));
    }

    #[test]
    fn after_too_many_missed_cycles_the_node_begins_anew() {
        let mut pacer = pacer(1000 * MS);
        let now = WallTime((1003 + 64 * 10) * MS);
        assert_eq!(pacer.due(now), Due::BeginAnew { cycle: 164, late: late(0) });
        assert_eq!(pacer.due(now), Due::Nothing);
    }

    #[test]
    fn a_clock_set_back_a_little_is_waited_for_and_one_set_back_far_is_followed() {
        let mut pacer = pacer(100_000 * MS);
        assert!(matches!(pacer.due(WallTime(100_003 * MS)), Due::Act { cycle: 10_000, .. }));
        assert_eq!(pacer.due(WallTime(99_953 * MS)), Due::Nothing);
        assert!(matches!(pacer.due(WallTime(100_013 * MS)), Due::Act { skipped: 0, cycle: 10_001, .. }));
        assert!(matches!(pacer.due(WallTime(5_003 * MS)), Due::BeginAnew { cycle: 500, .. }));
    }

    #[test]
    fn a_sample_time_that_no_operating_system_keeps_is_refused() {
        for wrong in [1e-5, 0.0, -1.0, 1e6, f64::NAN] {
            assert!(Timetable::new(wrong, 0.0).is_err(), "{wrong}");
        }
    }
}
