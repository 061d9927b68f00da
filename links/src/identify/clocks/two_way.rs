//! Offset, drift and steps of the receiver's clock, from packets that go both ways.

use super::{
    Relation, Stretch,
    corridor::{Corridor, widest},
    envelope::{Point, lower},
};
use crate::identify::{packets::Packets, time::Nanoseconds};

/// Stretches of time in which the ways are compared.
const PARTS: usize = 10;
/// In this part of them packets of the way back are seen at the sender later than any of the link.
const AGREEING: f64 = 0.8;
/// A clock that is set more often is not one.
const MOST_STEPS: usize = 50;
/// Packets that are under way while a clock is set, and others that do not show it yet, are no more than these.
const UNCLEAR: usize = 64;
/// Packets after a step that must fit each other.
const AFTER: usize = 4 * UNCLEAR;
/// A step narrows the corridor to less than this part.
const NARROW: f64 = 0.7;

/// A packet: when the sender's end saw it, and how much later the receiver's clock showed.
#[derive(Debug, Clone, Copy)]
struct Event {
    at: Nanoseconds,
    later: Nanoseconds,
    is_forward: bool,
}

/// How the clocks are to each other; nothing if they may well be the same, or if nothing can be known.
///
/// `ways` are packets seen at both ends, that go either way.
pub(in super::super) fn relation(
    main: &Packets,
    ways: &[Packets],
    shortest: Option<Nanoseconds>,
) -> Result<Option<Relation>, String> {
    let mut events = events(main, true);
    let back: Vec<Event> = ways
        .iter()
        .map(|way| self::events(way, false))
        .filter(|way| is_back(&events, way))
        .flatten()
        .collect();
    if back.is_empty() {
        let stretch = shortest.and_then(|shortest| one_way(&events, shortest));
        return Ok(stretch.map(|stretch| Relation { stretches: vec![stretch], is_one_way: true }));
    }
    let agree = events.iter().all(|event| event.later >= 0) && back.iter().all(|event| event.later <= 0);
    if agree {
        return Ok(None);
    }
    events.extend(back);
    events.sort_by_key(|event| event.at);
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut rest = events.as_slice();
    while !rest.is_empty() {
        if stretches.len() > MOST_STEPS {
            return Err(format!(
                "the clocks of the two ends do not fit each other: packets of both ways would need more than {MOST_STEPS} steps of a \
                 clock; synchronise the clocks (PTP, chrony) and log again"
            ));
        }
        let (end, next) = stretch_end(rest);
        if let Some(found) = fitted(&rest[..end]) {
            stretches.push(found);
        }
        rest = &rest[next..];
    }
    Ok((!stretches.is_empty()).then_some(Relation { stretches, is_one_way: false }))
}

fn events(packets: &Packets, is_forward: bool) -> Vec<Event> {
    let arrived =
        packets.iter().filter_map(|(_, at, received)| Some(Event { at, later: received? - at, is_forward }));
    let mut events: Vec<Event> = arrived.collect();
    events.sort_by_key(|event| event.at);
    events
}

/// Whether packets of a way go back: what the link delays lies above the clocks' difference, what goes back below.
fn is_back(forward: &[Event], way: &[Event]) -> bool {
    let (Some(first), Some(last)) = (forward.first(), forward.last()) else { return false };
    let part = (last.at - first.at) / PARTS as i64 + 1;
    let of_part = |events: &[Event], index: usize| -> Vec<Nanoseconds> {
        let from = first.at + part * index as i64;
        let (begin, end) = (
            events.partition_point(|event| event.at < from),
            events.partition_point(|event| event.at < from + part),
        );
        let mut delays: Vec<_> = events[begin..end].iter().map(|event| event.later).collect();
        delays.sort_unstable();
        delays
    };
    let parts = (0..PARTS).map(|index| (of_part(forward, index), of_part(way, index)));
    let compared: Vec<bool> = parts
        .filter(|(forward, way)| !forward.is_empty() && !way.is_empty())
        .map(|(forward, way)| way[way.len() / 2] < forward[0])
        .collect();
    let agreeing = compared.iter().filter(|is_below| **is_below).count();
    !compared.is_empty() && agreeing as f64 >= AGREEING * compared.len() as f64
}

/// Corners of both ways, relative to the first event.
fn corners(events: &[Event]) -> (Vec<Point>, Vec<Point>) {
    let (at, later) = (events[0].at, events[0].later);
    // Differences of differences may not fit 64 bits.
    let point =
        |event: &Event| ((event.at - at) as f64, (i128::from(event.later) - i128::from(later)) as f64);
    let forward = lower(events.iter().filter(|event| event.is_forward).map(point));
    let backward = events.iter().filter(|event| !event.is_forward).map(point);
    (forward, lower(backward.map(|(time, later)| (time, -later))))
}

fn corridor(events: &[Event]) -> Option<Corridor> {
    let (forward, backward) = corners(events);
    (!forward.is_empty() && !backward.is_empty()).then(|| widest(&forward, &backward))
}

/// Half the width of the corridor; nothing to be narrow where only one way is.
fn width(events: &[Event]) -> f64 {
    corridor(events).map_or(f64::INFINITY, |corridor| corridor.half)
}

/// How many events belong to the first stretch, before a clock is set, and where the next one begins.
fn stretch_end(events: &[Event]) -> (usize, usize) {
    if width(events) >= 0.0 {
        return (events.len(), events.len());
    }
    // As many as fit one line, though the last of them may come after the step.
    let (mut fitting, mut wrong) = (1, events.len());
    while fitting + 1 < wrong {
        let middle = fitting + (wrong - fitting) / 2;
        if width(&events[..middle]) >= 0.0 { fitting = middle } else { wrong = middle }
    }
    let clear = fitting.saturating_sub(UNCLEAR).max(1);
    let usual = width(&events[..clear]);
    let end = (clear..=fitting).rev().find(|end| width(&events[..*end]) >= NARROW * usual).unwrap_or(clear);
    // Some packets have seen one clock or the other: the next stretch begins where all agree again.
    let after = |next: usize| width(&events[next..events.len().min(next + AFTER)]);
    let agrees = |next: &usize| {
        *next < events.len()
            && after(*next) >= NARROW * usual.min(after(fitting + UNCLEAR.min(events.len() - fitting)))
    };
    let next = (end..=end + 2 * UNCLEAR).find(agrees).unwrap_or(fitting);
    (end, next.max(1))
}

fn fitted(events: &[Event]) -> Option<Stretch> {
    let (first, corridor) = (events.first()?, corridor(events)?);
    let (forward, backward) = corners(events);
    let last = (events.last()?.at - first.at) as f64;
    Some(Stretch {
        from: first.at,
        origin: first.at,
        offset: first.later as f64 + corridor.offset,
        drift: corridor.drift,
        margin: corridor.margin(&forward, &backward, last),
    })
}

/// From packets of one way: the drift of the smallest delays, which are taken to be `shortest`.
fn one_way(events: &[Event], shortest: Nanoseconds) -> Option<Stretch> {
    let (first, last) = (events.first()?, events.last()?);
    let (forward, _) = corners(events);
    let middle = (last.at - first.at) as f64 / 2.0;
    // Of the lines below all points, the edge over the middle is the highest there.
    let edge = forward.windows(2).find(|edge| edge[1].0 >= middle)?;
    let drift = (edge[1].1 - edge[0].1) / (edge[1].0 - edge[0].0);
    let offset = first.later as f64 + edge[0].1 - drift * edge[0].0 - shortest as f64;
    Some(Stretch { from: first.at, origin: first.at, offset, drift, margin: 0.0 })
}
