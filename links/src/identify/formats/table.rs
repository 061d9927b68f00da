//! A table: a header, then one row per packet; CSV, or with semicolons or tabs.

use super::{
    super::{
        clocks,
        join::Joined,
        logs::Selection,
        pairing,
        time::{self, Nanoseconds},
        trace::{Gaps, Trace, TraceError},
    },
    columns::{Columns, SECOND, columns, delimiter, is_lost, unit, unit_name},
    wraps::renumbered,
};
use csv::{ErrorKind, ReaderBuilder, StringRecord, Trim};
use std::path::Path;

/// Rows by which the unit of times is told.
const FIRST: usize = 1000;
/// Cycles between packets of a tool that probes a link more slowly than the loop sends: least and most.
const PROBES: (f64, f64) = (1.5, 200.0);

/// A row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub(super) number: u64,
    pub(super) sent: Nanoseconds,
    received: Option<Nanoseconds>,
    /// The time of arrival is 0 or -1, which may stand for: never.
    may_be_lost: bool,
    line: u64,
}

/// Reads a table. Without an answer about gaps, missing numbers are losses exactly if no row is marked as lost.
pub(in super::super) fn read(
    file: &Path,
    bytes: &[u8],
    selection: &Selection<'_>,
) -> Result<Trace, TraceError> {
    let mut notes = Vec::new();
    let mut rows = rows(file, bytes, selection, &mut notes)?;
    if rows.is_empty() {
        return Err(TraceError::file(file, "found no packet: give one row per packet below the header"));
    }
    let earliest = rows.iter().map(|row| row.sent).min().unwrap_or(0);
    let (mut standing_for, mut marked) = (0, false);
    for row in &mut rows {
        if row.may_be_lost && row.received.is_some_and(|received| received < earliest) {
            row.received = None;
            standing_for += 1;
        }
        marked |= row.received.is_none();
    }
    if standing_for > 0 {
        notes.push(format!(
            "{standing_for} times of arrival are 0 or -1, before anything was sent: taken as lost"
        ));
    }
    let early = rows.iter().find(|row| row.received.is_some_and(|received| received < row.sent));
    if let (Some(row), None) = (early, selection.shortest_delay) {
        let by = row.sent - row.received.unwrap_or(row.sent);
        return Err(TraceError::line(
            file,
            row.line,
            format!("{}; {}", clocks::early(row.number, by), clocks::ADVICE),
        ));
    }
    renumbered(&mut rows, &mut notes).map_err(|problem| TraceError::file(file, problem))?;

    let all = rows.len();
    // Of rows with the same number the one that arrived first stands.
    rows.sort_by_key(|row| (row.number, row.received.is_none(), row.received));
    rows.dedup_by_key(|row| row.number);
    let mut joined = Joined { duplicates: (all - rows.len()) as u64, ..Joined::default() };
    for row in rows {
        match row.received {
            Some(received) => joined.arrived(row.number, row.sent, received),
            None => joined.packets.push(row.number, row.sent, None),
        }
    }
    let gaps = selection.gaps.unwrap_or(if marked { Gaps::Ignore } else { Gaps::Lost });
    let mut trace =
        pairing::of_one_way(joined, gaps, selection).map_err(|problem| TraceError::file(file, problem))?;
    trace.about.notes.append(&mut notes);
    Ok(trace)
}

fn rows(
    file: &Path,
    bytes: &[u8],
    selection: &Selection<'_>,
    notes: &mut Vec<String>,
) -> Result<Vec<Row>, TraceError> {
    let divider = bytes
        .split(|byte| *byte == b'\n')
        .find(|line| !line.trim_ascii().is_empty() && !line.starts_with(b"#"));
    let divider = delimiter(&String::from_utf8_lossy(divider.unwrap_or_default()));
    let mut builder = ReaderBuilder::new();
    builder.delimiter(divider).trim(Trim::All).comment(Some(b'#'));
    let mut reader = builder.from_reader(bytes);
    let header = reader.headers().map_err(|error| unreadable(file, bytes, &error))?.clone();
    // Semicolons and tabs stand where commas are in the numbers.
    let point = |cell: &str| if divider == b',' { cell.to_string() } else { cell.replace(',', ".") };
    let cells: Vec<String> = header.iter().map(point).collect();
    let columns =
        columns(cells.iter().map(String::as_str)).map_err(|problem| TraceError::line(file, 1, problem))?;
    if columns.is_bare {
        notes.push("found no header: the columns are taken to be sequence,sent,received".into());
        reader = builder.has_headers(false).from_reader(bytes);
    }
    let records: Result<Vec<StringRecord>, _> = reader.records().collect();
    let records = records.map_err(|error| unreadable(file, bytes, &error))?;
    let unit = match selection.unit.or(columns.unit) {
        Some(unit) => unit,
        None => told_unit(&records, &columns, selection, notes)
            .map_err(|problem| TraceError::file(file, problem))?,
    };
    let mut lines = Lines { bytes, at: 0, lines: 0 };
    let row = |record: &StringRecord| {
        let line = lines.of(record.position());
        row(record, &columns, unit, point)
            .map(|row| Row { line, ..row })
            .map_err(|problem| TraceError::line(file, line, problem))
    };
    records.iter().map(row).collect()
}

/// The unit of times that no name tells: seconds, or what fits the cycle.
fn told_unit(
    records: &[StringRecord],
    columns: &Columns,
    selection: &Selection<'_>,
    notes: &mut Vec<String>,
) -> Result<i64, String> {
    let Some(sample_time) = selection.sample_time else { return Ok(SECOND) };
    let number =
        |record: &StringRecord, column: usize| record.get(column)?.replace(',', ".").parse::<f64>().ok();
    let sent =
        |record: &StringRecord| Some((number(record, columns.sequence)?, number(record, columns.sent)?));
    let mut points: Vec<(f64, f64)> = records.iter().take(FIRST).filter_map(sent).collect();
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut steps: Vec<f64> = points
        .windows(2)
        .filter(|pair| pair[1].0 > pair[0].0 && pair[1].1 > pair[0].1)
        .map(|pair| (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0))
        .collect();
    steps.sort_by(f64::total_cmp);
    let Some(&step) = steps.get(steps.len() / 2) else { return Ok(SECOND) };
    match unit(step, sample_time) {
        Some(SECOND) => Ok(SECOND),
        Some(unit) => {
            let name = unit_name(unit);
            notes.push(format!("times are taken to be in {name}, in which packets come once in a cycle; --unit says otherwise"));
            Ok(unit)
        }
        // Slower than the cycle, as tools that probe a link send: no other unit makes sense of that.
        None if (PROBES.0 * sample_time..=PROBES.1 * sample_time).contains(&step) => {
            let cycles = step / sample_time;
            notes.push(format!("times are taken to be in seconds; then packets come once in {cycles:.1} cycles; --unit says otherwise"));
            Ok(SECOND)
        }
        None => Err(format!(
            "packets are {step} apart, which is no cycle of {sample_time} s in seconds, milliseconds, microseconds or nanoseconds; \
             say the unit of the times with --unit s, ms, us or ns, or check --sample-time"
        )),
    }
}

fn row(
    record: &StringRecord,
    columns: &Columns,
    unit: i64,
    point: impl Fn(&str) -> String,
) -> Result<Row, String> {
    let cell = |column: usize| record.get(column).unwrap_or("");
    let time = |name: &str, text: &str| {
        let plain = point(text);
        time::scaled(plain.as_bytes(), unit).or_else(|| time::date(text)).ok_or_else(|| {
            format!(
                "{name}: found \"{text}\"; give {} in decimal, as 12.345678, or a date and time",
                unit_name(unit)
            )
        })
    };
    let text = cell(columns.sequence);
    // pandas makes floating point of a column that once had holes.
    let whole = text
        .split_once(['.', ','])
        .filter(|(_, rest)| rest.bytes().all(|digit| digit == b'0'))
        .map_or(text, |(whole, _)| whole);
    let number: u64 = whole.parse().map_err(|_| {
        format!("sequence: found \"{text}\"; give a whole number from 0, one more per packet")
    })?;
    let sent = time("sent", cell(columns.sent))?;
    let arrival = cell(columns.received);
    let received = match is_lost(arrival) {
        true => None,
        false => Some(
            time("received", arrival).map_err(|problem| format!("{problem}, or nothing if it was lost"))?,
        ),
    };
    let value = point(arrival).parse::<f64>().ok();
    let may_be_lost = matches!(value, Some(0.0 | -1.0));
    Ok(Row { number, sent, received, may_be_lost, line: 0 })
}

/// Lines of rows. The position of a row is where the row before ended: blank lines and comments may follow.
struct Lines<'b> {
    bytes: &'b [u8],
    at: usize,
    lines: u64,
}

impl Lines<'_> {
    fn of(&mut self, position: Option<&csv::Position>) -> u64 {
        let start = position.map_or(0, |position| position.byte() as usize).min(self.bytes.len());
        if start < self.at {
            (self.at, self.lines) = (0, 0);
        }
        self.lines += self.bytes[self.at..start].iter().filter(|byte| **byte == b'\n').count() as u64;
        self.at = start;
        let skipped = self.bytes[start..]
            .split(|byte| *byte == b'\n')
            .take_while(|line| matches!(line, [] | [b'\r'] | [b'#', ..]))
            .count();
        self.lines + skipped as u64 + 1
    }
}

fn unreadable(file: &Path, bytes: &[u8], error: &csv::Error) -> TraceError {
    let line = Lines { bytes, at: 0, lines: 0 }.of(error.position());
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
