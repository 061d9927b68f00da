//! Which cycle a node is in, and who begins the next one: the clock on the link, or the node's own timer.
//!
//! All nodes of a loop must count the same cycles. Whoever keeps the time sends a clock frame as each cycle begins. A node
//! that misses one goes on by its own timer, and one that has just started takes the cycle that it is told.
//!
//! A clock that jumps is not believed at once: one wrong frame would make a node forget all it knows. The new time is taken when
//! it has been told by [`CONFIRMING`] frames in a row that count on. What is done in a cycle is not known here.

use slqg::{Tick, wire::Clock};

/// What a node does as a clock frame or its timer tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begin {
    /// It runs the next cycle.
    Next,
    /// It forgets what it knows, and the cycle that comes next is this one.
    Align(Tick),
    /// It forgets what it knows and begins with this cycle.
    Anew(Tick),
    /// Nothing, and it tells that: the clock has jumped to this cycle, which nothing confirms yet.
    Refused(Tick),
    /// Nothing: it has begun this cycle by itself, or does not know the time.
    Nothing,
}

/// Clock frames in a row that must tell the same new time before a node takes it.
pub const CONFIRMING: u8 = 3;

/// A time that the node does not have, as the frames in a row tell it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Jump {
    /// The newest cycle told.
    tick: Tick,
    frames: u8,
}

/// A node's count of cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Count {
    /// The cycle that comes next; `None` before the first clock frame.
    next: Option<Tick>,
    /// Whether it waits for the clock, however long that takes.
    waits: bool,
    /// What the last clock frame told, if it was another time than the node's.
    jump: Option<Jump>,
}

impl Count {
    /// A clock frame says that cycle `tick` begins, or comes next.
    pub fn told(&mut self, tick: Tick, clock: Clock) -> Begin {
        // Where the node's timer was a little early, it has begun the cycle by itself.
        let is_expected = |next| tick == next || clock.begins && tick + 1 == next;
        if !self.next.is_none_or(is_expected) && !self.is_confirmed(tick) {
            return Begin::Refused(tick);
        }
        self.jump = None;
        self.waits = clock.period_us == 0;
        match self.next {
            Some(next) if !clock.begins && next == tick => Begin::Nothing,
            _ if !clock.begins => {
                self.next = Some(tick);
                Begin::Align(tick)
            }
            Some(next) if next == tick => self.begin(tick, Begin::Next),
            Some(next) if next == tick + 1 => Begin::Nothing,
            _ => self.begin(tick, Begin::Anew(tick)),
        }
    }

    /// Whether this frame, of another time than the node's, is the last one that it takes to believe it.
    fn is_confirmed(&mut self, tick: Tick) -> bool {
        let frames = match self.jump {
            Some(jump) if tick == jump.tick + 1 => jump.frames + 1,
            // What comes next, and then that it begins: one time, told twice.
            Some(jump) if tick == jump.tick => jump.frames,
            _ => 1,
        };
        self.jump = Some(Jump { tick, frames });
        frames >= CONFIRMING
    }

    /// The node's timer says that a period is over.
    pub fn period_over(&mut self) -> Begin {
        match self.next {
            Some(next) if !self.waits => self.begin(next, Begin::Next),
            _ => Begin::Nothing,
        }
    }

    /// The cycle that comes next, if that is known.
    pub fn next(&self) -> Option<Tick> {
        self.next
    }

    fn begin(&mut self, tick: Tick, begin: Begin) -> Begin {
        self.next = Some(tick + 1);
        begin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUNNING: Clock = Clock { begins: true, period_us: 20_000 };
    const STEPPED: Clock = Clock { begins: true, period_us: 0 };

    #[test]
    fn a_node_takes_the_first_cycle_it_is_told_and_counts_on() {
        let mut count = Count::default();
        assert_eq!(count.period_over(), Begin::Nothing, "it does not know the time");
        assert_eq!(count.told(Tick(7), RUNNING), Begin::Anew(Tick(7)));
        assert_eq!(count.told(Tick(8), RUNNING), Begin::Next);
        assert_eq!(count.next(), Some(Tick(9)));
    }

    #[test]
    fn a_cycle_that_the_timer_has_begun_is_not_begun_again_by_the_clock() {
        let mut count = Count::default();
        count.told(Tick(u32::MAX), RUNNING);
        assert_eq!(count.period_over(), Begin::Next);
        assert_eq!(count.told(Tick(0), RUNNING), Begin::Nothing);
        assert_eq!(count.told(Tick(1), RUNNING), Begin::Next);
    }

    /// Eight cycles on their way.
    fn running() -> Count {
        let mut count = Count::default();
        (0..8).for_each(|tick| {
            count.told(Tick(tick), RUNNING);
        });
        count
    }

    #[test]
    fn a_jump_that_is_told_only_once_changes_nothing() {
        for wrong in [Tick(0), Tick(6), Tick(9), Tick(10), Tick(1 << 16), Tick(1 << 31), Tick(u32::MAX)] {
            for told in [RUNNING, STEPPED, Clock { begins: false, ..STEPPED }] {
                let mut count = running();
                assert_eq!(count.told(wrong, told), Begin::Refused(wrong));
                assert_eq!(count.next(), Some(Tick(8)), "{wrong:?}");
                assert_eq!(count.period_over(), Begin::Next, "it does not wait either: {wrong:?}");
                assert_eq!(count.told(Tick(9), RUNNING), Begin::Next);
                // Nor do more of them, with the right time in between.
                for cycle in 1..6 {
                    let wrong = wrong + 100 + cycle;
                    assert_eq!(count.told(wrong, told), Begin::Refused(wrong));
                    assert_eq!(count.told(Tick(9) + cycle, RUNNING), Begin::Next);
                }
            }
        }
    }

    #[test]
    fn a_new_time_that_three_frames_in_a_row_tell_is_taken() {
        for from in [Tick(0), Tick(10), Tick(u32::MAX - 1)] {
            let mut count = running();
            assert_eq!(count.told(from, RUNNING), Begin::Refused(from));
            // The node's own cycle, by its timer.
            count.period_over();
            assert_eq!(count.told(from + 1, RUNNING), Begin::Refused(from + 1));
            assert_eq!(count.told(from + 2, RUNNING), Begin::Anew(from + 2));
            assert_eq!(count.told(from + 3, RUNNING), Begin::Next);
        }
    }

    #[test]
    fn jumps_that_do_not_count_on_are_never_taken() {
        let mut count = running();
        for wrong in [30, 30, 30, 40, 41, 43, 44, 46, 46] {
            assert_eq!(count.told(Tick(wrong), RUNNING), Begin::Refused(Tick(wrong)), "{wrong}");
        }
        assert_eq!(count.told(Tick(8), RUNNING), Begin::Next);
    }

    #[test]
    fn a_first_time_that_was_wrong_is_put_right_by_three_frames() {
        let mut count = Count::default();
        assert_eq!(count.told(Tick(1000), RUNNING), Begin::Anew(Tick(1000)));
        let begins = [7, 8, 9, 10].map(|tick| count.told(Tick(tick), RUNNING));
        assert_eq!(
            begins,
            [Begin::Refused(Tick(7)), Begin::Refused(Tick(8)), Begin::Anew(Tick(9)), Begin::Next]
        );
    }

    #[test]
    fn a_new_time_may_also_be_told_as_what_comes_next() {
        let mut count = running();
        let next = Clock { begins: false, ..STEPPED };
        assert_eq!(count.told(Tick(30), next), Begin::Refused(Tick(30)));
        assert_eq!(count.told(Tick(30), STEPPED), Begin::Refused(Tick(30)));
        assert_eq!(count.told(Tick(31), next), Begin::Refused(Tick(31)));
        assert_eq!(count.told(Tick(32), next), Begin::Align(Tick(32)));
        assert_eq!(count.told(Tick(32), STEPPED), Begin::Next);
    }

    #[test]
    fn a_node_that_is_told_what_comes_next_waits_for_it_to_begin() {
        let mut count = Count::default();
        assert_eq!(count.told(Tick(7), Clock { begins: false, ..STEPPED }), Begin::Align(Tick(7)));
        assert_eq!(count.told(Tick(7), Clock { begins: false, ..STEPPED }), Begin::Nothing);
        assert_eq!(count.told(Tick(7), STEPPED), Begin::Next);
    }

    #[test]
    fn a_node_that_is_to_wait_ignores_its_timer() {
        let mut count = Count::default();
        count.told(Tick(7), STEPPED);
        assert_eq!(count.period_over(), Begin::Nothing);
        assert_eq!(count.told(Tick(8), STEPPED), Begin::Next);
    }
}
