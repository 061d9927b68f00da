//! How frames come into queues, and how their fates are told. What happens to them on the bus is `transmission`.

use super::{
    bus::Bus,
    event::{Event, Fate, Origin, What},
    frame::Frame,
    length::Length,
    log::Record,
    node::Entry,
    settings::Stuffing,
    source::NodeId,
    time::Time,
};
use std::cmp::Reverse;

impl Bus {
    /// A source hands its next frame to its node now.
    pub(super) fn release(&mut self) {
        let Some(Reverse((_, index))) = self.releases.pop() else { return };
        let source = &mut self.sources[index];
        let (node, due) = (source.source.node, source.due());
        let frame = source.frame();
        self.releases.push(Reverse((source.next(), index)));
        let entry = self.entry(&frame, Origin::Source(index), index, due);
        self.arrive(node, entry);
    }

    /// A frame as queues hold it.
    pub(super) fn entry(&mut self, frame: &Frame, origin: Origin, row: usize, due: Time) -> Entry {
        let length = match self.stuffing {
            Stuffing::Actual => Length::actual(frame),
            Stuffing::Worst => Length::worst(frame.id().is_extended(), frame.format(), frame.data().len())
                .unwrap_or_else(|_| unreachable!("a frame has a payload its format can carry")),
        };
        self.arrivals += 1;
        Entry {
            urgency: (frame.id().priority(), self.arrivals),
            origin,
            row,
            length,
            attempts: frame.attempts(),
            due,
            tries: 0,
            delivered: false,
        }
    }

    /// A frame reaches the queue of its node now.
    pub(super) fn arrive(&mut self, node: NodeId, entry: Entry) {
        self.statistics.messages[entry.row].offered += 1;
        let index = usize::from(node.0);
        let sending = self.sending.as_ref().is_some_and(|frame| frame.node == index);
        if let Err(entry) = self.nodes[index].accept(entry, sending) {
            self.decide(&entry, Fate::Refused);
        }
    }

    /// Decides the fate of a frame, and tells of it.
    pub(super) fn decide(&mut self, entry: &Entry, fate: Fate) {
        self.record(entry, fate);
        self.tell(What::Fate { origin: entry.origin, fate });
    }

    /// An event, now.
    pub(super) fn tell(&mut self, what: What) {
        self.events.push(Event { at: self.now, what });
    }

    /// Decides the fate of a frame without an event.
    pub(super) fn record(&mut self, entry: &Entry, fate: Fate) {
        let message = &mut self.statistics.messages[entry.row];
        message.count(fate, self.now.saturating_sub(entry.due));
        if let Some(log) = &mut self.log {
            log.records.push(Record {
                origin: entry.origin,
                id: message.id,
                node: message.node,
                due: entry.due,
                decided: self.now,
                tries: entry.tries,
                fate,
            });
        }
    }
}
