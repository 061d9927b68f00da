//! Logs of one link, whatever their format, to traces.

pub use super::formats::recognise::Format;
use super::{
    collector::{Collector, Ends},
    counters::Counter,
    formats::{
        asc::Asc,
        blf,
        candump::Candump,
        candump_view::{self, View},
        capture, irtt,
        message::CanId,
        owping, python_can, read_lines,
        recognise::recognised,
        round_trips, table,
        trc::Trc,
        unreadable,
    },
    source::Source,
    trace::{Gaps, Trace, TraceError},
};
use std::{
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

/// Which packets of the logs to look at, and what is known about the logs besides.
#[derive(Debug, Clone, Default)]
pub struct Selection<'a> {
    /// Format of the logs; `None` recognises it by their content.
    pub format: Option<Format>,
    /// What numbers missing in the sequence are; `None`: in tables without rows of lost packets they are lost, otherwise
    /// ignored.
    pub gaps: Option<Gaps>,
    /// Interface on which packets are sent (CAN logs, captures of several interfaces).
    pub tx: Option<&'a str>,
    /// Interface on which packets are received.
    pub rx: Option<&'a str>,
    /// Identifier of the packets (CAN).
    pub id: Option<CanId>,
    /// UDP port of the packets (captures).
    pub port: Option<u16>,
    /// Kind of frame to look for, as in docs/wire-format.md (CAN logs and captures).
    pub kind: u8,
    /// Where the number of a packet is in its payload; `None` finds it.
    pub counter: Option<Counter>,
    /// Nanoseconds per unit of the times in a table; `None`: seconds, or what fits the sample time.
    pub unit: Option<i64>,
    /// Seconds per cycle, by which the unit of times without one is told.
    pub sample_time: Option<f64>,
    /// Half a round trip is taken for the delay of one way (ping, fping).
    pub halves_round_trips: bool,
    /// The way back is asked for, of tools that measure both (irtt).
    pub is_way_back: bool,
    /// Shortest delay of the link in nanoseconds, by which two clocks are brought together.
    pub shortest_delay: Option<i64>,
}

/// A log: its name, and its bytes from the beginning.
struct Log<'r> {
    name: &'r Path,
    input: Box<dyn Read + 'r>,
}

/// Reads logs of one link: tables (each a run of its own), CAN logs (together one), captures, or what a measuring tool wrote.
///
/// # Errors
/// A log that cannot be read, with the line where there is one.
pub fn read(paths: &[PathBuf], selection: &Selection<'_>) -> Result<Vec<Trace>, TraceError> {
    read_and_tell(paths, selection, &|_| ())
}

/// As [`read`], and tells how many bytes more of the files were read.
///
/// # Errors
/// As [`read`].
pub fn read_and_tell(
    paths: &[PathBuf],
    selection: &Selection<'_>,
    told: &dyn Fn(u64),
) -> Result<Vec<Trace>, TraceError> {
    let open = |path: &'_ PathBuf| File::open(path).map_err(|error| unreadable(path, &error));
    let logs: Result<Vec<Log<'_>>, _> = paths
        .iter()
        .map(|path| Ok(Log { name: path.as_path(), input: Box::new(Counted { file: open(path)?, told }) }))
        .collect();
    of(logs?, selection)
}

/// A file that tells how much of it is read.
struct Counted<'t> {
    file: File,
    told: &'t dyn Fn(u64),
}

impl Read for Counted<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let read = self.file.read(buffer)?;
        (self.told)(read as u64);
        Ok(read)
    }
}

/// As [`read`], of logs whose bytes are there already, each with its name.
///
/// # Errors
/// As [`read`].
pub fn traces(logs: &[(PathBuf, Vec<u8>)], selection: &Selection<'_>) -> Result<Vec<Trace>, TraceError> {
    let logs =
        logs.iter().map(|(name, bytes)| Log { name: name.as_path(), input: Box::new(bytes.as_slice()) });
    of(logs.collect(), selection)
}

fn of(logs: Vec<Log<'_>>, selection: &Selection<'_>) -> Result<Vec<Trace>, TraceError> {
    let mut sources = Vec::new();
    for log in logs {
        let source = Source::new(log.input).map_err(|error| unreadable(log.name, &error))?;
        let format = match selection.format {
            Some(format) => format,
            None => recognised(source.head()).map_err(|problem| TraceError::file(log.name, problem))?,
        };
        let is_same = |(_, _, other): &&(&Path, Format, Source<'_>)| other.head() == source.head();
        if let Some((other, ..)) = sources.iter().find(is_same) {
            let problem =
                format!("begins as {} does, so it is the same log; give each once", other.display());
            return Err(TraceError::file(log.name, problem));
        }
        sources.push((log.name, format, source));
    }
    let Some(&(first, format, _)) = sources.first() else {
        return Err(TraceError::Whole("no logs to read; give at least one".into()));
    };
    if let Some((name, other, _)) = sources.iter().find(|(_, other, _)| *other != format) {
        let problem =
            format!("is of another format ({}) than {} ({})", other.name(), first.display(), format.name());
        return Err(TraceError::file(name, format!("{problem}; give logs of one format")));
    }
    let mut traces = match format {
        Format::Csv | Format::Irtt | Format::Owping | Format::Ping | Format::Fping => {
            let runs = sources.into_iter().map(|(name, format, source)| run(name, format, source, selection));
            runs.collect::<Result<Vec<_>, _>>()?
        }
        _ => vec![link(sources, format, selection)?],
    };
    traces.iter_mut().for_each(|trace| trace.about.format = format.name());
    Ok(traces)
}

/// A log that is a run of its own.
fn run(
    file: &Path,
    format: Format,
    source: Source<'_>,
    selection: &Selection<'_>,
) -> Result<Trace, TraceError> {
    let bytes = source.rest().map_err(|error| unreadable(file, &error))?;
    match format {
        Format::Irtt => irtt::read(file, &bytes, selection),
        Format::Owping => owping::read(file, &bytes, selection),
        Format::Ping => round_trips::read(file, &bytes, round_trips::Tool::Ping, selection),
        Format::Fping => round_trips::read(file, &bytes, round_trips::Tool::Fping, selection),
        _ => table::read(file, &bytes, selection),
    }
}

/// Logs that are together one.
fn link(
    sources: Vec<(&Path, Format, Source<'_>)>,
    format: Format,
    selection: &Selection<'_>,
) -> Result<Trace, TraceError> {
    let files: Vec<&Path> = sources.iter().map(|(name, ..)| *name).collect();
    let ends = ends(&files, format, selection)?;
    let mut collector = Collector::new(files.clone(), ends, selection);
    let begin_at_zero = match format {
        Format::Asc | Format::Trc => true,
        Format::CandumpView => {
            sources.iter().all(|(_, _, source)| candump_view::begins_at_zero(source.head()))
        }
        _ => false,
    };
    if begin_at_zero && files.len() > 1 {
        return Err(TraceError::Whole(format!(
            "found {} logs of {} whose times each begin at 0: nothing tells how they belong together; log both ends into one \
             file, or with absolute times",
            files.len(),
            format.name()
        )));
    }
    for (index, (file, _, source)) in sources.into_iter().enumerate() {
        collector.begin_file(index);
        let data = [0; 64];
        match format {
            Format::Candump => read_lines(file, source, Candump { data }, &mut collector)?,
            Format::CandumpView => {
                let view = View::new(source.head());
                read_lines(file, source, view, &mut collector)?;
            }
            Format::Asc => read_lines(file, source, Asc::new(), &mut collector)?,
            Format::Trc => read_lines(file, source, Trc::new(), &mut collector)?,
            Format::PythonCanText => read_lines(file, source, python_can::Printed { data }, &mut collector)?,
            Format::PythonCanCsv => read_lines(file, source, python_can::Csv { data }, &mut collector)?,
            Format::Blf => blf::read(file, source, &mut collector)?,
            _ => capture::read(file, source, &mut collector)?,
        }
    }
    collector.finish()
}

/// How sender and receiver are told apart.
fn ends<'s>(files: &[&Path], format: Format, selection: &Selection<'s>) -> Result<Ends<'s>, TraceError> {
    match (format, selection.tx.zip(selection.rx), files) {
        (Format::PythonCanCsv, _, [_, _]) => Ok(Ends::Files),
        (Format::PythonCanCsv, ..) => Err(TraceError::file(
            files[0],
            "is CSV of python-can, which has no channel and no direction: who sent and who received cannot be told; give two files, \
             first the sender's, then the receiver's, or log to a .log file",
        )),
        (Format::Pcap, None, [_, _]) => Ok(Ends::Files),
        (Format::Pcap, None, [_]) => Ok(Ends::Order),
        (Format::Pcap, None, _) => Err(TraceError::Whole(format!(
            "found {} captures; give two, first the sender's, then the receiver's",
            files.len()
        ))),
        (_, Some((tx, rx)), _) => Ok(Ends::Interfaces { tx, rx }),
        (_, None, _) => Err(TraceError::file(
            files[0],
            format!(
                "is a log of {}, which needs --tx IFACE and --rx IFACE: on which interface or channel packets are sent, and on which \
                 they are received",
                format.name()
            ),
        )),
    }
}
