//! What a frame meets between arbitration and its end: errors, their counters, bus-off and the way back. Not queues.

use super::{
    bus::Bus,
    event::{Fate, What},
    frame::Attempts,
    node::Entry,
    settings::{Recovery, Stuffing},
    source::NodeId,
    time::{INTERMISSION, Time},
};

/// Error flag of one node, in bits.
const FLAG: u32 = 6;
/// Most that flags of other nodes lengthen it, in bits.
const LONGEST_ECHO: u32 = 6;
/// Error delimiter, in bits.
const DELIMITER: u32 = 8;
/// Wait of an error-passive sender after the intermission, in bits.
const SUSPENSION: u32 = 8;
/// Recessive bits that count as one sequence for the way back from bus-off.
const SEQUENCE: u32 = 11;

/// A frame on the bus.
#[derive(Debug, Clone)]
pub(super) struct Transmission {
    pub(super) node: usize,
    entry: Entry,
    start: Time,
    /// End of EOF, or of the disturbed bit.
    pub(super) end: Time,
    /// The disturbed bit.
    error: Option<u32>,
}

/// Confinement state of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Confinement {
    /// Both counters are at most 127.
    Active,
    /// A counter is above 127: recessive error flags, and a wait after each frame sent.
    Passive,
    /// The transmit counter went above 255: takes no part in the bus.
    Off,
}

impl Bus {
    /// Confinement state of a node, with its transmit and receive error counters; none if there is no such node.
    pub fn confinement(&self, node: NodeId) -> Option<(Confinement, u16, u16)> {
        let node = self.nodes.get(usize::from(node.0))?;
        let (transmit, receive) = node.counters();
        let state = match (node.off, node.is_passive()) {
            (Some(_), _) => Confinement::Off,
            (None, true) => Confinement::Passive,
            (None, false) => Confinement::Active,
        };
        Some((state, transmit, receive))
    }

    /// When the next frame begins, as far as known now.
    pub(super) fn next_arbitration(&self) -> Option<Time> {
        if self.sending.is_some() {
            return None;
        }
        let earliest = self.nodes.iter().filter_map(|node| node.ready()).min()?;
        Some(earliest.max(self.free).max(self.now))
    }

    /// The most urgent frame of all nodes that are ready begins now.
    pub(super) fn arbitrate(&mut self) {
        let start = self.now;
        let ready = |index: &usize| self.nodes[*index].ready().is_some_and(|since| since <= start);
        let urgency = |index: &usize| self.nodes[*index].head().map(|entry| entry.urgency);
        let Some(winner) = (0..self.nodes.len()).filter(ready).min_by_key(urgency) else { return };
        for loser in (0..self.nodes.len()).filter(|&index| index != winner) {
            let node = &mut self.nodes[loser];
            let competes = node.ready().is_some_and(|since| since <= start);
            if competes
                && node.head().is_some_and(|entry| entry.attempts == Attempts::Once)
                && let Some(entry) = node.take()
            {
                self.decide(&Entry { tries: entry.tries + 1, ..entry }, Fate::Aborted);
            }
        }
        let Some(mut entry) = self.nodes[winner].take() else { return };
        if entry.tries > 0 {
            self.statistics.messages[entry.row].retransmissions += 1;
        }
        entry.tries += 1;
        if self.off > 0 {
            let seen = (start - self.free) / self.rates.bits(SEQUENCE);
            self.count_recessive(seen);
        }
        let error = self.errors.first(start, entry.length, self.rates);
        let bits = error.map_or(entry.length.bits(), |bit| bit + 1);
        let end = start + entry.length.offset(bits, self.rates);
        self.sending = Some(Transmission { node: winner, entry, start, end, error });
    }

    /// The frame on the bus ends now, or its disturbed bit does.
    pub(super) fn complete(&mut self) {
        let Some(Transmission { node, mut entry, start, end, error }) = self.sending.take() else { return };
        let received = error.is_none_or(|bit| bit + 1 == entry.length.bits());
        let mut rest = INTERMISSION;
        if error.is_some() {
            let echo = match self.stuffing {
                Stuffing::Actual => self.errors.echo(),
                Stuffing::Worst => LONGEST_ECHO,
            };
            rest += FLAG + echo + DELIMITER;
        }
        self.free = end + self.rates.bits(rest);
        if received {
            self.deliver(&mut entry);
        }
        self.confine(node, error.is_some(), received);
        if error.is_none() {
            self.statistics.messages[entry.row].busy += self.free - start;
        } else {
            self.statistics.error_time += self.free - start;
            self.statistics.error_frames += 1;
            match entry.attempts {
                Attempts::Unlimited => self.nodes[node].put_back(entry),
                _ if !entry.delivered => self.decide(&entry, Fate::Aborted),
                _ => {}
            }
        }
        if self.nodes[node].is_passive() {
            self.nodes[node].suspended_until = self.free + self.rates.bits(SUSPENSION);
        }
        // Delimiter and intermission, of a good frame or of an error, are 11 recessive bits.
        self.count_recessive(1);
    }

    fn deliver(&mut self, entry: &mut Entry) {
        if entry.delivered {
            self.statistics.messages[entry.row].duplicates += 1;
            self.tell(What::Duplicate { origin: entry.origin });
        } else {
            entry.delivered = true;
            self.decide(entry, Fate::Delivered);
        }
    }

    /// Moves the error counters of all nodes after an attempt of `sender`.
    fn confine(&mut self, sender: usize, failed: bool, received: bool) {
        for (index, node) in self.nodes.iter_mut().enumerate() {
            if index == sender || node.off.is_some() {
                continue;
            }
            if received {
                node.received();
            } else {
                node.failed_to_receive();
            }
        }
        if !failed {
            self.nodes[sender].sent();
        } else if self.nodes[sender].failed_to_send() {
            self.off += 1;
            self.statistics.bus_offs += 1;
            self.tell(What::BusOff { node: NodeId(sender as u16) });
        }
    }

    /// Nodes in bus-off have seen so many sequences more.
    fn count_recessive(&mut self, sequences: u64) {
        if self.off > 0 {
            for left in self.nodes.iter_mut().filter_map(|node| node.off.as_mut()) {
                *left = left.saturating_sub(sequences);
            }
        }
    }

    /// When the next node returns if the bus stays idle.
    pub(super) fn next_recovery(&self) -> Option<Time> {
        if self.off == 0 || self.sending.is_some() || self.recovery == Recovery::Never {
            return None;
        }
        let left = self.nodes.iter().filter_map(|node| node.off).min()?;
        Some(self.free + left * self.rates.bits(SEQUENCE))
    }

    /// The nodes that have seen enough return now.
    pub(super) fn recover(&mut self) {
        let seen = (self.now - self.free) / self.rates.bits(SEQUENCE);
        for index in 0..self.nodes.len() {
            if self.nodes[index].off.is_some_and(|left| left <= seen) {
                self.nodes[index].recover();
                self.off -= 1;
                self.tell(What::Recovered { node: NodeId(index as u16) });
            }
        }
    }
}
