//! Captures in the classic pcap format: of IPv4/UDP over Ethernet, Linux "any" or raw IP.

use super::{
    pairing::{Sighting, frame, pair},
    time::Nanoseconds,
    trace::{Gaps, Trace, TraceError},
};
use std::path::{Path, PathBuf};

const HEADER: usize = 24;
const RECORD: usize = 16;
const IPV4: [u8; 2] = [0x08, 0x00];
const VLAN: [u8; 2] = [0x81, 0x00];
const UDP: u8 = 17;

/// Whether a file begins as a capture does, of this format or of the one after it.
pub(super) fn looks_like_one(bytes: &[u8]) -> bool {
    bytes.starts_with(&NEXT_GENERATION) || bytes.first_chunk().is_some_and(|magic| shape(*magic).is_some())
}

const NEXT_GENERATION: [u8; 4] = [0x0a, 0x0d, 0x0d, 0x0a];

/// Whether numbers are little-endian, and nanoseconds per unit of the fraction.
fn shape(magic: [u8; 4]) -> Option<(bool, i64)> {
    match magic {
        [0xd4, 0xc3, 0xb2, 0xa1] => Some((true, 1000)),
        [0xa1, 0xb2, 0xc3, 0xd4] => Some((false, 1000)),
        [0x4d, 0x3c, 0xb2, 0xa1] => Some((true, 1)),
        [0xa1, 0xb2, 0x3c, 0x4d] => Some((false, 1)),
        _ => None,
    }
}

/// Pairs frames of one kind in the sender's and the receiver's capture.
pub(super) fn read(files: &[(PathBuf, Vec<u8>)], kind: u8, gaps: Gaps) -> Result<Trace, TraceError> {
    let [(sender, sent), (receiver, received)] = files else {
        return Err(TraceError::Whole(format!(
            "found {} captures; give two, first the sender's, then the receiver's",
            files.len()
        )));
    };
    let (sent, received) = (sightings(sender, sent, kind)?, sightings(receiver, received, kind)?);
    pair(&sent, &received, gaps).map_err(|problem| {
        TraceError::Whole(format!("{} and {}: {problem}", sender.display(), receiver.display()))
    })
}

fn sightings(file: &Path, bytes: &[u8], kind: u8) -> Result<Vec<Sighting>, TraceError> {
    if bytes.starts_with(&NEXT_GENERATION) {
        return Err(TraceError::file(file, "found pcapng; convert it: editcap -F nsecpcap IN OUT"));
    }
    let header = bytes.first_chunk::<HEADER>();
    let Some((header, (little, unit))) =
        header.and_then(|header| Some((header, shape([header[0], header[1], header[2], header[3]])?)))
    else {
        return Err(TraceError::file(
            file,
            "found no pcap header; give a capture of tcpdump -w or editcap -F pcap",
        ));
    };
    let number = |at: &[u8]| {
        let bytes = [at[0], at[1], at[2], at[3]];
        if little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) }
    };
    // The upper bits tell of frame check sequences.
    let link_type = number(&header[20..]) & 0x0fff_ffff;
    if !matches!(link_type, 1 | 12 | 101 | 113 | 228 | 276) {
        let problem = format!(
            "found link type {link_type}; give Ethernet (1), Linux cooked (113, 276) or raw IP (12, 101, 228)"
        );
        return Err(TraceError::file(file, problem));
    }
    let mut found = Vec::new();
    let mut at = HEADER;
    while at < bytes.len() {
        let record = bytes.get(at..at + RECORD).and_then(|record| {
            let start = at + RECORD;
            Some((record, bytes.get(start..start.checked_add(number(&record[8..]) as usize)?)?))
        });
        let Some((record, packet)) = record else {
            let problem = format!(
                "byte {at}: found part of a packet; the capture was cut off, capture again or shorten it: editcap IN OUT"
            );
            return Err(TraceError::file(file, problem));
        };
        at += RECORD + packet.len();
        let time: Nanoseconds =
            i64::from(number(record)) * 1_000_000_000 + i64::from(number(&record[4..])) * unit;
        let seen = network_layer(link_type, packet).and_then(udp_payload).and_then(frame);
        if let Some((_, tick)) = seen.filter(|(of, _)| *of == kind) {
            found.push(Sighting { number: tick, time });
        }
    }
    if found.is_empty() {
        let problem =
            "found no frame of the kind that --link carries, in UDP over IPv4; see docs/wire-format.md";
        return Err(TraceError::file(file, problem));
    }
    Ok(found)
}

/// The IPv4 packet in a captured one.
fn network_layer(link_type: u32, packet: &[u8]) -> Option<&[u8]> {
    let (protocol, rest) = match link_type {
        1 => {
            let mut rest = packet.get(12..)?;
            while rest.starts_with(&VLAN) {
                rest = rest.get(4..)?;
            }
            (rest.get(..2)?, rest.get(2..)?)
        }
        113 => (packet.get(14..16)?, packet.get(16..)?),
        276 => (packet.get(..2)?, packet.get(20..)?),
        _ => return Some(packet),
    };
    (protocol == IPV4).then_some(rest)
}

fn udp_payload(packet: &[u8]) -> Option<&[u8]> {
    let first = *packet.first()?;
    let fragment = u16::from_be_bytes([*packet.get(6)?, *packet.get(7)?]) & 0x1fff;
    if first >> 4 != 4 || fragment != 0 || *packet.get(9)? != UDP {
        return None;
    }
    packet.get(usize::from(first & 0xf) * 4 + 8..)
}
