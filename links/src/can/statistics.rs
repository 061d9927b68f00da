//! [`Statistics`]: what the bus was busy with, and what became of the frames of each message. Not how it was decided.

use super::{
    event::{Fate, Origin},
    id::Id,
    source::NodeId,
    time::Time,
};
use std::fmt;

/// Figures of a run so far, of frames that have ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Statistics {
    /// Since the start, in nanoseconds.
    pub time: Time,
    /// Time of disturbed frames, with error flag, delimiter and intermission, in nanoseconds.
    pub error_time: Time,
    /// Disturbed frames, those disturbed in the last bit included.
    pub error_frames: u64,
    /// How often a node went bus-off.
    pub bus_offs: u64,
    /// One row for each source, then one for each identifier that was offered.
    pub messages: Vec<Message>,
}

/// What became of the frames of one source, or of one identifier that the caller offers.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// Index of the source; none for frames of the caller.
    pub source: Option<usize>,
    /// Identifier.
    pub id: Id,
    /// Who sends it.
    pub node: NodeId,
    /// Frames handed to the node.
    pub offered: u64,
    /// Frames the receivers have.
    pub delivered: u64,
    /// Frames for which the queue had no room.
    pub refused: u64,
    /// Frames given up after an error or a lost arbitration.
    pub aborted: u64,
    /// Frames the caller took back.
    pub withdrawn: u64,
    /// Deliveries after the first of the same frame.
    pub duplicates: u64,
    /// Attempts after the first of a frame that met an error.
    pub retransmissions: u64,
    /// Time of undisturbed frames, with intermission, in nanoseconds.
    pub busy: Time,
    /// From when a frame was due (the release without its jitter) to the end of its EOF.
    pub response: Response,
}

/// Shortest, mean and longest of some times.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Response {
    count: u64,
    sum: u128,
    extremes: Option<(Time, Time)>,
}

impl Response {
    fn add(&mut self, time: Time) {
        self.count += 1;
        self.sum += u128::from(time);
        self.extremes = Some(match self.extremes {
            None => (time, time),
            Some((least, most)) => (least.min(time), most.max(time)),
        });
    }

    /// Shortest, in nanoseconds; none if there was nothing.
    pub fn min(&self) -> Option<Time> {
        self.extremes.map(|(least, _)| least)
    }

    /// Longest, in nanoseconds.
    pub fn max(&self) -> Option<Time> {
        self.extremes.map(|(_, most)| most)
    }

    /// Mean, in nanoseconds.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum as f64 / self.count as f64)
    }
}

impl Message {
    pub(super) fn new(source: Option<usize>, id: Id, node: NodeId) -> Self {
        Message {
            source,
            id,
            node,
            offered: 0,
            delivered: 0,
            refused: 0,
            aborted: 0,
            withdrawn: 0,
            duplicates: 0,
            retransmissions: 0,
            busy: 0,
            response: Response::default(),
        }
    }

    pub(super) fn count(&mut self, fate: Fate, response: Time) {
        match fate {
            Fate::Delivered => {
                self.delivered += 1;
                self.response.add(response);
            }
            Fate::Refused => self.refused += 1,
            Fate::Aborted => self.aborted += 1,
            Fate::Withdrawn => self.withdrawn += 1,
        }
    }

    /// Frames whose fate is open: they wait, or are on the bus.
    pub fn undecided(&self) -> u64 {
        self.offered - self.delivered - self.refused - self.aborted - self.withdrawn
    }
}

impl Statistics {
    /// Part of the time in which the bus was busy with frames, intermissions included, or errors.
    pub fn load(&self) -> f64 {
        let frames: Time = self.messages.iter().map(|message| message.busy).sum();
        (frames + self.error_time) as f64 / self.time as f64
    }

    /// The row of a frame of this origin and identifier.
    pub fn message(&self, origin: Origin, id: Id) -> Option<&Message> {
        let source = match origin {
            Origin::Source(index) => Some(index),
            Origin::Offered(_) => None,
        };
        self.messages.iter().find(|message| message.source == source && message.id == id)
    }
}

impl fmt::Display for Statistics {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |time: Time| 100.0 * time as f64 / self.time as f64;
        writeln!(
            out,
            "{:.6} s, load {:.2} %, of which errors {:.2} % ({} error frames, {} times bus-off)",
            self.time as f64 * 1e-9,
            100.0 * self.load(),
            percent(self.error_time),
            self.error_frames,
            self.bus_offs
        )?;
        writeln!(
            out,
            "{:>9} {:>4} {:>8} {:>9} {:>9} {:>7} {:>7} {:>9} {:>10} {:>7} {:>24}",
            "id",
            "node",
            "load %",
            "offered",
            "delivered",
            "refused",
            "aborted",
            "withdrawn",
            "duplicates",
            "repeats",
            "response min/mean/max us"
        )?;
        for row in &self.messages {
            let micro = |time: Option<f64>| time.map_or("-".into(), |time| format!("{:.1}", time * 1e-3));
            let response = [
                row.response.min().map(|t| t as f64),
                row.response.mean(),
                row.response.max().map(|t| t as f64),
            ];
            writeln!(
                out,
                "{:>9} {:>4} {:>8.3} {:>9} {:>9} {:>7} {:>7} {:>9} {:>10} {:>7} {:>24}",
                row.id,
                row.node.0,
                percent(row.busy),
                row.offered,
                row.delivered,
                row.refused,
                row.aborted,
                row.withdrawn,
                row.duplicates,
                row.retransmissions,
                response.map(micro).join("/")
            )?;
        }
        Ok(())
    }
}
