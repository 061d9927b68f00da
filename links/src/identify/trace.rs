//! [`Trace`]: the packets of one log in the order sent. Formats are read elsewhere.

use super::time::{Nanoseconds, seconds};
use std::path::{Path, PathBuf};

/// One packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet {
    /// Its number.
    pub sequence: u64,
    /// When it was sent, in nanoseconds; unknown for one that only a gap tells of.
    pub sent: Option<i64>,
    /// When it arrived, in nanoseconds; never, if it was lost.
    pub received: Option<i64>,
}

/// The packets of one log, each once and in the order sent.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Trace {
    /// In the order sent.
    pub packets: Vec<Packet>,
    /// Numbers that are missing in the sequence.
    pub missing: u64,
    /// Whether the missing ones are in `packets` as lost.
    pub missing_are_lost: bool,
    /// Packets that were seen again; only the first arrival counts.
    pub duplicates: u64,
    /// Packets received of which the sender knows nothing; not counted.
    pub strays: u64,
    /// Packets sent before the receiver's log began or too close to its end to tell whether they are lost; not counted.
    pub undecided: u64,
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

/// Why a packet cannot have arrived before it was sent.
pub(super) fn early(sequence: u64, sent: Nanoseconds, received: Nanoseconds) -> Option<String> {
    (received < sent).then(|| {
        format!(
            "packet {sequence} arrives {:e} s before it is sent: the clocks of the two ends are not synchronised; \
             take both times from one clock, or synchronise the clocks (PTP, chrony) to a small part of a cycle and log again",
            seconds(sent - received)
        )
    })
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
    /// Counts numbers that are missing, and adds them as lost packets if `gaps` says so. Numbers must be ascending.
    ///
    /// # Errors
    /// More numbers missing than ten times the packets there are, which is a restart or another counter.
    pub(super) fn fill(&mut self, gaps: Gaps) -> Result<(), String> {
        let next_to = |pair: &[Packet]| pair[1].sequence.saturating_sub(pair[0].sequence + 1);
        self.missing = self.packets.windows(2).map(next_to).fold(0, u64::saturating_add);
        self.missing_are_lost = gaps == Gaps::Lost && self.missing > 0;
        if !self.missing_are_lost {
            return Ok(());
        }
        if self.missing > 10 * self.packets.len() as u64 {
            return Err(format!(
                "{} numbers are missing in a sequence of {} packets: did the sender restart? give one file per run, \
                 or --gaps ignore if the sender does not send in every cycle",
                self.missing,
                self.packets.len()
            ));
        }
        let mut filled: Vec<Packet> = Vec::with_capacity(self.packets.len() + self.missing as usize);
        for &packet in &self.packets {
            if let Some(before) = filled.last().map(|last| last.sequence) {
                let lost = |sequence| Packet { sequence, sent: None, received: None };
                filled.extend((before + 1..packet.sequence).map(lost));
            }
            filled.push(packet);
        }
        self.packets = filled;
        Ok(())
    }
}
