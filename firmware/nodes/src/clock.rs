//! Which cycle a node is in, and who begins the next one: the clock on the link, or the node's own timer.
//!
//! All nodes of a loop must count the same cycles. Whoever keeps the time sends a clock frame as each cycle begins. A node
//! that misses one goes on by its own timer, and one that has drifted, or has just started, takes the cycle that it is
//! told. What is done in a cycle is not known here.

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
    /// Nothing: it has begun this cycle by itself, or does not know the time.
    Nothing,
}

/// A node's count of cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Count {
    /// The cycle that comes next; `None` before the first clock frame.
    next: Option<Tick>,
    /// Whether it waits for the clock, however long that takes.
    waits: bool,
}

impl Count {
    /// A clock frame says that cycle `tick` begins, or comes next.
    pub fn told(&mut self, tick: Tick, clock: Clock) -> Begin {
        self.waits = clock.period_us == 0;
        match self.next {
            Some(next) if !clock.begins && next == tick => Begin::Nothing,
            _ if !clock.begins => {
                self.next = Some(tick);
                Begin::Align(tick)
            }
            Some(next) if next == tick => self.begin(tick, Begin::Next),
            // The node's timer was a little early.
            Some(next) if next == tick + 1 => Begin::Nothing,
            _ => self.begin(tick, Begin::Anew(tick)),
        }
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

    #[test]
    fn a_node_that_is_off_by_more_begins_anew() {
        let mut count = Count::default();
        count.told(Tick(7), RUNNING);
        assert_eq!(count.told(Tick(10), RUNNING), Begin::Anew(Tick(10)));
        assert_eq!(count.told(Tick(3), RUNNING), Begin::Anew(Tick(3)));
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
