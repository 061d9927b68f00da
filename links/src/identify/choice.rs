//! [`Choice`]: which frames of the logs are packets of the link, and by which number they are told apart.

use super::{
    about::Skip,
    collector::End,
    counters::{
        Counter, FORM,
        find::{AS_THEY_ARRIVE, IN_ORDER, find},
    },
    early::Early,
    formats::message::Stream,
    logs::Selection,
};
use slqg::wire::VERSION;
use std::{collections::BTreeMap, fmt};

/// Of a stream's payloads, at least this part begins like a frame of the wire format if it is one.
const FRAMES: f64 = 0.9;
/// Kinds of frames that make the loop.
const KINDS: std::ops::RangeInclusive<u8> = 1..=3;
/// Streams that are looked at for the way back.
const MOST_OTHERS: usize = 8;
const NONE_SENT: &str = "the sender's log has none of the packets: check which log is which, --tx and --id";
const WIDE: u64 = 1 << 16;
const FRAME_MODULUS: u64 = 1 << 32;

/// Kind and tick, if `payload` begins as a frame does (docs/wire-format.md). The rest may be cut off.
fn frame(payload: &[u8]) -> Option<(u8, u32)> {
    match *payload {
        [VERSION, kind, 4 | 8, a, b, c, d, ..] if KINDS.contains(&kind) => {
            Some((kind, u32::from_le_bytes([a, b, c, d])))
        }
        _ => None,
    }
}

/// What tells packets apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Choice {
    /// The tick of frames of a kind, and of other kinds for the way back.
    Frames { kind: u8, only: Option<Stream>, others: Vec<u8> },
    /// Counters, each in a stream; the first is that of the link.
    Counters(Vec<(Stream, Counter)>),
}

impl Choice {
    /// Which way a frame is of (0: the link, others: what may be its way back), and its number; or why it is skipped.
    pub(super) fn number(&self, stream: Stream, data: &[u8]) -> Result<(usize, u32), Skip> {
        match self {
            Self::Frames { kind, only, others } => {
                if only.is_some_and(|only| only != stream) && others.is_empty() {
                    return Err(Skip::Identifier);
                }
                let (of, tick) = frame(data).ok_or(Skip::Identifier)?;
                if of == *kind && only.is_none_or(|only| only == stream) {
                    return Ok((0, tick));
                }
                let other = others.iter().position(|other| *other == of).ok_or(Skip::Kind)?;
                Ok((other + 1, tick))
            }
            Self::Counters(counters) => {
                let way = counters.iter().position(|(of, _)| *of == stream).ok_or(Skip::Identifier)?;
                Ok((way, counters[way].1.read(data).ok_or(Skip::Short)?))
            }
        }
    }

    /// How many streams are read besides that of the link.
    pub(super) fn others(&self) -> usize {
        self.moduli().len() - 1
    }

    /// How many numbers there are, way by way.
    pub(super) fn moduli(&self) -> Vec<u64> {
        match self {
            Self::Frames { others, .. } => vec![FRAME_MODULUS; 1 + others.len()],
            Self::Counters(counters) => counters.iter().map(|(_, counter)| counter.modulus).collect(),
        }
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frames { .. } => write!(out, "tick of the wire format"),
            Self::Counters(counters) => match counters.first() {
                Some((stream, counter)) => write!(out, "counter {counter} of {stream}"),
                None => write!(out, "counter"),
            },
        }
    }
}

/// What is there of a stream.
#[derive(Debug, Default, Clone, Copy)]
struct Tally {
    sent: u64,
    received: u64,
    frames: u64,
    of_kind: u64,
}

/// Chooses by what was seen first. With two clocks, other streams are of use too: what goes the way back tells how the clocks are apart.
pub(super) fn choose(
    early: &Early,
    selection: &Selection<'_>,
    has_two_clocks: bool,
) -> Result<Choice, String> {
    let mut streams: BTreeMap<Stream, Tally> = BTreeMap::new();
    for (_, end, stream, payload) in early.iter() {
        let tally = streams.entry(stream).or_default();
        *(if end == End::Sender { &mut tally.sent } else { &mut tally.received }) += 1;
        if let Some((kind, _)) = frame(payload) {
            tally.frames += 1;
            tally.of_kind += u64::from(kind == selection.kind);
        }
    }
    let wanted: Vec<(Stream, Tally)> = streams
        .iter()
        .map(|(stream, tally)| (*stream, *tally))
        .filter(|(stream, _)| is_wanted(*stream, selection))
        .collect();
    if wanted.is_empty() {
        return Err(unwanted(&streams, selection));
    }
    if wanted.iter().all(|(_, tally)| tally.sent == 0) {
        return Err(NONE_SENT.into());
    }
    let is_frames = |tally: &Tally| {
        tally.frames > 0 && tally.frames as f64 >= FRAMES * (tally.sent + tally.received) as f64
    };
    if selection.counter.is_none() && wanted.iter().any(|(_, tally)| is_frames(tally)) {
        if !wanted.iter().any(|(_, tally)| is_frames(tally) && tally.of_kind > 0) {
            return Err("no frame is of the kind that --link carries; see docs/wire-format.md".into());
        }
        let only = selection.id.map(Stream::Can).or(selection.port.map(Stream::Udp));
        let others = KINDS.filter(|kind| has_two_clocks && *kind != selection.kind).collect();
        return Ok(Choice::Frames { kind: selection.kind, only, others });
    }
    let sent = early.payloads(End::Sender);
    let first = counter(&sent, &wanted, selection)?;
    let mut counters = vec![first];
    let others = streams.iter().filter(|(stream, tally)| {
        has_two_clocks && **stream != first.0 && tally.sent > 0 && tally.received > 0
    });
    let received = if has_two_clocks { early.payloads(End::Receiver) } else { BTreeMap::new() };
    for (&stream, _) in others.take(MOST_OTHERS) {
        // Which end is its sender's is not known.
        let found = [&sent, &received].into_iter().find_map(|end| {
            // By a narrow one packets are paired only where the clocks agree.
            counter_of(end, stream, AS_THEY_ARRIVE).filter(|counter| counter.modulus >= WIDE)
        });
        counters.extend(found.map(|counter| (stream, counter)));
    }
    Ok(Choice::Counters(counters))
}

fn is_wanted(stream: Stream, selection: &Selection<'_>) -> bool {
    match stream {
        Stream::Can(id) => selection.id.is_none_or(|wanted| wanted == id),
        Stream::Udp(port) => selection.id.is_none() && selection.port.is_none_or(|wanted| wanted == port),
    }
}

fn counter_of(payloads: &BTreeMap<Stream, Vec<&[u8]>>, stream: Stream, small_steps: f64) -> Option<Counter> {
    find(payloads.get(&stream)?.iter().copied(), small_steps)
}

/// The one stream whose payloads have a counter, with it.
fn counter(
    payloads: &BTreeMap<Stream, Vec<&[u8]>>,
    wanted: &[(Stream, Tally)],
    selection: &Selection<'_>,
) -> Result<(Stream, Counter), String> {
    let sent: Vec<Stream> =
        wanted.iter().filter(|(_, tally)| tally.sent > 0).map(|(stream, _)| *stream).collect();
    let at_both: Vec<Stream> = wanted
        .iter()
        .filter(|(_, tally)| tally.sent > 0 && tally.received > 0)
        .map(|(stream, _)| *stream)
        .collect();
    if let Some(given) = selection.counter {
        let of = if at_both.is_empty() { &sent } else { &at_both };
        let [stream] = of.as_slice() else { return Err(several(of)) };
        if payloads.get(stream).is_none_or(|of| of.iter().all(|payload| given.read(payload).is_none())) {
            return Err(format!("--counter {given}: the payloads of {stream} are too short for it"));
        }
        return Ok((*stream, given));
    }
    let with_counter = |streams: &[Stream]| -> Vec<(Stream, Counter)> {
        let found = streams.iter().map(|stream| (*stream, counter_of(payloads, *stream, IN_ORDER)));
        found.filter_map(|(stream, counter)| Some((stream, counter?))).collect()
    };
    let mut found = with_counter(&at_both);
    if found.is_empty() {
        found = with_counter(&sent);
    }
    match found.as_slice() {
        [one] => Ok(*one),
        [] if sent.is_empty() => {
            Err("the sender's log has none of the packets: check which log is which, --tx and --id".into())
        }
        [] => Err(format!(
            "found no counter in the payloads of {}: no bytes that go up by one from each packet to the next, and no frames of the wire \
             format; if there is one, say where with --counter: {FORM}",
            sent.iter().map(Stream::to_string).collect::<Vec<_>>().join(", ")
        )),
        several_found => Err(several(&several_found.iter().map(|(stream, _)| *stream).collect::<Vec<_>>())),
    }
}

fn several(streams: &[Stream]) -> String {
    let names: Vec<String> = streams.iter().take(12).map(Stream::to_string).collect();
    let option =
        if streams.iter().any(|stream| matches!(stream, Stream::Udp(_))) { "--port" } else { "--id" };
    format!("found packets with several numbers to count by: {}; say which with {option}", names.join(", "))
}

/// Why nothing that was seen is wanted.
fn unwanted(streams: &BTreeMap<Stream, Tally>, selection: &Selection<'_>) -> String {
    if streams.is_empty() {
        return "found no packet: neither CAN frames with data nor UDP over IPv4 or IPv6; see docs/traces.md"
            .into();
    }
    if let Some(id) = selection.id {
        let twin =
            streams.keys().find(|stream| matches!(stream, Stream::Can(other) if other.number == id.number));
        return match (twin, id.is_extended) {
            (Some(_), true) => format!(
                "found no extended identifier {id} (29 bits); the standard one (11 bits) is there: --id {:03X}",
                id.number
            ),
            (Some(_), false) => format!(
                "found no standard identifier {id} (11 bits); the extended one (29 bits) is there: --id {:08X}",
                id.number
            ),
            (None, _) => format!("found no frame with identifier {id}; there are {}", listed(streams)),
        };
    }
    format!("found no packet to the port of --port; there are {}", listed(streams))
}

fn listed(streams: &BTreeMap<Stream, Tally>) -> String {
    let names: Vec<String> = streams.keys().take(12).map(Stream::to_string).collect();
    names.join(", ")
}
