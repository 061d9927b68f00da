//! The command line: what can be asked, where answers go, and what the exit status says.
//!
//! Status 0: done. 2: the input is wrong. 3: the loop cannot be stabilised. Answers go to stdout or into the
//! file named, everything else to stderr.

use clap::{Args, Parser, Subcommand, ValueEnum};
use gain_gen::design::{Design, DesignError, LONGEST_SEQUENCE};
use gain_gen::emit::{self, EmitError, WriteError};
use gain_gen::report::{NotStabilised, Report};
use gain_gen::solve::Method;
use slqg::DefaultInput;
use std::io::{self, IsTerminal, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Lengths a design may ask for.
const LENGTHS: RangeInclusive<usize> = 1..=LONGEST_SEQUENCE;

/// Optimal gains for control over links that lose and delay packets
///
/// Exit status: 0 done; 2 the input is wrong, stderr says where and how to mend it; 3 the loop cannot be
/// stabilised, stderr says which condition fails.
#[derive(Parser)]
#[command(name = "gain-gen", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Tell whether a design can be stabilised, and with what gains and figures
    Report {
        #[command(flatten)]
        source: Source,
        /// Recursion that computes the gains: the small one, or the reference over all ages of the buffer
        #[arg(long, value_enum, default_value = "in-flight")]
        method: MethodName,
        /// Print one JSON object with all tables instead of text
        #[arg(long)]
        json: bool,
    },
    /// Write the gains, the plant and the settings of both nodes to a file
    ///
    /// An existing file is replaced only by a complete new one; a design that cannot be stabilised writes nothing.
    Emit {
        #[command(flatten)]
        source: Source,
        /// What to write: a source to include in a no_std crate, or JSON
        #[arg(long, value_enum)]
        to: FormatName,
        /// File to write
        #[arg(long, value_name = "FILE")]
        output: PathBuf,
    },
}

/// A design file, and what the command line changes in it.
#[derive(Args)]
struct Source {
    /// Design file (TOML): plant, cost, network and controller settings
    design: PathBuf,
    /// Inputs per packet, 1 to 128, instead of the design's
    #[arg(long, value_name = "N", value_parser = sequence_length)]
    sequence_length: Option<usize>,
    /// What the actuator applies when its buffer has run out, instead of the design's
    #[arg(long, value_enum)]
    default_input: Option<DefaultInputName>,
}

#[derive(Clone, Copy, ValueEnum)]
enum DefaultInputName {
    /// Zero input
    Zero,
    /// The input applied last
    Hold,
}

#[derive(Clone, Copy, ValueEnum)]
enum MethodName {
    /// The project's own recursion: small and fast
    InFlight,
    /// The reference recursion, one gain per age of the actuator's buffer: slow for long sequences
    Coupled,
}

#[derive(Clone, Copy, ValueEnum)]
enum FormatName {
    /// Rust source to include in a no_std crate that depends on slqg
    Rust,
    /// The report's JSON with the plant's model and the settings of both nodes
    Json,
}

/// What ends a command early.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error(transparent)]
    Design(#[from] DesignError),
    #[error("{0}")]
    Emit(#[from] EmitError),
    #[error(transparent)]
    NotStabilised(#[from] NotStabilised),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("stdout: cannot be written: {0}")]
    Stdout(#[from] io::Error),
}

impl Failure {
    fn status(&self) -> u8 {
        match self {
            Self::NotStabilised(_) | Self::Emit(EmitError::NotStabilised(_)) => 3,
            Self::Design(_) | Self::Emit(EmitError::OutOfRange { .. }) | Self::Write(_) | Self::Stdout(_) => {
                2
            }
        }
    }
}

/// Reads the command line, does what it asks and returns the exit status.
pub(crate) fn run() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Report { source, method, json } => report(&source, method, json),
        Command::Emit { source, to, output } => emit(&source, to, &output),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.status())
        }
    }
}

fn report(source: &Source, method: MethodName, json: bool) -> Result<(), Failure> {
    let method = match method {
        MethodName::InFlight => Method::InFlight,
        MethodName::Coupled => Method::Coupled,
    };
    let report = solved(&source.load()?, method);
    print(&if json { report.to_json() } else { report.to_string() })?;
    Ok(report.require_stable()?)
}

fn emit(source: &Source, to: FormatName, output: &Path) -> Result<(), Failure> {
    let format = match to {
        FormatName::Rust => emit::Format::Rust,
        FormatName::Json => emit::Format::Json,
    };
    let report = solved(&source.load()?, Method::InFlight);
    let origin = source.design.file_name().unwrap_or_default().to_string_lossy();
    Ok(emit::write(output, &emit::emit(&report, &origin, format)?)?)
}

/// The report; while it is made, a line on the terminal says so.
fn solved(design: &Design, method: Method) -> Report {
    let length = design.controller.sequence_length;
    let watched = io::stderr().is_terminal();
    if watched {
        eprint!("solving {:?} for N = {length} ..", design.name);
    }
    let report = Report::new(design, method);
    if watched {
        // Back to the start of the line, and erase it.
        eprint!("\r\x1b[2K");
    }
    report
}

impl Source {
    fn load(&self) -> Result<Design, DesignError> {
        let mut design = Design::load(&self.design)?;
        if let Some(length) = self.sequence_length {
            design.controller.sequence_length = length;
        }
        match self.default_input {
            None => {}
            Some(DefaultInputName::Zero) => design.controller.default_input = DefaultInput::Zero,
            Some(DefaultInputName::Hold) => design.controller.default_input = DefaultInput::Hold,
        }
        Ok(design)
    }
}

fn sequence_length(text: &str) -> Result<usize, String> {
    let allowed = format!("give a whole number of inputs from {} to {}", LENGTHS.start(), LENGTHS.end());
    text.parse().ok().filter(|length| LENGTHS.contains(length)).ok_or(allowed)
}

/// Prints an answer. A reader that has seen enough and closes the pipe is no failure.
fn print(answer: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(answer.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        outcome => outcome,
    }
}
