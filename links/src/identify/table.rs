//! CSV: a header, then one row per packet.

use super::{
    time,
    trace::{Gaps, Packet, Trace, TraceError, early},
};
use csv::{ErrorKind, ReaderBuilder, StringRecord, Trim};
use std::path::Path;

/// Where the three columns are.
struct Columns {
    sequence: usize,
    sent: usize,
    received: usize,
}

/// Reads a table. Without an answer in `gaps`, missing numbers are losses exactly if no row is marked as lost.
pub(super) fn read(file: &Path, bytes: &[u8], gaps: Option<Gaps>) -> Result<Trace, TraceError> {
    let mut reader = ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).from_reader(bytes);
    let header = reader.headers().map_err(|error| unreadable(file, bytes, &error))?.clone();
    let columns = columns(&header).map_err(|problem| TraceError::line(file, 1, problem))?;
    let mut packets = Vec::new();
    for row in reader.records() {
        let row = row.map_err(|error| unreadable(file, bytes, &error))?;
        packets.push(
            packet(&row, &columns)
                .map_err(|problem| TraceError::line(file, line(bytes, row.position()), problem))?,
        );
    }
    if packets.is_empty() {
        return Err(TraceError::file(file, "found no packet: give one row per packet below the header"));
    }

    let rows = packets.len();
    // Of rows with the same number the one that arrived first stands.
    packets.sort_by_key(|packet| (packet.sequence, packet.received.is_none(), packet.received));
    packets.dedup_by_key(|packet| packet.sequence);
    let marked = packets.iter().any(|packet| packet.received.is_none());
    let mut trace = Trace { duplicates: (rows - packets.len()) as u64, packets, ..Trace::default() };
    let gaps = gaps.unwrap_or(if marked { Gaps::Ignore } else { Gaps::Lost });
    trace.fill(gaps).map_err(|problem| TraceError::file(file, problem))?;
    Ok(trace)
}

fn columns(header: &StringRecord) -> Result<Columns, String> {
    let column = |name: &str| {
        header.iter().position(|cell| cell.trim_start_matches('\u{feff}') == name).ok_or_else(|| {
            let found: Vec<&str> = header.iter().collect();
            format!("found the columns \"{}\"; give a header with sequence,sent,received", found.join(","))
        })
    };
    Ok(Columns { sequence: column("sequence")?, sent: column("sent")?, received: column("received")? })
}

fn packet(row: &StringRecord, columns: &Columns) -> Result<Packet, String> {
    let cell = |column: usize| row.get(column).unwrap_or("");
    let time = |name: &str, text: &str| {
        time::parse(text)
            .ok_or_else(|| format!("{name}: found \"{text}\"; give seconds in decimal, as 12.345678"))
    };
    let sequence = cell(columns.sequence);
    let sequence: u64 = sequence.parse().map_err(|_| {
        format!("sequence: found \"{sequence}\"; give a whole number from 0, one more per packet")
    })?;
    let sent = time("sent", cell(columns.sent))?;
    let received = match cell(columns.received) {
        "" | "lost" => None,
        text => {
            Some(time("received", text).map_err(|problem| format!("{problem}, or nothing if it was lost"))?)
        }
    };
    match received.and_then(|received| early(sequence, sent, received)) {
        Some(problem) => Err(problem),
        None => Ok(Packet { sequence, sent: Some(sent), received }),
    }
}

/// The line of a row. Its position is where the row before ended: blank lines and comments may follow.
fn line(bytes: &[u8], position: Option<&csv::Position>) -> u64 {
    let start = position.map_or(0, |position| position.byte() as usize).min(bytes.len());
    let begins = bytes[..start].iter().filter(|byte| **byte == b'\n').count();
    let skipped = bytes[start..]
        .split(|byte| *byte == b'\n')
        .take_while(|line| matches!(line, [] | [b'\r'] | [b'#', ..]))
        .count();
    (begins + skipped) as u64 + 1
}

fn unreadable(file: &Path, bytes: &[u8], error: &csv::Error) -> TraceError {
    let line = line(bytes, error.position());
    let problem = match error.kind() {
        ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!(
                "found {len} cells; give {expected_len}, as in the header (received is empty if the packet was lost)"
            )
        }
        ErrorKind::Utf8 { .. } => "found bytes that are no text; give a CSV file in UTF-8".to_string(),
        _ => error.to_string(),
    };
    TraceError::line(file, line, problem)
}
