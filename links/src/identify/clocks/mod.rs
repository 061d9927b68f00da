//! The clocks of two ends: how far they are apart, and how fast they go.
//!
//! | room | what lives there |
//! |---|---|
//! | `Relation` | the receiver's clock as the sender's sees it |
//! | `envelope` | the smallest delays of a stretch of time, as a convex hull |
//! | `corridor` | the widest corridor between the delays of both ways |
//! | `two_way` | offset, drift and steps from packets that go both ways |

mod corridor;
mod envelope;
pub(super) mod two_way;

use super::time::{Nanoseconds, clamped, seconds};
use serde::Serialize;
use std::fmt;

/// What to do about clocks that are apart.
pub(super) const ADVICE: &str = "take both times from one clock, or synchronise the clocks (PTP, chrony) to a small part of a cycle and log \
                                 again; or log packets of the way back too (in both logs), or say the shortest delay there is with \
                                 --shortest-delay, so that the clocks can be brought together";

/// Why a packet cannot have arrived before it was sent.
pub(super) fn early(number: u64, by: Nanoseconds) -> String {
    format!(
        "packet {number} arrives {:e} s before it is sent: the clocks of the two ends are not synchronised",
        seconds(by)
    )
}

/// A stretch without a step: the receiver's clock shows `t + offset + drift (t - origin)` at the sender's time t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    /// First time of the stretch, by the sender's clock.
    pub(super) from: Nanoseconds,
    pub(super) origin: Nanoseconds,
    /// Nanoseconds.
    pub(super) offset: f64,
    /// Nanoseconds per nanosecond.
    pub(super) drift: f64,
    /// Nanoseconds by which the line may be wrong anywhere, whatever the delays of the two ways are.
    pub(super) margin: f64,
}

/// The receiver's clock as the sender's sees it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Relation {
    /// In the order of time, at least one.
    pub(super) stretches: Vec<Stretch>,
    /// Whether only packets of one way were there, and the shortest delay was given.
    pub(super) is_one_way: bool,
}

/// How two clocks are to each other, for readers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Told {
    /// Seconds by which the receiver's clock is ahead at the begin of the log.
    pub offset: f64,
    /// How much faster it goes, in millionths.
    pub drift_ppm: f64,
    /// Seconds by which the offset may be wrong.
    pub margin: f64,
    /// How often one of the clocks was set.
    pub steps: usize,
}

impl Relation {
    /// The sender's time when the receiver's clock shows `time`, for a packet that was sent at `sent`.
    pub(super) fn to_sender(&self, time: Nanoseconds, sent: Nanoseconds) -> Nanoseconds {
        let after = self.stretches.partition_point(|stretch| stretch.from <= sent);
        let stretch = &self.stretches[after.saturating_sub(1)];
        let since = (time - stretch.origin) as f64;
        let offset = (stretch.offset + stretch.drift * since) / (1.0 + stretch.drift);
        clamped(time.saturating_sub(offset.round() as Nanoseconds))
    }

    pub(super) fn told(&self) -> Told {
        let first = &self.stretches[0];
        let margin = self.stretches.iter().map(|stretch| stretch.margin).fold(0.0, f64::max);
        Told {
            offset: first.offset / 1e9,
            drift_ppm: first.drift * 1e6,
            margin: margin / 1e9,
            steps: self.stretches.len() - 1,
        }
    }
}

impl fmt::Display for Relation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told = self.told();
        write!(
            out,
            "the receiver's clock is {:+.6} s from the sender's at the begin and drifts by {:+.2} ppm; times are corrected",
            told.offset, told.drift_ppm
        )?;
        if told.steps > 0 {
            write!(out, ", for {} steps too", told.steps)?;
        }
        match self.is_one_way {
            true => write!(out, ", so that the shortest delay is as --shortest-delay says"),
            false => write!(
                out,
                ", so that the shortest delays of both ways are alike; if they are not, delays are wrong by at most {:.6} s, which the \
                 intervals hold",
                told.margin
            ),
        }
    }
}
