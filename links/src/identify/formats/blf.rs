//! Vector BLF: a header, then objects; most are containers, packed with zlib, of further objects.
//!
//! Layout after python-can's reader (`can/io/blf.py`) and Vector's published structures. Numbers are little-endian.

use super::{
    super::{
        about::Skip,
        collector::Collector,
        source::Source,
        time::{Nanoseconds, to_microseconds},
        trace::TraceError,
    },
    message::{Direction, Message, Stream},
    unreadable,
    words::can_id,
};
use flate2::read::ZlibDecoder;
use std::{io::Read, path::Path};

const SIGNATURE: [u8; 4] = *b"LOBJ";
/// Signature, length of the header, version, length of the object, type.
const BASE: usize = 16;
/// Of a container: how it is packed, and its unpacked length.
const CONTAINER: usize = 16;
/// No container is longer, packed or not.
const LONGEST: usize = 1 << 26;

mod kind {
    pub(super) const MESSAGE: u32 = 1;
    pub(super) const ERROR: u32 = 2;
    pub(super) const CONTAINER: u32 = 10;
    pub(super) const ERROR_EXTENDED: u32 = 73;
    pub(super) const MESSAGE_2: u32 = 86;
    pub(super) const FLEXIBLE: u32 = 100;
    pub(super) const FLEXIBLE_64: u32 = 101;
    pub(super) const FLEXIBLE_ERROR: u32 = 104;
}

pub(in super::super) fn read(
    file: &Path,
    source: Source<'_>,
    collector: &mut Collector<'_>,
) -> Result<(), TraceError> {
    let wrong = |problem: &str| TraceError::file(file, format!("{problem}: the BLF file is damaged"));
    let mut input = source.into_read();
    let mut header = [0; 8];
    input.read_exact(&mut header).map_err(|error| unreadable(file, &error))?;
    let rest = u64::from(number(&header, 4)).saturating_sub(8);
    std::io::copy(&mut input.by_ref().take(rest), &mut std::io::sink())
        .map_err(|error| unreadable(file, &error))?;
    // Objects may begin in one container and end in the next.
    let mut held: Vec<u8> = Vec::new();
    loop {
        let mut base = [0; BASE];
        match fill(&mut input, &mut base).map_err(|error| unreadable(file, &error))? {
            0 => break,
            BASE => {}
            _ => {
                collector.skip(Skip::Cut);
                break;
            }
        }
        let length = number(&base, 8) as usize;
        if base[..4] != SIGNATURE || !(BASE..=LONGEST).contains(&length) {
            return Err(wrong("found no object where one should begin"));
        }
        // What is between objects is filled to whole words.
        let mut object = Vec::new();
        let body = (length - BASE + length % 4) as u64;
        input.by_ref().take(body).read_to_end(&mut object).map_err(|error| unreadable(file, &error))?;
        if object.len() < length - BASE {
            collector.skip(Skip::Cut);
            break;
        }
        object.truncate(length - BASE);
        if number(&base, 12) != kind::CONTAINER {
            held.extend_from_slice(&base);
            held.extend_from_slice(&object);
        } else if object.len() >= CONTAINER {
            let packed = &object[CONTAINER..];
            match object[0] {
                0 => held.extend_from_slice(packed),
                2 => {
                    let unpacked = ZlibDecoder::new(packed).take(LONGEST as u64).read_to_end(&mut held);
                    unpacked.map_err(|_| wrong("found a container that cannot be unpacked"))?;
                }
                _ => return Err(wrong("found a container packed in an unknown way")),
            }
        }
        let taken = objects(&held, collector);
        held.drain(..taken);
        collector.decide_if_enough()?;
    }
    if held.len() >= BASE {
        collector.skip(Skip::Cut);
    }
    Ok(())
}

/// Reads until the buffer is full or nothing more comes; how much came.
fn fill(input: &mut impl Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    let mut there = 0;
    while there < buffer.len() {
        match input.read(&mut buffer[there..])? {
            0 => break,
            read => there += read,
        }
    }
    Ok(there)
}

/// Takes the objects that are whole; how many bytes they have.
fn objects(bytes: &[u8], collector: &mut Collector<'_>) -> usize {
    let mut at = 0;
    loop {
        let Some(found) = memchr::memmem::find(&bytes[at..], &SIGNATURE) else {
            // A signature may have begun.
            return bytes.len() - bytes.len().min(SIGNATURE.len() - 1).min(bytes.len() - at);
        };
        let begin = at + found;
        let rest = &bytes[begin..];
        if rest.len() < BASE {
            return begin;
        }
        let length = number(rest, 8) as usize;
        if !(BASE..=LONGEST).contains(&length) {
            at = begin + SIGNATURE.len();
            continue;
        }
        let Some(object) = rest.get(..length) else { return begin };
        take(object, collector);
        at = begin + length;
    }
}

fn take(object: &[u8], collector: &mut Collector<'_>) {
    let header = usize::from(short(object, 4));
    let Some(body) = object.get(header..) else { return collector.skip(Skip::Comment) };
    match number(object, 12) {
        kind::ERROR | kind::ERROR_EXTENDED | kind::FLEXIBLE_ERROR => collector.skip(Skip::Error),
        of @ (kind::MESSAGE | kind::MESSAGE_2 | kind::FLEXIBLE | kind::FLEXIBLE_64) => {
            match time(object).ok_or(Skip::Comment).and_then(|time| frame(of, time, body)) {
                Ok((channel, message)) => {
                    let channel = channel.to_string();
                    collector.message(&Message { interface: channel.as_bytes(), ..message });
                }
                Err(skip) => collector.skip(skip),
            }
        }
        _ => collector.skip(Skip::Comment),
    }
}

/// Units are 10 us or 1 ns. Loggers cut times that were binary fractions: 10 ms become 9 999 990 ns.
fn time(object: &[u8]) -> Option<Nanoseconds> {
    let flags = object.get(BASE..BASE + 4).map(|_| number(object, BASE))?;
    let ticks = u64::from_le_bytes(*object.get(BASE + 8..)?.first_chunk()?);
    let unit = if flags == 1 { 10_000 } else { 1 };
    let time = i64::try_from(ticks).ok()?.checked_mul(unit)?;
    (time < i64::MAX / 2).then(|| to_microseconds(time))
}

/// The channel and the frame of an object, without its interface.
fn frame(of: u32, time: Nanoseconds, body: &[u8]) -> Result<(u16, Message<'_>), Skip> {
    const SENT: u8 = 1;
    const REMOTE: u8 = 0x80;
    const EXTENDED: u32 = 1 << 31;
    const REMOTE_64: u32 = 0x10;
    // The lengths of the parts before the data.
    let data_at = match of {
        kind::FLEXIBLE => 20,
        kind::FLEXIBLE_64 => 40,
        _ => 8,
    };
    let data = body.get(data_at..).ok_or(Skip::Short)?;
    let (channel, is_sent, is_remote, id, count) = match of {
        kind::FLEXIBLE => {
            (short(body, 0), body[2] & SENT != 0, body[2] & REMOTE != 0, number(body, 4), body[14])
        }
        kind::FLEXIBLE_64 => (
            u16::from(body[0]),
            body[34] == SENT,
            number(body, 12) & REMOTE_64 != 0,
            number(body, 4),
            body[2],
        ),
        _ => (short(body, 0), body[2] & SENT != 0, body[2] & REMOTE != 0, number(body, 4), body[3].min(8)),
    };
    if is_remote {
        return Err(Skip::Remote);
    }
    Ok((
        channel,
        Message {
            time,
            interface: b"",
            direction: Some(if is_sent { Direction::Sent } else { Direction::Heard }),
            stream: Stream::Can(can_id(id, id & EXTENDED != 0)),
            data: &data[..data.len().min(usize::from(count))],
        },
    ))
}

fn short(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn number(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
