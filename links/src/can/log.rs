//! [`Log`]: every frame with its fate, as a table.

use super::{
    event::{Fate, Origin},
    id::Id,
    source::NodeId,
    time::Time,
};
use std::fmt;

/// Frames in the order in which their fates were decided.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Log {
    /// One per frame.
    pub records: Vec<Record>,
}

/// One frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// Whose.
    pub origin: Origin,
    /// Identifier.
    pub id: Id,
    /// Who sent it.
    pub node: NodeId,
    /// When it was due, in nanoseconds.
    pub due: Time,
    /// When its fate was decided, in nanoseconds.
    pub decided: Time,
    /// Attempts until then.
    pub tries: u32,
    /// What became of it.
    pub fate: Fate,
}

impl fmt::Display for Log {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            out,
            "{:>16} {:>16} {:>4} {:>9} {:>5} {:9} origin",
            "due s", "decided s", "node", "id", "tries", "fate"
        )?;
        for record in &self.records {
            let seconds = |time: Time| time as f64 * 1e-9;
            write!(
                out,
                "{:>16.9} {:>16.9} {:>4} {:>9} {:>5} {:9} ",
                seconds(record.due),
                seconds(record.decided),
                record.node.0,
                record.id,
                record.tries,
                record.fate
            )?;
            match record.origin {
                Origin::Offered(tag) => writeln!(out, "tag {tag}")?,
                Origin::Source(index) => writeln!(out, "source {index}")?,
            }
        }
        Ok(())
    }
}
