//! [`Figures`]: everything that is known about a link from its logs.

use super::{
    about::{About, Skipped},
    chance::Share,
    channel::{Channel, channel},
    clocks::Told,
    drift::{Drift, drift},
    independence::{Bursts, Correlation, Losses, bursts, delays, losses},
    sample::{Clock, Sample},
    trace::{Trace, TraceError},
    warnings,
};
use crate::delay::DelayDistribution;
use serde::Serialize;

/// What was odd about the logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Oddities {
    /// Numbers missing in the sequence.
    pub missing: u64,
    /// Whether they count as lost packets.
    pub missing_are_lost: bool,
    /// Packets seen again; only the first arrival counts.
    pub duplicates: u64,
    /// Packets received of which the sender knows nothing; not counted.
    pub strays: u64,
    /// Packets at the ends of the logs that may be lost or not; not counted.
    pub undecided: u64,
    /// Packets that arrived later than counts; counted as lost.
    pub late: u64,
    /// Packets that arrived after one which was sent later.
    pub reordered: u64,
    /// What is no packet of the link, by kind; not counted.
    pub skipped: Skipped,
    /// Frames that the logger says it missed: whether they were packets, nobody knows.
    pub dropped: u64,
    /// Jumps of the sender's counter that are against the time: it may have begun anew.
    pub restarts: u64,
}

/// What the logs say about the link.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Where they come from.
    pub files: Vec<String>,
    /// Their format.
    pub format: &'static str,
    /// By which number packets were told apart.
    pub number: Option<String>,
    /// How the receiver's clock is to the sender's, where times were corrected.
    pub clock: Option<Told>,
    /// What was assumed or done, in words.
    pub notes: Vec<String>,
    /// Seconds per cycle.
    pub sample_time: f64,
    /// Seconds from the begin of a cycle to the sending of its packet.
    pub offset: f64,
    /// Packets that count.
    pub packets: u64,
    /// P(delay = 0), P(delay = 1), .. in cycles.
    pub delays: Vec<Share>,
    /// P(lost).
    pub loss: Share,
    /// With 95 %, all delays that were not seen are together less probable than this.
    pub unseen_below: f64,
    /// Mean delay of the packets that arrived, in cycles.
    pub mean_delay: f64,
    /// Losses of neighbours against each other.
    pub independence_of_losses: Option<Losses>,
    /// Runs of losses.
    pub bursts: Option<Bursts>,
    /// The channel that losses come from, where they are not independent.
    pub channel: Option<Channel>,
    /// Delays of neighbours against each other.
    pub correlation_of_delays: Option<Correlation>,
    /// First half against second half.
    pub drift: Option<Drift>,
    /// What was odd about the logs.
    pub log: Oddities,
    /// What to mind, in words.
    pub warnings: Vec<String>,
}

impl Figures {
    /// Computes all figures of the traces of one link.
    ///
    /// # Errors
    /// No packet arrived.
    pub fn new(files: Vec<String>, traces: &[Trace], clock: &Clock) -> Result<Self, TraceError> {
        let sample = Sample::new(traces, clock)?;
        let packets = sample.packets();
        let mut delay_shares: Vec<Share> =
            sample.counts.iter().map(|&count| Share::new(count, packets)).collect();
        let probabilities = delay_shares.iter().map(|share| share.probability).collect();
        let distribution =
            DelayDistribution::new(probabilities).map_err(|error| TraceError::Whole(error.to_string()))?;
        let about = About::of(traces.iter().map(|trace| &trace.about));
        let total = |of: fn(&Trace) -> u64| traces.iter().map(of).fold(0, u64::saturating_add);
        let log = Oddities {
            missing: total(|trace| trace.missing),
            missing_are_lost: traces.iter().any(|trace| trace.missing_are_lost),
            duplicates: total(|trace| trace.duplicates),
            strays: total(|trace| trace.strays),
            undecided: total(|trace| trace.undecided),
            late: sample.late,
            reordered: sample.reordered,
            skipped: about.skipped,
            dropped: about.dropped,
            restarts: about.restarts,
        };
        let mut loss = Share::new(sample.lost, packets);
        // (1 - p)^n = 0.05
        let mut unseen_below = 1.0 - 0.05_f64.powf(1.0 / packets as f64);
        if let Some(told) = about.clock {
            for by in [-told.margin, told.margin] {
                let offset = clock.offset + by;
                let other = Sample::new(traces, &Clock { offset, ..*clock })?;
                unseen_below = unseen_below.max(widen(&mut delay_shares, &mut loss, &other));
            }
        }
        let independence_of_losses = losses(&sample);
        let mut figures = Self {
            files,
            format: about.format,
            number: about.number,
            clock: about.clock,
            notes: about.notes,
            sample_time: clock.sample_time,
            offset: clock.offset,
            packets,
            delays: delay_shares,
            loss,
            unseen_below,
            mean_delay: distribution.mean_delay(),
            independence_of_losses,
            bursts: bursts(&sample),
            channel: independence_of_losses.and_then(|losses| channel(&sample, &losses)),
            correlation_of_delays: delays(&sample),
            drift: drift(&sample),
            log,
            warnings: Vec::new(),
        };
        figures.warnings = warnings::all(&figures);
        Ok(figures)
    }

    /// The figures as one JSON object.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }
}

/// Lets the intervals hold those of a sample by another offset of the clocks. What it has of delays that were not seen is less than
/// what comes back, with 95 %.
fn widen(delays: &mut [Share], loss: &mut Share, other: &Sample) -> f64 {
    let packets = other.packets();
    let (seen, unseen) = other.counts.split_at(delays.len().min(other.counts.len()));
    for (delay, share) in delays.iter_mut().enumerate() {
        share.hold(&Share::new(seen.get(delay).copied().unwrap_or(0), packets));
    }
    loss.hold(&Share::new(other.lost, packets));
    match unseen.iter().sum() {
        0 => 0.0,
        unseen => Share::new(unseen, packets).high,
    }
}
