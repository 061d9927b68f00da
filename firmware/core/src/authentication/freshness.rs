//! A frame is taken once: which cycles' frames a session has taken.

use crate::{Tick, wire::Kind};

/// Cycles that are remembered: a frame may be that much older than the newest of its session.
const WINDOW: u32 = 256;
const WORDS: usize = (WINDOW / u32::BITS) as usize;
/// Cycles after which a session is to be renewed, and after which it ends: well before a tick comes again.
const RENEWED_AFTER: u32 = 1 << 30;
const ENDS_AFTER: u32 = RENEWED_AFTER + (1 << 29);

/// What a session has taken of one kind of frame. Ticks are compared within one session only, which ends before they wrap.
#[derive(Debug, Clone, Default)]
pub(super) struct Freshness {
    newest: Option<Tick>,
    /// One bit for each cycle of the window, at its tick modulo [`WINDOW`].
    taken: [u32; WORDS],
    /// Of the newest cycle, whether the clock has said that it begins.
    has_begun: bool,
    /// Cycles since the session's first frame.
    passed: u32,
}

impl Freshness {
    /// Whether the session has lasted so long that it is to be renewed.
    pub(super) fn is_old(&self) -> bool {
        self.passed >= RENEWED_AFTER
    }

    /// Takes a frame of cycle `tick`; `None` if the session has ended, `Some(false)` if the frame was taken before or cannot be
    /// told from one that was. `begins` matters for clock frames alone.
    pub(super) fn take(&mut self, kind: Kind, tick: Tick, begins: bool) -> Option<bool> {
        if self.passed >= ENDS_AFTER {
            return None;
        }
        Some(match kind {
            // An older one would begin anew what newer ones have told.
            Kind::Clock => self.take_newer(tick, begins),
            Kind::Reference => self.take_newer(tick, true),
            // Its tick is a version, which outlives sessions.
            Kind::GainsPart => true,
            _ => self.take_in_window(tick),
        })
    }

    /// In any order, each once.
    fn take_in_window(&mut self, tick: Tick) -> bool {
        let newest = self.newest.unwrap_or(tick);
        if let Some(age) = newest.age_of(tick)
            && self.newest.is_some()
        {
            if age >= WINDOW || self.is_taken(tick) {
                return false;
            }
        } else {
            self.go_on_to(tick);
        }
        self.taken[word(tick)] |= bit(tick);
        true
    }

    /// In order; a cycle that comes next may be told before it begins.
    fn take_newer(&mut self, tick: Tick, begins: bool) -> bool {
        let is_newer = match self.newest {
            None => true,
            Some(newest) => tick.is_after(newest) || tick == newest && begins && !self.has_begun,
        };
        if is_newer {
            self.go_on_to(tick);
            self.has_begun = begins;
        }
        is_newer
    }

    fn is_taken(&self, tick: Tick) -> bool {
        self.taken[word(tick)] & bit(tick) != 0
    }

    /// `tick` is the newest one: cycles between it and the one before were not heard of.
    fn go_on_to(&mut self, tick: Tick) {
        let step = self.newest.map_or(0, |newest| tick.since(newest).unsigned_abs());
        self.passed = self.passed.saturating_add(step);
        if step >= WINDOW {
            self.taken = [0; WORDS];
        } else {
            (0..step).for_each(|ago| self.taken[word(tick - ago)] &= !bit(tick - ago));
        }
        self.newest = Some(tick);
    }
}

fn word(tick: Tick) -> usize {
    (tick.0 % WINDOW / u32::BITS) as usize
}

fn bit(tick: Tick) -> u32 {
    1 << (tick.0 % u32::BITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn take(freshness: &mut Freshness, tick: u32) -> bool {
        freshness.take(Kind::Control, Tick(tick), true).expect("the session lasts")
    }

    #[test]
    fn each_cycle_is_taken_once_in_any_order() {
        let mut freshness = Freshness::default();
        for tick in [u32::MAX - 1, 1, 0, u32::MAX, 5, 3] {
            assert!(take(&mut freshness, tick), "{tick}");
            assert!(!take(&mut freshness, tick), "{tick} again");
        }
        assert!(!take(&mut freshness, 1) && take(&mut freshness, 4));
    }

    #[test]
    fn what_is_too_old_to_tell_is_refused() {
        let mut freshness = Freshness::default();
        assert!(take(&mut freshness, 1000) && take(&mut freshness, 745) && !take(&mut freshness, 744));
        assert!(take(&mut freshness, 1255));
        assert!(!take(&mut freshness, 1000) && take(&mut freshness, 1001));
        assert!(take(&mut freshness, 1000 + 65_536) && !take(&mut freshness, 1000));
    }

    #[test]
    fn a_bit_of_an_earlier_round_is_not_taken_for_one_of_this() {
        let mut freshness = Freshness::default();
        assert!(take(&mut freshness, 7) && take(&mut freshness, 8));
        assert!(take(&mut freshness, 8 + WINDOW) && take(&mut freshness, 7 + WINDOW));
    }

    #[test]
    fn a_session_ends_before_a_tick_comes_again() {
        let mut freshness = Freshness::default();
        assert!(take(&mut freshness, 0));
        let (mut tick, mut was_old) = (0_u32, false);
        while freshness.take(Kind::Control, Tick(tick), true).is_some() {
            was_old |= freshness.is_old();
            assert!(tick < 1 << 31, "a tick would be as far away one way as the other");
            tick += 1 << 28;
        }
        assert!(was_old, "it says so in time");
    }

    #[test]
    fn the_clock_never_goes_back_and_says_of_each_cycle_at_most_that_it_comes_and_that_it_begins() {
        let mut freshness = Freshness::default();
        let mut clock = |tick, begins| freshness.take(Kind::Clock, Tick(tick), begins).unwrap();
        assert!(clock(7, false) && !clock(7, false) && clock(7, true) && !clock(7, true) && !clock(7, false));
        assert!(clock(9, true) && !clock(8, true) && clock(10, false));
    }
}
