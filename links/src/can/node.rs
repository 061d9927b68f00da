//! A node: its transmit queue and its error counters (ISO 11898-1:2015, fault confinement). Not the bus between nodes.

use super::{event::Origin, frame::Attempts, length::Length, time::Time};

/// Above this, by either counter, a node is error-passive.
const ACTIVE_LIMIT: u16 = 127;
/// Above this, by the transmit counter, a node is bus-off.
const ON_LIMIT: u16 = 255;
/// What an error adds to the transmit counter.
const TRANSMIT_PENALTY: u16 = 8;
/// The receive counter after a good frame if it was above the limit; the standard allows 119 to 127.
const RELIEVED: u16 = 119;
/// Sequences of 11 recessive bits before a node returns from bus-off.
pub(super) const RECOVERY_SEQUENCES: u64 = 128;

/// A frame in a queue.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    /// Identifier as arbitration sees it, then order of arrival.
    pub(super) urgency: (u32, u64),
    pub(super) origin: Origin,
    /// Row of the statistics it counts in.
    pub(super) row: usize,
    pub(super) length: Length,
    pub(super) attempts: Attempts,
    /// When it was due: the start of its response time.
    pub(super) due: Time,
    /// Attempts so far, the running one included.
    pub(super) tries: u32,
    /// Whether the receivers have it already.
    pub(super) delivered: bool,
}

/// A node on the bus.
#[derive(Debug, Clone)]
pub(super) struct Node {
    /// Least urgent first.
    queue: Vec<Entry>,
    capacity: usize,
    /// Transmit error counter, TEC.
    transmit_errors: u16,
    /// Receive error counter, REC.
    receive_errors: u16,
    /// Sequences of 11 recessive bits still to see, in bus-off.
    pub(super) off: Option<u64>,
    /// End of the suspended transmission of an error-passive sender.
    pub(super) suspended_until: Time,
}

impl Node {
    pub(super) fn new(capacity: usize) -> Self {
        Node {
            queue: Vec::new(),
            capacity,
            transmit_errors: 0,
            receive_errors: 0,
            off: None,
            suspended_until: 0,
        }
    }

    /// Takes a frame in, unless the queue is full; `sending` says that one more frame is on the bus.
    pub(super) fn accept(&mut self, entry: Entry, sending: bool) -> Result<(), Entry> {
        if self.queue.len() + usize::from(sending) >= self.capacity {
            return Err(entry);
        }
        self.put_back(entry);
        Ok(())
    }

    /// Puts a frame in its place, which it had before.
    pub(super) fn put_back(&mut self, entry: Entry) {
        let place = self.queue.partition_point(|other| other.urgency > entry.urgency);
        self.queue.insert(place, entry);
    }

    /// The frame that goes next.
    pub(super) fn head(&self) -> Option<&Entry> {
        self.queue.last()
    }

    /// Takes the frame that goes next.
    pub(super) fn take(&mut self) -> Option<Entry> {
        self.queue.pop()
    }

    /// Takes a certain frame out.
    pub(super) fn remove(&mut self, origin: Origin) -> Option<Entry> {
        let place = self.queue.iter().position(|entry| entry.origin == origin)?;
        Some(self.queue.remove(place))
    }

    /// From when on it competes for the bus; none if it has nothing to send or is off.
    pub(super) fn ready(&self) -> Option<Time> {
        (self.off.is_none() && !self.queue.is_empty()).then_some(self.suspended_until)
    }

    pub(super) fn is_passive(&self) -> bool {
        self.transmit_errors > ACTIVE_LIMIT || self.receive_errors > ACTIVE_LIMIT
    }

    pub(super) fn counters(&self) -> (u16, u16) {
        (self.transmit_errors, self.receive_errors)
    }

    pub(super) fn sent(&mut self) {
        self.transmit_errors = self.transmit_errors.saturating_sub(1);
    }

    pub(super) fn received(&mut self) {
        self.receive_errors = match self.receive_errors {
            above if above > ACTIVE_LIMIT => RELIEVED,
            counter => counter.saturating_sub(1),
        };
    }

    /// True if this takes it off the bus.
    pub(super) fn failed_to_send(&mut self) -> bool {
        self.transmit_errors += TRANSMIT_PENALTY;
        let off = self.transmit_errors > ON_LIMIT;
        if off {
            self.off = Some(RECOVERY_SEQUENCES);
        }
        off
    }

    pub(super) fn failed_to_receive(&mut self) {
        // The counter has 8 bits; nothing depends on values beyond.
        self.receive_errors = (self.receive_errors + 1).min(ON_LIMIT);
    }

    pub(super) fn recover(&mut self) {
        self.off = None;
        self.transmit_errors = 0;
        self.receive_errors = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_good_frame_makes_a_passive_receiver_active_again() {
        let mut node = Node::new(1);
        (0..127).for_each(|_| node.failed_to_receive());
        assert!(!node.is_passive());
        (0..200).for_each(|_| node.failed_to_receive());
        assert!(node.is_passive() && node.off.is_none(), "receive errors never lead to bus-off");
        node.received();
        assert_eq!((node.counters(), node.is_passive()), ((0, 119), false));
        node.received();
        assert_eq!(node.counters(), (0, 118));
    }
}
