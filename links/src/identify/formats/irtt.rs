//! JSON of irtt (version 0.9.0): each packet with its times at client and server, and whether it was lost on the way up or down.

use super::super::{
    clocks::two_way,
    join::Joined,
    logs::Selection,
    packets::Packets,
    pairing, time,
    trace::{Gaps, Trace, TraceError},
};
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
struct Log {
    round_trips: Vec<RoundTrip>,
}

#[derive(Deserialize)]
struct RoundTrip {
    seqno: u64,
    lost: String,
    timestamps: Timestamps,
}

#[derive(Deserialize, Default)]
struct Timestamps {
    #[serde(default)]
    client: End,
    #[serde(default)]
    server: End,
}

#[derive(Deserialize, Default)]
struct End {
    #[serde(default)]
    receive: Stamp,
    #[serde(default)]
    send: Stamp,
}

/// Nanoseconds since 1970.
#[derive(Deserialize, Default)]
struct Stamp {
    wall: Option<i64>,
}

/// Reads the way up, or with [`Selection::is_way_back`] the way down.
///
/// A packet that was lost on the way down arrived at the server, but nobody knows when; one of which irtt does not know on which way
/// it was lost may have arrived. Neither is counted.
pub(in super::super) fn read(
    file: &Path,
    bytes: &[u8],
    selection: &Selection<'_>,
) -> Result<Trace, TraceError> {
    let log: Log = serde_json::from_slice(bytes).map_err(|error| {
        TraceError::line(
            file,
            error.line() as u64,
            format!("is no JSON of irtt as version 0.9.0 writes it: {error}"),
        )
    })?;
    let mut rows = log.round_trips;
    rows.sort_by_key(|row| row.seqno);
    let (mut joined, mut back, mut undecided) = (Joined::default(), Packets::default(), 0);
    let mut newest = None;
    for row in rows {
        if newest.replace(row.seqno) == Some(row.seqno) {
            joined.duplicates += 1;
            continue;
        }
        let Timestamps { client, server } = row.timestamps;
        let wall = |stamp: &Stamp| stamp.wall.and_then(time::near);
        let up = (wall(&client.send), wall(&server.receive));
        let down = (wall(&server.send), wall(&client.receive));
        let (way, other) = if selection.is_way_back { (down, up) } else { (up, down) };
        match (way, row.lost.as_str(), selection.is_way_back) {
            ((Some(sent), Some(received)), ..) => joined.arrived(row.seqno, sent, received),
            ((Some(sent), None), "true_up", false) | ((Some(sent), None), "true_down", true) => {
                joined.packets.push(row.seqno, sent, None);
            }
            // What did not come up was not sent down.
            (_, "true_up", true) => {}
            _ => undecided += 1,
        }
        if let (Some(sent), Some(received)) = other {
            // At the ends of the way that is read: seen there when it arrives, sent from the far end.
            back.push(row.seqno, received, Some(sent));
        }
    }
    if joined.arrived == 0 {
        let problem = "found no packet with times of both ends; measure with irtt client --tstamp=both (the default), against a server that \
                       allows it";
        return Err(TraceError::file(file, problem));
    }
    let relation = two_way::relation(&joined.packets, &[back], selection.shortest_delay)
        .map_err(|problem| TraceError::file(file, problem))?;
    let mut trace = pairing::with_clock(joined, relation.as_ref(), selection.gaps.unwrap_or(Gaps::Ignore))
        .map_err(|problem| TraceError::file(file, problem))?;
    trace.undecided += undecided;
    trace.about.number = Some("irtt's sequence number".into());
    let way = if selection.is_way_back {
        "down, from the server to the client"
    } else {
        "up, from the client to the server"
    };
    trace.about.notes.push(format!("the way {way}"));
    Ok(trace)
}
