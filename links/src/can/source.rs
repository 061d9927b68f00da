//! [`Source`]: messages that nodes send by themselves, and when.

use super::{
    errors::exponential,
    frame::{Attempts, Format, Frame, PayloadError},
    id::Id,
    time::Time,
};
use rand::{Rng, RngCore};
use rand_chacha::ChaCha8Rng;

/// Index of a node on the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub u16);

/// A message that a node sends again and again, with random bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Who sends it.
    pub node: NodeId,
    /// Its identifier.
    pub id: Id,
    /// Its format.
    pub format: Format,
    /// Its payload, in bytes.
    pub bytes: usize,
    /// When it is sent.
    pub pattern: Pattern,
    /// How often each frame is tried.
    pub attempts: Attempts,
}

/// When a source hands frames to its node. Times in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pattern {
    /// At `offset + k period` plus a delay that is uniform in 0 to `jitter`.
    Periodic {
        /// From one to the next, positive.
        period: Time,
        /// The first one.
        offset: Time,
        /// At most `period`.
        jitter: Time,
    },
    /// At least `minimum` after the one before, and on average `extra` more (exponentially distributed).
    Sporadic {
        /// Least time between two, and before the first.
        minimum: Time,
        /// Mean of the rest.
        extra: Time,
    },
}

/// A source whose frames cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SourceError {
    /// Its payload.
    #[error(transparent)]
    Payload(#[from] PayloadError),
    /// Frames without any time between them.
    #[error(
        "found a source without time between its frames: period, or minimum plus extra, must be positive"
    )]
    NoTimeBetween,
    /// Frames could overtake each other.
    #[error("found a jitter of {jitter} ns at a period of {period} ns: it must be at most the period")]
    Jitter {
        /// In nanoseconds.
        jitter: Time,
        /// In nanoseconds.
        period: Time,
    },
}

impl Source {
    pub(super) fn check(&self) -> Result<(), SourceError> {
        self.format.dlc(self.bytes)?;
        match self.pattern {
            Pattern::Periodic { period: 0, .. } | Pattern::Sporadic { minimum: 0, extra: 0 } => {
                Err(SourceError::NoTimeBetween)
            }
            Pattern::Periodic { period, jitter, .. } if jitter > period => {
                Err(SourceError::Jitter { jitter, period })
            }
            _ => Ok(()),
        }
    }
}

/// A source at work.
#[derive(Debug, Clone)]
pub(super) struct Releases {
    pub(super) source: Source,
    /// When the next frame was due: without jitter.
    due: Time,
    random: ChaCha8Rng,
}

impl Releases {
    /// With the time of the first frame.
    pub(super) fn new(source: Source, random: ChaCha8Rng) -> (Self, Time) {
        let mut releases = Releases { source, due: 0, random };
        let first = match releases.source.pattern {
            Pattern::Periodic { offset, .. } => releases.periodic(offset),
            Pattern::Sporadic { .. } => releases.next(),
        };
        (releases, first)
    }

    /// When the frame that is released next was due.
    pub(super) fn due(&self) -> Time {
        self.due
    }

    /// Goes on to the frame after it, and says when that is released.
    pub(super) fn next(&mut self) -> Time {
        match self.source.pattern {
            Pattern::Periodic { period, .. } => self.periodic(self.due.saturating_add(period)),
            Pattern::Sporadic { minimum, extra } => {
                let extra = exponential(&mut self.random) * extra as f64;
                self.due = self.due.saturating_add(minimum.saturating_add(extra as Time).max(1));
                self.due
            }
        }
    }

    fn periodic(&mut self, due: Time) -> Time {
        self.due = due;
        match self.source.pattern {
            Pattern::Periodic { jitter, .. } if jitter > 0 => {
                due.saturating_add(self.random.random_range(0..=jitter))
            }
            _ => due,
        }
    }

    /// A frame with random bytes.
    pub(super) fn frame(&mut self) -> Frame {
        let mut bytes = [0; super::frame::LARGEST_PAYLOAD];
        let bytes = &mut bytes[..self.source.bytes];
        self.random.fill_bytes(bytes);
        let frame = Frame::new(self.source.id, self.source.format, bytes);
        frame.unwrap_or_else(|_| unreachable!("checked at construction")).with_attempts(self.source.attempts)
    }
}
