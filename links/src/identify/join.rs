//! Numbered sightings of both ends become packets, in a window that goes along with the sender's numbers.

use super::{
    column::Column,
    counters::rounds::{Numbered, Rounds},
    packets::Packets,
    time::Nanoseconds,
};
use std::{
    cmp::Reverse,
    collections::{BinaryHeap, VecDeque},
};

/// Numbers in the window: no packet is overtaken by more.
const WINDOW: u64 = 1 << 16;
/// Arrivals that are read ahead of the window before it has to go on.
const AHEAD: usize = 1 << 10;
/// Stands for: not seen.
const NEVER: Nanoseconds = i64::MIN;

/// Packets, and what was odd.
#[derive(Debug, Default)]
pub(super) struct Joined {
    pub(super) packets: Packets,
    pub(super) duplicates: u64,
    pub(super) strays: u64,
    pub(super) arrived: u64,
    /// Packets that arrive before they are sent, and the first of them.
    pub(super) early: u64,
    pub(super) first_early: Option<(u64, Nanoseconds)>,
    /// Shortest and longest time between sending and arrival.
    pub(super) delays: Option<(Nanoseconds, Nanoseconds)>,
}

#[derive(Clone, Copy)]
struct Slot {
    sent: Nanoseconds,
    received: Nanoseconds,
}

/// A packet seen at the receiver.
struct Arrival {
    number: u64,
    time: Nanoseconds,
}

struct Window {
    base: u64,
    highest: u64,
    slots: VecDeque<Slot>,
    /// Arrivals whose numbers the window has not come to.
    ahead: BinaryHeap<Reverse<(u64, Nanoseconds)>>,
    joined: Joined,
}

/// Joins what was seen at both ends, each in the order of time. Of several sightings of a number at one end the first counts.
/// `highest` is the largest number of the sender.
pub(super) fn join(sent: &Column, received: Column, rounds: &Rounds, highest: u64) -> Joined {
    let mut senders = rounds.sent(sent.iter()).peekable();
    let Some(first) = senders.peek().map(|first| first.number) else {
        return Joined { strays: received.len, ..Joined::default() };
    };
    let middle = rounds.middle(first, highest);
    let mut newest = first;
    let mut arrivals = received.drain().map(|sighting| {
        let near = middle.unwrap_or_else(|| {
            // The newest number that the sender had sent by then.
            while let Some(sender) = senders.next_if(|sender| sender.time <= sighting.time) {
                newest = newest.max(sender.number);
            }
            newest
        });
        Arrival { number: rounds.received(sighting.number, near), time: sighting.time }
    });
    let mut window = Window {
        base: first - WINDOW / 4,
        highest,
        slots: VecDeque::new(),
        ahead: BinaryHeap::new(),
        joined: Joined::default(),
    };
    window.feed(&mut arrivals);
    for sender in rounds.sent(sent.iter()) {
        if sender.number >= window.base + WINDOW {
            window.advance(sender.number - WINDOW / 2);
            window.feed(&mut arrivals);
        }
        window.sent(sender);
    }
    // What is left arrived within the window, or the sender never sent it.
    while let Some(Reverse((number, time))) = window.ahead.pop() {
        window.arrived(Arrival { number, time }, false);
    }
    arrivals.for_each(|arrival| window.arrived(arrival, false));
    window.advance(u64::MAX);
    window.joined
}

impl Window {
    /// Reads arrivals until enough are ahead of the window.
    fn feed(&mut self, arrivals: &mut impl Iterator<Item = Arrival>) {
        while let Some(&Reverse((number, time))) = self.ahead.peek() {
            if number >= self.base + WINDOW {
                break;
            }
            self.ahead.pop();
            self.arrived(Arrival { number, time }, true);
        }
        while self.ahead.len() < AHEAD {
            let Some(arrival) = arrivals.next() else { return };
            self.arrived(arrival, true);
        }
    }

    fn arrived(&mut self, arrival: Arrival, may_wait: bool) {
        // What the sender never comes to need not wait.
        let is_ahead = arrival.number >= self.base.saturating_add(WINDOW) && arrival.number <= self.highest;
        if is_ahead && may_wait {
            self.ahead.push(Reverse((arrival.number, arrival.time)));
            return;
        }
        let Some(slot) = self.slot(arrival.number) else {
            self.joined.strays += 1;
            return;
        };
        let is_again = slot.received != NEVER;
        slot.received = if is_again { slot.received.min(arrival.time) } else { arrival.time };
        self.joined.duplicates += u64::from(is_again);
    }

    fn sent(&mut self, sender: Numbered) {
        match self.slot(sender.number) {
            Some(slot) if slot.sent == NEVER => slot.sent = sender.time,
            _ => self.joined.duplicates += 1,
        }
    }

    fn slot(&mut self, number: u64) -> Option<&mut Slot> {
        let at = number.checked_sub(self.base).filter(|at| *at < WINDOW)? as usize;
        if at >= self.slots.len() {
            self.slots.resize(at + 1, Slot { sent: NEVER, received: NEVER });
        }
        self.slots.get_mut(at)
    }

    /// Lets the window begin at `base`; what is before it is decided.
    fn advance(&mut self, base: u64) {
        while self.base < base {
            let Some(slot) = self.slots.pop_front() else {
                self.base = base;
                return;
            };
            let number = self.base;
            self.base += 1;
            match (slot.sent, slot.received) {
                (NEVER, NEVER) => {}
                (NEVER, _) => self.joined.strays += 1,
                (sent, NEVER) => self.joined.packets.push(number, sent, None),
                (sent, received) => self.joined.arrived(number, sent, received),
            }
        }
    }
}

impl Joined {
    pub(super) fn arrived(&mut self, number: u64, sent: Nanoseconds, received: Nanoseconds) {
        let delay = received - sent;
        self.arrived += 1;
        if delay < 0 {
            self.early += 1;
            self.first_early.get_or_insert((number, -delay));
        }
        let (shortest, longest) = self.delays.unwrap_or((delay, delay));
        self.delays = Some((shortest.min(delay), longest.max(delay)));
        self.packets.push(number, sent, Some(received));
    }
}
