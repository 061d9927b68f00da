//! Logs of `candump -L`: `(seconds) interface id#data`, CAN FD as `id##` with one digit of flags before the data.

use super::{
    pairing::{Sighting, counter, frame, pair},
    time::{self, Nanoseconds},
    trace::{Gaps, Trace, TraceError},
};
use std::path::{Path, PathBuf};

/// What to look for in the logs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Selection<'a> {
    /// Interface on which the packets are sent.
    pub(super) tx: &'a str,
    /// Interface on which they are received.
    pub(super) rx: &'a str,
    /// Identifier, or any.
    pub(super) id: Option<u32>,
    /// Kind of frame, where the payload begins as a frame.
    pub(super) kind: u8,
    pub(super) gaps: Gaps,
}

/// A line of a log.
#[derive(Debug, PartialEq, Eq)]
struct Line<'a> {
    time: Nanoseconds,
    interface: &'a str,
    id: u32,
    /// Empty for a remote frame.
    data: Vec<u8>,
}

/// Reads logs that belong together: of both interfaces, in one file or in several.
pub(super) fn read(files: &[(PathBuf, Vec<u8>)], selection: &Selection<'_>) -> Result<Trace, TraceError> {
    let (mut sent, mut received) = (Vec::new(), Vec::new());
    for (file, bytes) in files {
        let text = std::str::from_utf8(bytes).map_err(|_| {
            TraceError::file(file, "found bytes that are no text; give the output of candump -L")
        })?;
        collect(file, text, selection, &mut sent, &mut received)?;
    }
    let whole = |problem: String| match files {
        [(file, _)] => TraceError::file(file, problem),
        _ => TraceError::Whole(problem),
    };
    if sent.is_empty() {
        return Err(whole(format!("found no frame on {} to pair; check --tx and --id", selection.tx)));
    }
    // Either all payloads are frames or none is: a counter looks like the begin of a frame now and then.
    let is_frame = sent.iter().all(|(_, payload)| frame(payload).is_some());
    let sightings = |seen: &[(Nanoseconds, Vec<u8>)]| -> Vec<Sighting> {
        let number = |payload: &[u8]| match is_frame {
            true => frame(payload).filter(|(kind, _)| *kind == selection.kind).map(|(_, tick)| tick),
            false => counter(payload),
        };
        seen.iter()
            .filter_map(|(time, payload)| Some(Sighting { number: number(payload)?, time: *time }))
            .collect()
    };
    let (sent, received) = (sightings(&sent), sightings(&received));
    if sent.is_empty() {
        return Err(whole(format!("no frame on {} is of the kind that --link carries", selection.tx)));
    }
    pair(&sent, &received, selection.gaps).map_err(whole)
}

fn collect(
    file: &Path,
    text: &str,
    selection: &Selection<'_>,
    sent: &mut Vec<(Nanoseconds, Vec<u8>)>,
    received: &mut Vec<(Nanoseconds, Vec<u8>)>,
) -> Result<(), TraceError> {
    for (index, text) in text.lines().enumerate() {
        if text.trim().is_empty() {
            continue;
        }
        let wrong = |problem: String| TraceError::line(file, index as u64 + 1, problem);
        let line = line(text).ok_or_else(|| {
            wrong(format!(
                "found \"{text}\"; give lines of candump -L, as (1436509052.249713) can0 123#0102030405060708"
            ))
        })?;
        if selection.id.is_some_and(|id| id != line.id) {
            continue;
        }
        let end = match line.interface {
            name if name == selection.tx => &mut *sent,
            name if name == selection.rx => &mut *received,
            _ => continue,
        };
        if line.data.len() < 4 {
            if selection.id.is_none() {
                continue;
            }
            return Err(wrong(format!(
                "found a frame of {} bytes; packets are paired by a frame's tick or a counter in the first 4 bytes",
                line.data.len()
            )));
        }
        end.push((line.time, line.data));
    }
    Ok(())
}

fn line(text: &str) -> Option<Line<'_>> {
    let mut words = text.split_whitespace();
    let time = time::parse(words.next()?.strip_prefix('(')?.strip_suffix(')')?)?;
    let (interface, (id, data)) = (words.next()?, words.next()?.split_once('#')?);
    // candump -x adds the direction.
    if !matches!((words.next(), words.next()), (None | Some("T" | "R"), None)) {
        return None;
    }
    let id = u32::from_str_radix(id, 16).ok()?;
    if let Some(remote) = data.strip_prefix('R') {
        let plain = remote.bytes().all(|byte| byte.is_ascii_digit());
        return plain.then_some(Line { time, interface, id, data: Vec::new() });
    }
    let (digits, most) = match data.strip_prefix('#') {
        Some(flexible) => {
            let flags = flexible.get(..1)?;
            u8::from_str_radix(flags, 16).ok()?;
            (&flexible[1..], 64)
        }
        // A classic frame may name its raw length after the data.
        None => (data.split('_').next()?, 8),
    };
    let digits = digits.as_bytes();
    let nibble = |digit: u8| (digit as char).to_digit(16).map(|digit| digit as u8);
    let data: Option<Vec<u8>> = digits
        .chunks(2)
        .map(|pair| match *pair {
            [high, low] => Some(nibble(high)? << 4 | nibble(low)?),
            _ => None,
        })
        .collect();
    data.filter(|data| data.len() <= most).map(|data| Line { time, interface, id, data })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classic_flexible_and_remote_frames_are_read() {
        let classic = line("(1436509052.249713) vcan0 123#0102a0FF").expect("classic");
        assert_eq!(
            (classic.time, classic.interface, classic.id),
            (1_436_509_052_249_713_000, "vcan0", 0x123)
        );
        assert_eq!(classic.data, [1, 2, 0xa0, 0xff]);
        let flexible = line("(0.5) can1 18DAF110##1000102030405060708 R").expect("CAN FD");
        assert_eq!((flexible.id, flexible.data.len()), (0x18da_f110, 9));
        assert!(line("(0.5) can1 123#R8").expect("remote").data.is_empty());
    }

    #[test]
    fn other_lines_are_refused() {
        for wrong in [
            "vcan0  123   [4]  01 02 03 04",
            "(1.5) vcan0",
            "(1.5 vcan0 123#00",
            "(1.5) vcan0 xyz#00",
            "(1.5) vcan0 123#0",
            "(1.5) vcan0 123#0g",
            "(1.5) vcan0 123##",
            "(1.5) vcan0 123#000102030405060708",
            "(1.5) vcan0 123#00 T x",
            "(1.5) vcan0 123#é",
        ] {
            assert_eq!(line(wrong), None, "{wrong}");
        }
    }
}
