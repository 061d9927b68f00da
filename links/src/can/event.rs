//! [`Event`]: what the bus tells while it runs.

use super::{source::NodeId, time::Time};
use std::fmt;

/// Whose frame it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Origin {
    /// Offered by the caller, with this tag.
    Offered(u64),
    /// Of the source with this index in the settings.
    Source(usize),
}

/// What becomes of a frame. Each frame has exactly one fate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Fate {
    /// The receivers have it.
    Delivered,
    /// The queue of its node was full.
    Refused,
    /// Given up after an error or a lost arbitration, because it is not tried again.
    Aborted,
    /// Taken out of its queue by the caller.
    Withdrawn,
}

/// Something that happened on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event {
    /// When, in nanoseconds.
    pub at: Time,
    /// What.
    pub what: What,
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// The fate of a frame is decided.
    Fate {
        /// Whose frame.
        origin: Origin,
        /// What became of it.
        fate: Fate,
    },
    /// The receivers have a frame once more that was `Delivered` before: its sender saw an error in the last bit.
    Duplicate {
        /// Whose frame.
        origin: Origin,
    },
    /// A node counted too many errors and left the bus.
    BusOff {
        /// Which.
        node: NodeId,
    },
    /// A node takes part again.
    Recovered {
        /// Which.
        node: NodeId,
    },
}

impl fmt::Display for Fate {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.pad(match self {
            Fate::Delivered => "delivered",
            Fate::Refused => "refused",
            Fate::Aborted => "aborted",
            Fate::Withdrawn => "withdrawn",
        })
    }
}
