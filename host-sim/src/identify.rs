//! Options of `host-sim identify`, and what it does.

use clap::{Args, ValueEnum};
use slqg_links::identify::{
    figures::Figures,
    fragment::fragment,
    logs::{self, Selection},
    sample::{Clock, LONGEST},
    trace::{Gaps, TraceError},
};
use std::path::PathBuf;

/// Options of the command line.
#[derive(Debug, Args)]
pub struct Options {
    /// Logs of one link: CSV tables (each a run of its own), logs of candump -L (together one log), or two pcap captures,
    /// the sender's and the receiver's. docs/traces.md describes them.
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
    /// Interface on which packets are sent (candump).
    #[arg(long, value_name = "IFACE")]
    tx: Option<String>,
    /// Interface on which packets are received (candump).
    #[arg(long, value_name = "IFACE")]
    rx: Option<String>,
    /// Identifier of the packets (candump).
    #[arg(long, value_name = "HEX", value_parser = identifier)]
    id: Option<u32>,
    /// Print one JSON object instead of lines of a design file.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Header with sequence,sent,received, then a row per packet.
    Csv,
    /// Lines of candump -L.
    Candump,
    /// Classic pcap.
    Pcap,
}

impl From<Format> for logs::Format {
    fn from(name: Format) -> Self {
        match name {
            Format::Csv => Self::Csv,
            Format::Candump => Self::Candump,
            Format::Pcap => Self::Pcap,
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

fn identifier(text: &str) -> Result<u32, String> {
    let digits = text.strip_prefix("0x").unwrap_or(text);
    u32::from_str_radix(digits, 16).map_err(|_| "give a hexadecimal number, as 123".into())
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
        kind,
    };
    let traces = logs::read(&options.traces, &selection)?;
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
