//! Options of `host-sim identify`, and what it does.

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use slqg_links::identify::{
    counters::Counter,
    figures::Figures,
    formats::message::CanId,
    fragment::fragment,
    logs::{self, Selection},
    sample::{Clock, LONGEST},
    trace::{Gaps, TraceError},
};
use std::{fs, path::PathBuf};

/// Options of the command line.
#[derive(Debug, Args)]
pub struct Options {
    /// Logs of one link: tables and logs of measuring tools (each a run of its own), CAN logs (together one log), or two
    /// captures, the sender's and the receiver's. docs/traces.md lists the formats; gzip and zstd are unpacked.
    #[arg(required = true, value_name = "TRACE")]
    traces: Vec<PathBuf>,
    /// Length of a control cycle in seconds: the design's plant.sample_time.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    sample_time: f64,
    /// Time from the begin of a cycle to the sending of its packet, if the receiver takes packets at the end of a cycle; see
    /// docs/traces.md if it does so earlier.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = not_negative)]
    offset: f64,
    /// Count packets that are later than this as lost.
    #[arg(long, value_name = "CYCLES", default_value_t = LONGEST as u16, value_parser = clap::value_parser!(u16).range(0..=LONGEST as i64))]
    longest: u16,
    /// The link of the design file; in candump logs and captures also the kind of frame to look for.
    #[arg(long, value_enum, default_value_t = Link::ControllerToActuator)]
    link: Link,
    /// Format of the logs, where it is not to be recognised by their content.
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// What numbers missing in the sequence are. In CSV tables without rows of lost packets they are lost, otherwise ignored.
    #[arg(long, value_enum)]
    gaps: Option<GapsName>,
    /// Interface or channel on which packets are sent (CAN logs, captures with several interfaces).
    #[arg(long, value_name = "IFACE")]
    tx: Option<String>,
    /// Interface or channel on which packets are received; if it is the same, the log's directions tell the ends apart.
    #[arg(long, value_name = "IFACE")]
    rx: Option<String>,
    /// Identifier of the packets (CAN): up to three digits have 11 bits, more have 29.
    #[arg(long, value_name = "HEX", value_parser = CanId::parse)]
    id: Option<CanId>,
    /// UDP port that the packets go to (captures).
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Where the number of a packet is in its payload, if not found by itself: u8@7, u16le@0, u16be@2, u32le@0, u32be@4,
    /// nibble@6 or high-nibble@6, with the byte it begins at.
    #[arg(long, value_name = "SHAPE@BYTE")]
    counter: Option<Counter>,
    /// Unit of the times in a table; without it seconds, or what makes packets come once in a cycle.
    #[arg(long, value_enum)]
    unit: Option<Unit>,
    /// Take half of each round trip for the delay (ping, fping): both ways are assumed to take equally long.
    #[arg(long)]
    half_round_trip: bool,
    /// The way back, from the server to the client (irtt).
    #[arg(long)]
    way_back: bool,
    /// Shortest delay of the link, by which two clocks that disagree are brought together where no packets of the way back do.
    #[arg(long, value_name = "SECONDS", value_parser = not_negative)]
    shortest_delay: Option<f64>,
    /// Print one JSON object instead of lines of a design file.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Header with sequence,sent,received, then a row per packet; also with semicolons or tabs.
    Csv,
    /// Lines of candump -L.
    Candump,
    /// The view of candump -ta, -tz or -td.
    CandumpView,
    /// Vector ASC.
    Asc,
    /// Vector BLF.
    Blf,
    /// PEAK TRC.
    Trc,
    /// Messages printed by python-can.
    PythonCanText,
    /// CSV of python-can, a file of each end.
    PythonCanCsv,
    /// pcap or pcapng.
    Pcap,
    /// JSON of irtt.
    Irtt,
    /// Output of owping -R.
    Owping,
    /// Output of ping -D -O.
    Ping,
    /// Output of fping -D.
    Fping,
}

impl From<Format> for logs::Format {
    fn from(name: Format) -> Self {
        match name {
            Format::Csv => Self::Csv,
            Format::Candump => Self::Candump,
            Format::CandumpView => Self::CandumpView,
            Format::Asc => Self::Asc,
            Format::Blf => Self::Blf,
            Format::Trc => Self::Trc,
            Format::PythonCanText => Self::PythonCanText,
            Format::PythonCanCsv => Self::PythonCanCsv,
            Format::Pcap => Self::Pcap,
            Format::Irtt => Self::Irtt,
            Format::Owping => Self::Owping,
            Format::Ping => Self::Ping,
            Format::Fping => Self::Fping,
        }
    }
}

/// Units of times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Unit {
    /// Seconds.
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
}

impl Unit {
    fn nanoseconds(self) -> i64 {
        match self {
            Self::S => 1_000_000_000,
            Self::Ms => 1_000_000,
            Self::Us => 1000,
            Self::Ns => 1,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum GapsName {
    /// A packet was sent and lost.
    Lost,
    /// Nothing was sent, or it was not logged.
    Ignore,
}

impl From<GapsName> for Gaps {
    fn from(name: GapsName) -> Self {
        match name {
            GapsName::Lost => Self::Lost,
            GapsName::Ignore => Self::Ignore,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
#[value(rename_all = "snake_case")]
enum Link {
    ControllerToActuator,
    SensorToController,
    Acknowledgement,
}

impl Link {
    /// Name in a design file, and kind of frame (docs/wire-format.md).
    fn key_and_kind(self) -> (&'static str, u8) {
        match self {
            Self::ControllerToActuator => ("controller_to_actuator", 2),
            Self::SensorToController => ("sensor_to_controller", 1),
            Self::Acknowledgement => ("acknowledgement", 3),
        }
    }
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&seconds: &f64| seconds > 0.0 && seconds.is_finite());
    number.ok_or_else(|| "give a positive number of seconds".into())
}

fn not_negative(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|&seconds: &f64| seconds >= 0.0 && seconds.is_finite());
    number.ok_or_else(|| "give a number of seconds, at least 0".into())
}

/// A bar on stderr, when that is a terminal, over the bytes of the logs.
fn progress(paths: &[PathBuf]) -> ProgressBar {
    let size = |path: &PathBuf| fs::metadata(path).map_or(0, |about| about.len());
    let bar = ProgressBar::with_draw_target(Some(paths.iter().map(size).sum()), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{wide_bar} {bytes}/{total_bytes}, {eta} left");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Reads the logs and computes; what comes back is to be printed.
///
/// # Errors
/// A log that cannot be read, or that has nothing to say.
pub fn run(options: &Options) -> Result<String, TraceError> {
    if options.offset >= 2.0 * options.sample_time {
        let problem = "--offset: found two cycles or more; give the time from the begin of a cycle to the sending, see docs/traces.md";
        return Err(TraceError::Whole(problem.into()));
    }
    let (key, kind) = options.link.key_and_kind();
    let selection = Selection {
        format: options.format.map(Into::into),
        gaps: options.gaps.map(Into::into),
        tx: options.tx.as_deref(),
        rx: options.rx.as_deref(),
        id: options.id,
        port: options.port,
        kind,
        counter: options.counter,
        unit: options.unit.map(Unit::nanoseconds),
        sample_time: Some(options.sample_time),
        halves_round_trips: options.half_round_trip,
        is_way_back: options.way_back,
        shortest_delay: options.shortest_delay.map(|seconds| (seconds * 1e9).round() as i64),
    };
    let bar = progress(&options.traces);
    let traces = logs::read_and_tell(&options.traces, &selection, &|bytes| bar.inc(bytes));
    bar.finish_and_clear();
    let traces = traces?;
    let clock = Clock {
        sample_time: options.sample_time,
        offset: options.offset,
        longest: usize::from(options.longest),
    };
    let names = options.traces.iter().map(|path| path.display().to_string()).collect();
    let figures = Figures::new(names, &traces, &clock)?;
    Ok(match options.json {
        true => figures.json() + "\n",
        false => fragment(&figures, key),
    })
}
