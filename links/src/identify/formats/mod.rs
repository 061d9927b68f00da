//! The formats of logs: which there are, how they are recognised, and a reader for each.
//!
//! | room | what lives there |
//! |---|---|
//! | [`recognise`] | which format a log is in, by its content |
//! | [`message`] | what readers of frames and packets hand on |
//! | `words` | words, numbers and data in lines |
//! | `candump`, `candump_view`, `asc`, `trc`, `python_can` | CAN frames as lines |
//! | `blf` | CAN frames in Vector's binary containers |
//! | `capture`, `packet` | pcap and pcapng, and what is in a captured packet |
//! | `table`, `columns`, `wraps` | a table with a row per packet, its columns, and its numbers |
//! | `irtt`, `owping`, `round_trips` | tools that measure a link |

pub(super) mod asc;
pub(super) mod blf;
pub(super) mod candump;
pub(super) mod candump_view;
pub(super) mod capture;
mod columns;
pub(super) mod irtt;
pub mod message;
pub(super) mod owping;
mod packet;
pub(super) mod python_can;
pub mod recognise;
pub(super) mod round_trips;
pub(super) mod table;
pub(super) mod trc;
mod words;
mod wraps;

use super::{about::Skip, collector::Collector, source::Source, trace::TraceError};
use std::path::Path;

/// What reads a log line by line.
pub(super) trait Lines {
    /// Reads a line and hands on what is in it.
    ///
    /// Errors: what is wrong with the line, without its number.
    fn line(&mut self, text: &[u8], collector: &mut Collector<'_>) -> Result<(), String>;
}

/// Reads a log of lines. The last line may be cut off: a logger that is killed leaves that.
pub(super) fn read_lines(
    file: &Path,
    mut source: Source<'_>,
    mut format: impl Lines,
    collector: &mut Collector<'_>,
) -> Result<(), TraceError> {
    loop {
        let line = source.line().map_err(|error| unreadable(file, &error))?;
        let Some(line) = line else { return Ok(()) };
        if line.text.trim_ascii().is_empty() {
            continue;
        }
        if let Err(problem) = format.line(line.text, collector) {
            if line.is_whole {
                return Err(TraceError::line(file, line.number, problem));
            }
            collector.skip(Skip::Cut);
        }
        collector.decide_if_enough()?;
    }
}

/// A log whose bytes do not come.
pub(super) fn unreadable(file: &Path, error: &std::io::Error) -> TraceError {
    TraceError::file(file, format!("cannot read it: {error}"))
}
