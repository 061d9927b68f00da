//! A realistic set of other traffic for a given load. What the bus makes of it is `bus`.

use super::{
    frame::{Attempts, Format},
    id::Id,
    length::Length,
    source::{NodeId, Pattern, Source},
    time::{INTERMISSION, RateError, Rates, Time},
};
use std::ops::Range;

const MILLISECOND: Time = 1_000_000;
/// Payload of every message, in bytes.
const BYTES: usize = 8;
/// Periods in the order in which messages are added, in milliseconds: most messages of a vehicle are sent every 10 to
/// 100 ms.
const MIX: [Time; 10] = [10, 100, 20, 50, 10, 20, 100, 5, 20, 100];
const SLOWEST: Time = 100 * MILLISECOND;
/// Jitter as part of a period: it lets messages of commensurate periods drift past each other.
const JITTER: Time = 10;
const IDENTIFIERS: u16 = 1 << 11;

/// A load for which there is no set of messages.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum BackgroundError {
    /// Not a part of the bus.
    #[error("found a load of {0}: it must be at least 0 and below 1")]
    Load(f64),
    /// Nobody to send it.
    #[error("found no nodes for the other traffic: give at least one")]
    NoNodes,
    /// The bit rate.
    #[error(transparent)]
    Rate(#[from] RateError),
    /// More messages than identifiers.
    #[error("the load takes {messages} messages, but only {free} identifiers are not reserved")]
    Identifiers {
        /// Messages needed.
        messages: usize,
        /// Identifiers left.
        free: usize,
    },
}

/// Other traffic on the bus.
#[derive(Debug, Clone, PartialEq)]
pub struct Background {
    /// Its messages, most urgent first.
    pub sources: Vec<Source>,
}

impl Background {
    /// Periodic messages of 8 bytes with 11-bit identifiers that take the part `load` of a bus of `bit_rate` (bit/s) if
    /// every frame had its worst length, intermission included. Random stuffing makes the true load about a tenth less.
    ///
    /// Periods are 5, 10, 20, 50 and 100 ms, shorter ones with more urgent identifiers, and a jitter of a tenth of the period.
    /// One message of 100 ms gets another period so that the load is met to rounding. Identifiers are spread evenly over
    /// all that are not `reserved`; the messages take turns over `nodes`.
    ///
    /// # Errors
    /// A load outside 0 to 1, no nodes, a bit rate whose bits do not last whole nanoseconds, too few identifiers.
    pub fn load(
        load: f64,
        bit_rate: u32,
        reserved: &[Id],
        nodes: Range<u16>,
    ) -> Result<Self, BackgroundError> {
        if !(0.0..1.0).contains(&load) {
            return Err(BackgroundError::Load(load));
        }
        if nodes.is_empty() {
            return Err(BackgroundError::NoNodes);
        }
        let rates = Rates::new(bit_rate, None)?;
        let length = Length::worst(false, Format::Classic, BYTES);
        let length = length.unwrap_or_else(|_| unreachable!("a classical frame carries 8 bytes"));
        let periods = periods(load, rates.bits(length.bits() + INTERMISSION));

        let free: Vec<Id> = (0..IDENTIFIERS)
            .filter_map(|value| Id::base(value).ok())
            .filter(|id| !reserved.contains(id))
            .collect();
        if periods.len() > free.len() {
            return Err(BackgroundError::Identifiers { messages: periods.len(), free: free.len() });
        }
        let message = |(index, period): (usize, Time)| Source {
            node: NodeId(nodes.start + (index % nodes.len()) as u16),
            id: free[(2 * index + 1) * free.len() / (2 * periods.len())],
            format: Format::Classic,
            bytes: BYTES,
            pattern: Pattern::Periodic { period, offset: offset(index, period), jitter: period / JITTER },
            attempts: Attempts::Unlimited,
        };
        Ok(Background { sources: periods.iter().copied().enumerate().map(message).collect() })
    }
}

/// Periods of messages of `length` (ns) each that sum to the load, shortest first.
fn periods(load: f64, length: Time) -> Vec<Time> {
    let part = |period: Time| length as f64 / period as f64;
    let mut periods = Vec::new();
    let mut left = load;
    let mut refused = 0;
    for period in MIX.iter().cycle().map(|ms| ms * MILLISECOND) {
        if part(period) <= left {
            left -= part(period);
            periods.push(period);
            refused = 0;
        } else {
            refused += 1;
        }
        if refused == MIX.len() {
            break;
        }
    }
    periods.sort_unstable();
    // What is left is less than a message of the slowest period: the last such message takes it over.
    let taken_over = if periods.last() == Some(&SLOWEST) { periods.pop().map_or(0.0, part) } else { 0.0 };
    if left + taken_over > 0.0 {
        periods.push((length as f64 / (left + taken_over)).round() as Time);
    }
    periods.sort_unstable();
    periods
}

/// Offsets that spread over the period, by the golden ratio.
fn offset(index: usize, period: Time) -> Time {
    let part = (index as f64 * 0.618_033_988_749_894_9).fract();
    (part * period as f64) as Time
}
