//! What was seen at the sender and at the receiver becomes packets.

use super::{
    time::Nanoseconds,
    trace::{Gaps, Packet, Trace, early},
};
use slqg::wire::VERSION;
use std::collections::HashMap;

/// A packet seen at one of the ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sighting {
    /// The tick of a frame, or a counter.
    pub(super) number: u32,
    pub(super) time: Nanoseconds,
}

/// Kind and tick, if `payload` begins as a frame does (docs/wire-format.md). The rest may be cut off.
pub(super) fn frame(payload: &[u8]) -> Option<(u8, u32)> {
    match *payload {
        [VERSION, kind @ 1..=3, 4 | 8, a, b, c, d, ..] => Some((kind, u32::from_le_bytes([a, b, c, d]))),
        _ => None,
    }
}

/// The first four bytes as a counter.
pub(super) fn counter(payload: &[u8]) -> Option<u32> {
    payload.first_chunk().map(|bytes| u32::from_le_bytes(*bytes))
}

/// Pairs by number. Of several sightings of a number at one end the first counts.
///
/// Whether the first and the last packets were lost cannot be told: the receiver's log may have begun later or ended
/// before they arrived. Those without arrival that were sent before the first arrival, or within the longest delay
/// before the last, are left out.
pub(super) fn pair(sent: &[Sighting], received: &[Sighting], gaps: Gaps) -> Result<Trace, String> {
    let (Some(first), Some(last)) = (
        received.iter().map(|sighting| sighting.time).min(),
        received.iter().map(|sighting| sighting.time).max(),
    ) else {
        return Err("the receiver saw none of the packets: check which log is which".into());
    };
    let mut trace = Trace::default();
    let mut arrivals: HashMap<u32, Nanoseconds> = HashMap::new();
    for sighting in received {
        let time = arrivals.entry(sighting.number).or_insert(sighting.time);
        *time = sighting.time.min(*time);
    }
    trace.duplicates = (received.len() - arrivals.len()) as u64;

    let mut sent = sent.to_vec();
    sent.sort_by_key(|sighting| sighting.time);
    let mut seen = std::collections::HashSet::new();
    // Numbers go on beyond 2^32; the offset leaves room below the first for packets that were sent out of order.
    let mut newest: Option<(u32, u64)> = None;
    for Sighting { number, time } in sent {
        if !seen.insert(number) {
            trace.duplicates += 1;
            continue;
        }
        let sequence = match newest {
            None => (1 << 32) | u64::from(number),
            Some((before, sequence)) => {
                sequence.wrapping_add_signed(i64::from(number.wrapping_sub(before) as i32))
            }
        };
        if newest.is_none_or(|(_, highest)| sequence > highest) {
            newest = Some((number, sequence));
        }
        let received = arrivals.remove(&number);
        if let Some(problem) = received.and_then(|received| early(u64::from(number), time, received)) {
            return Err(problem);
        }
        trace.packets.push(Packet { sequence, sent: Some(time), received });
    }
    trace.strays = arrivals.len() as u64;

    let delay = |packet: &Packet| Some(packet.received? - packet.sent?);
    let longest = trace.packets.iter().filter_map(delay).max().unwrap_or(0);
    let before = trace.packets.len();
    trace.packets.retain(|packet| {
        let decidable = |sent| sent >= first && sent <= last - longest;
        packet.received.is_some() || packet.sent.is_some_and(decidable)
    });
    trace.undecided = (before - trace.packets.len()) as u64;
    trace.packets.sort_by_key(|packet| packet.sequence);
    trace.fill(gaps)?;
    Ok(trace)
}
