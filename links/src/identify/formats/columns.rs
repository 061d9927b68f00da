//! The columns of a table: which they are, what divides them, and in which unit times are.

use super::super::time;

pub(super) const SECOND: i64 = 1_000_000_000;

/// Names of columns, in small letters. The first one is the documented one.
const SEQUENCE: [&str; 9] =
    ["sequence", "seq", "seqno", "seq_no", "sequence_number", "number", "packet", "counter", "packet_id"];
const SENT: [&str; 12] = [
    "sent",
    "tx",
    "tx_time",
    "t_tx",
    "sent_time",
    "time_sent",
    "send_time",
    "sent_at",
    "t_sent",
    "send",
    "send_timestamp",
    "tx_timestamp",
];
const RECEIVED: [&str; 14] = [
    "received",
    "rx",
    "rx_time",
    "t_rx",
    "recv",
    "received_time",
    "time_received",
    "receive_time",
    "recv_time",
    "received_at",
    "t_received",
    "arrived",
    "recv_timestamp",
    "rx_timestamp",
];

/// Where the three columns are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Columns {
    pub(super) sequence: usize,
    pub(super) sent: usize,
    pub(super) received: usize,
    /// Nanoseconds per unit of the times, where a name tells: `sent_us`.
    pub(super) unit: Option<i64>,
    /// There is no header: the first row is a packet.
    pub(super) is_bare: bool,
}

/// What divides the cells of a line: semicolons, tabs, bars, commas, or blanks where nothing else does.
pub(super) fn delimiter(line: &str) -> u8 {
    let count = |delimiter: char| line.chars().filter(|letter| *letter == delimiter).count();
    // A comma may be in a number, where semicolons or tabs divide.
    let others = [';', '\t', '|', ',', ' '];
    others.into_iter().find(|delimiter| count(*delimiter) >= 2).map_or(b',', |delimiter| delimiter as u8)
}

/// The columns by the cells of the first line.
pub(super) fn columns<'c>(cells: impl Iterator<Item = &'c str> + Clone) -> Result<Columns, String> {
    let found: Vec<(String, Option<i64>)> = cells.clone().map(named).collect();
    let column = |names: &[&str]| {
        // The documented name comes before the others.
        names.iter().find_map(|name| found.iter().position(|(cell, _)| cell == name))
    };
    match (column(&SEQUENCE), column(&SENT), column(&RECEIVED)) {
        (Some(sequence), Some(sent), Some(received)) => {
            let (unit, other) = (found[sent].1, found[received].1);
            if unit != other {
                return Err("found times in two units; give sent and received in one".into());
            }
            Ok(Columns { sequence, sent, received, unit, is_bare: false })
        }
        _ if is_bare(cells.clone()) => {
            Ok(Columns { sequence: 0, sent: 1, received: 2, unit: None, is_bare: true })
        }
        _ => {
            let names: Vec<&str> = cells.collect();
            Err(format!(
                "found the columns \"{}\"; give a header with sequence,sent,received",
                names.join(",")
            ))
        }
    }
}

/// A name in small letters, and the unit behind it: `Sent (us)`, `sent_us`, `sent[us]`.
fn named(cell: &str) -> (String, Option<i64>) {
    let name =
        cell.trim_start_matches('\u{feff}').trim().trim_matches('"').to_lowercase().replace([' ', '-'], "_");
    let bare = name.trim_end_matches([')', ']']);
    for (suffix, unit) in [("ns", 1), ("us", 1000), ("µs", 1000), ("ms", 1_000_000), ("s", SECOND)] {
        let before = bare.strip_suffix(suffix).and_then(|rest| rest.strip_suffix(['_', '(', '[']));
        if let Some(before) = before {
            return (before.trim_end_matches('_').to_string(), Some(unit));
        }
    }
    (name, None)
}

/// Three numbers, the first a whole one: a table without a header.
fn is_bare<'c>(cells: impl Iterator<Item = &'c str>) -> bool {
    let cells: Vec<&str> = cells.collect();
    let is_time = |cell: &str| time::parse(cell).is_some();
    matches!(cells.as_slice(), [sequence, sent, received]
        if sequence.parse::<u64>().is_ok() && is_time(sent) && (is_time(received) || is_lost(received)))
}

/// Whether a cell says that a packet did not arrive.
pub(super) fn is_lost(cell: &str) -> bool {
    let lost = ["", "lost", "nan", "na", "n/a", "<na>", "none", "null", "nat", "-", "inf", "-inf"];
    lost.iter().any(|word| cell.eq_ignore_ascii_case(word))
}

/// The unit that makes packets of successive numbers, `step` units apart, one cycle apart: seconds unless they would be far
/// from it.
pub(super) fn unit(step: f64, sample_time: f64) -> Option<i64> {
    let cycles = |unit: i64| step * unit as f64 / 1e9 / sample_time;
    if cycles(SECOND) < 20.0 {
        return Some(SECOND);
    }
    [1_000_000, 1000, 1].into_iter().find(|unit| (0.8..1.25).contains(&cycles(*unit)))
}

/// The name of a unit.
pub(super) fn unit_name(unit: i64) -> &'static str {
    match unit {
        1 => "nanoseconds",
        1000 => "microseconds",
        1_000_000 => "milliseconds",
        _ => "seconds",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(header: &str) -> Result<Columns, String> {
        let delimiter = char::from(delimiter(header));
        columns(header.split(delimiter))
    }

    #[test]
    fn columns_are_found_by_any_usual_name() {
        for header in [
            "sequence,sent,received",
            "Sequence;Sent;Received",
            "seq\ttx_time\trx_time",
            "seq|tx|rx",
            "seq sent received",
        ] {
            assert_eq!(found(header).map(|columns| columns.received), Ok(2), "{header}");
        }
        assert_eq!(
            found("a,received_us,sequence,sent [us]").map(|columns| (columns.sent, columns.unit)),
            Ok((3, Some(1000)))
        );
        assert_eq!(found("5,0.5,NaN").map(|columns| columns.is_bare), Ok(true));
        assert!(found("sequence,sent_ms,received_us").is_err() && found("a,b,c").is_err());
    }

    #[test]
    fn the_unit_is_the_one_that_fits_the_cycle() {
        assert_eq!(
            (unit(1e4, 0.01), unit(1e7, 0.01), unit(10.0, 0.01)),
            (Some(1000), Some(1), Some(1_000_000))
        );
        assert_eq!((unit(0.02, 0.01), unit(77.0, 0.01)), (Some(SECOND), None));
    }
}
