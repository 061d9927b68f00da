//! Logs of one link, whatever their format, to traces.

use super::{
    candump, capture, table,
    trace::{Gaps, Trace, TraceError},
};
use std::{fs, path::PathBuf};

/// Formats of logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Header with sequence,sent,received, then a row per packet.
    Csv,
    /// Lines of `candump -L`.
    Candump,
    /// Classic pcap.
    Pcap,
}

/// Which packets of the logs to look at.
#[derive(Debug, Clone, Copy)]
pub struct Selection<'a> {
    /// Format of the logs; `None` recognises it by their content.
    pub format: Option<Format>,
    /// What numbers missing in the sequence are; `None`: in tables without rows of lost packets they are lost, otherwise
    /// ignored.
    pub gaps: Option<Gaps>,
    /// Interface on which packets are sent (candump).
    pub tx: Option<&'a str>,
    /// Interface on which packets are received (candump).
    pub rx: Option<&'a str>,
    /// Identifier of the packets (candump).
    pub id: Option<u32>,
    /// Kind of frame to look for, as in docs/wire-format.md (candump and captures).
    pub kind: u8,
}

/// Reads logs of one link: tables (each a run of its own), logs of candump (together one), or two captures.
///
/// # Errors
/// A log that cannot be read, with the line where there is one.
pub fn read(paths: &[PathBuf], selection: &Selection<'_>) -> Result<Vec<Trace>, TraceError> {
    let mut logs = Vec::new();
    for path in paths {
        let bytes =
            fs::read(path).map_err(|error| TraceError::file(path, format!("cannot read it: {error}")))?;
        logs.push((path.clone(), bytes));
    }
    traces(&logs, selection)
}

/// As [`read`], of logs whose bytes are there already, each with its name.
///
/// # Errors
/// As [`read`].
pub fn traces(logs: &[(PathBuf, Vec<u8>)], selection: &Selection<'_>) -> Result<Vec<Trace>, TraceError> {
    let formats: Vec<Format> =
        logs.iter().map(|(_, bytes)| selection.format.unwrap_or_else(|| recognised(bytes))).collect();
    if let Some(other) = formats.iter().position(|format| *format != formats[0]) {
        return Err(TraceError::file(
            &logs[other].0,
            "is of another format than the first log; give logs of one format",
        ));
    }
    let gaps = selection.gaps.unwrap_or(Gaps::Ignore);
    match formats.first() {
        None => Err(TraceError::Whole("no logs to read; give at least one".into())),
        Some(Format::Csv) => {
            logs.iter().map(|(file, bytes)| table::read(file, bytes, selection.gaps)).collect()
        }
        Some(Format::Pcap) => Ok(vec![capture::read(logs, selection.kind, gaps)?]),
        Some(Format::Candump) => {
            let (Some(tx), Some(rx)) = (selection.tx, selection.rx) else {
                let problem =
                    "candump logs need --tx IFACE and --rx IFACE: where packets are sent and where received";
                return Err(TraceError::file(&logs[0].0, problem));
            };
            if tx == rx {
                return Err(TraceError::Whole("--tx and --rx are the same interface; give two".into()));
            }
            let selection = candump::Selection { tx, rx, id: selection.id, kind: selection.kind, gaps };
            Ok(vec![candump::read(logs, &selection)?])
        }
    }
}

fn recognised(bytes: &[u8]) -> Format {
    if capture::looks_like_one(bytes) {
        Format::Pcap
    } else if bytes.trim_ascii_start().starts_with(b"(") {
        Format::Candump
    } else {
        Format::Csv
    }
}
