//! [`Trace`]: the packets of one log in the order sent. Formats are read elsewhere.

pub use super::packets::Packet;
use super::{about::About, packets::Packets, time::Nanoseconds};
use std::path::{Path, PathBuf};

/// The packets of one log, each once and in the order sent.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trace {
    packets: Packets,
    /// A packet without arrival counts as lost only if it was sent within this time.
    decidable: Option<(Nanoseconds, Nanoseconds)>,
    /// Numbers that are missing in the sequence.
    pub missing: u64,
    /// Whether the missing ones are among the packets as lost.
    pub missing_are_lost: bool,
    /// Packets that were seen again; only the first arrival counts.
    pub duplicates: u64,
    /// Packets received of which the sender knows nothing; not counted.
    pub strays: u64,
    /// Packets sent before the receiver's log began or too close to its end to tell whether they are lost; not counted.
    pub undecided: u64,
    /// Where the packets come from.
    pub about: About,
}

/// What is wrong with a log, where, and how to mend it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TraceError {
    /// A line that cannot be read.
    #[error("{}:{line}: {problem}", file.display())]
    Line {
        /// The log.
        file: PathBuf,
        /// Counted from 1.
        line: u64,
        /// What was found, and what is allowed.
        problem: String,
    },
    /// A file as a whole.
    #[error("{}: {problem}", file.display())]
    File {
        /// The log.
        file: PathBuf,
        /// What was found, and what is allowed.
        problem: String,
    },
    /// All logs together, or the options.
    #[error("{0}")]
    Whole(String),
}

impl TraceError {
    pub(super) fn line(file: &Path, line: u64, problem: impl Into<String>) -> Self {
        Self::Line { file: file.into(), line, problem: problem.into() }
    }

    pub(super) fn file(file: &Path, problem: impl Into<String>) -> Self {
        Self::File { file: file.into(), problem: problem.into() }
    }
}

/// What numbers missing in a sequence mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gaps {
    /// A packet was sent and lost.
    Lost,
    /// Nothing was sent, or it was not logged.
    Ignore,
}

impl Trace {
    /// Of packets with ascending numbers. Those without arrival count as lost only if sent within `decidable`. Numbers that
    /// are missing between the others are lost packets if `gaps` says so.
    ///
    /// # Errors
    /// More numbers missing than ten times the packets there are, which is a restart or another counter.
    pub(super) fn of(
        packets: Packets,
        decidable: Option<(Nanoseconds, Nanoseconds)>,
        gaps: Gaps,
    ) -> Result<Self, String> {
        let mut trace = Self { packets, decidable, ..Self::default() };
        let (mut before, mut count, mut missing) = (None, 0_u64, 0_u64);
        for packet in trace.logged() {
            let step = before.map_or(0, |before| packet.sequence.saturating_sub(before).saturating_sub(1));
            missing = missing.saturating_add(step);
            before = Some(packet.sequence);
            count += 1;
        }
        trace.missing = missing;
        trace.undecided = trace.packets.len - count;
        trace.missing_are_lost = gaps == Gaps::Lost && trace.missing > 0;
        if trace.missing_are_lost && trace.missing > 10 * count {
            return Err(format!(
                "{} numbers are missing in a sequence of {count} packets: did the sender restart? give one file per run, \
                 or --gaps ignore if the sender does not send in every cycle",
                trace.missing
            ));
        }
        Ok(trace)
    }

    /// How many packets were logged, decided or not.
    pub(super) fn logged_packets(&self) -> u64 {
        self.packets.len
    }

    fn logged(&self) -> impl Iterator<Item = Packet> + '_ {
        let packets = self.packets.iter();
        packets.filter_map(move |(sequence, sent, received)| {
            let decided = self.decidable.is_none_or(|(from, to)| (from..=to).contains(&sent));
            (received.is_some() || decided).then_some(Packet { sequence, sent: Some(sent), received })
        })
    }

    /// The packets in the order sent.
    pub fn packets(&self) -> impl Iterator<Item = Packet> + '_ {
        let mut logged = self.logged().peekable();
        let mut next = logged.peek().map_or(0, |first| first.sequence);
        std::iter::from_fn(move || {
            let packet = logged.peek()?;
            if self.missing_are_lost && packet.sequence > next {
                next += 1;
                return Some(Packet { sequence: next - 1, sent: None, received: None });
            }
            next = packet.sequence.saturating_add(1);
            logged.next()
        })
    }
}
