//! The command line: what can be asked, where answers go, and what the exit status says.
//!
//! Status 0: done. 2: the input is wrong. 3: the loop cannot be stabilised. Answers go to stdout or into the
//! file named, everything else to stderr.

use clap::{Args, Parser, Subcommand, ValueEnum};
use gain_gen::certificate::NotCertified;
use gain_gen::design::{Design, DesignError, LONGEST_SEQUENCE};
use gain_gen::emit::{self, EmitError, Format, Output, WriteError};
use gain_gen::lengths::Lengths;
use gain_gen::report::{NotStabilised, Report};
use gain_gen::solve::Method;
use gain_gen::sweep::Sweep;
use slqg::DefaultInput;
use std::io::{self, IsTerminal, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Lengths a design may ask for.
const LENGTHS: RangeInclusive<usize> = 1..=LONGEST_SEQUENCE;

/// Lengths a task may have: more tables than these fill no device's flash.
const HORIZONS: RangeInclusive<usize> = 1..=10_000;

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
        /// Add how much more loss, delay and input gain the loop bears: a minute or more for N = 20
        #[arg(long)]
        margins: bool,
        /// Add the time-varying gains of a task of so many cycles (1 to 10000), which ends with cost.terminal
        #[arg(long, value_name = "K", value_parser = horizon)]
        horizon: Option<usize>,
        /// Write a proof of stability to this file, as JSON that anybody can check
        #[arg(long, value_name = "FILE")]
        certificate: Option<PathBuf>,
    },
    /// Compare sequence lengths: stability, cost and size of the tables for each
    ///
    /// The status is 0 if any of the lengths stabilises the loop.
    Sweep {
        /// Design file (TOML); its sequence length does not matter
        design: PathBuf,
        /// Lengths, 1 to 128: 4, 1..=12, 1..13 or 1,2,4,8
        #[arg(long, value_name = "RANGE")]
        lengths: Lengths,
        /// What the actuator applies when its buffer has run out, instead of the design's
        #[arg(long, value_enum)]
        default_input: Option<SweptInputName>,
        /// Print one JSON object instead of a table
        #[arg(long)]
        json: bool,
        /// Also draw cost, rate and size over the length, as SVG
        #[arg(long, value_name = "FILE.svg")]
        plot: Option<PathBuf>,
    },
    /// Write the gains, the plant and the settings of both nodes to a file
    ///
    /// An existing file is replaced only by a complete new one; a design that cannot be stabilised writes nothing.
    Emit {
        #[command(flatten)]
        source: Source,
        /// What to write
        #[arg(long, value_enum)]
        to: FormatName,
        /// Write the time-varying gains of a task of so many cycles (1 to 10000) instead of the steady-state ones
        ///
        /// The task ends with the weight cost.terminal. It need not be one that could go on for ever. rust and json only.
        #[arg(long, value_name = "K", value_parser = horizon)]
        horizon: Option<usize>,
        /// File to write; for C the header, which ends in .h
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
enum SweptInputName {
    /// Zero input
    Zero,
    /// The input applied last
    Hold,
    /// One after the other, in one table
    Both,
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
    /// C99: a header, and beside it a source that ends in .c instead of .h
    C,
    /// The report's JSON with the plant's model and the settings of both nodes
    Json,
    /// Bytes with a checksum, which slqg::blob loads at run time: the gains alone
    Blob,
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
    NotCertified(#[from] NotCertified),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("stdout: cannot be written: {0}")]
    Stdout(#[from] io::Error),
}

impl Failure {
    fn status(&self) -> u8 {
        match self {
            Self::NotStabilised(_) | Self::NotCertified(_) | Self::Emit(EmitError::NotStabilised(_)) => 3,
            Self::Design(_) | Self::Emit(_) | Self::Write(_) | Self::Stdout(_) => 2,
        }
    }
}

/// Reads the command line, does what it asks and returns the exit status.
pub(crate) fn run() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Report { source, method, json, margins, horizon, certificate } => {
            report(&source, method, json, &Additions { margins, horizon, certificate })
        }
        Command::Sweep { design, lengths, default_input, json, plot } => {
            sweep(&design, &lengths, default_input, json, plot.as_deref())
        }
        Command::Emit { source, to, horizon, output } => emit(&source, to, horizon, &output),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            ExitCode::from(failure.status())
        }
    }
}

/// What a report is asked for beyond the usual.
struct Additions {
    margins: bool,
    horizon: Option<usize>,
    certificate: Option<PathBuf>,
}

fn report(source: &Source, method: MethodName, json: bool, additions: &Additions) -> Result<(), Failure> {
    let method = match method {
        MethodName::InFlight => Method::InFlight,
        MethodName::Coupled => Method::Coupled,
    };
    let mut report = solved(&source.load()?, method);
    if additions.margins {
        report.find_margins();
    }
    if let Some(cycles) = additions.horizon {
        report.find_task(cycles);
    }
    if let Some(path) = &additions.certificate {
        report.certify()?;
        if let Some(text) = report.certificate_json() {
            emit::write(path, &text)?;
        }
    }
    print(&if json { report.to_json() } else { report.to_string() })?;
    Ok(report.require_stable()?)
}

fn sweep(
    design: &Path,
    lengths: &Lengths,
    default_input: Option<SweptInputName>,
    json: bool,
    plot: Option<&Path>,
) -> Result<(), Failure> {
    let mut design = Design::load(design)?;
    let default_inputs = match default_input {
        None => vec![design.controller.default_input],
        Some(SweptInputName::Zero) => vec![DefaultInput::Zero],
        Some(SweptInputName::Hold) => vec![DefaultInput::Hold],
        Some(SweptInputName::Both) => vec![DefaultInput::Zero, DefaultInput::Hold],
    };
    let lengths = lengths.as_slice();
    let told = format!("solving {:?} for {} lengths", design.name, lengths.len());
    let sweep = watched(&told, || Sweep::new(&design, lengths, &default_inputs));
    if let Some(path) = plot {
        emit::write(path, &sweep.to_svg())?;
    }
    print(&if json { sweep.to_json() } else { sweep.to_string() })?;
    if sweep.is_any_stable() {
        return Ok(());
    }
    // Why not: what the longest of them fails by.
    design.set_sequence_length(*lengths.last().expect("lengths are never empty"));
    design.controller.default_input = *default_inputs.last().expect("one default input at least");
    Ok(solved(&design, Method::InFlight).require_stable()?)
}

fn emit(source: &Source, to: FormatName, horizon: Option<usize>, output: &Path) -> Result<(), Failure> {
    let output = match to {
        FormatName::Rust => Output::text(Format::Rust, output),
        FormatName::C => Output::c(output)?,
        FormatName::Json => Output::text(Format::Json, output),
        FormatName::Blob => Output::blob(output),
    };
    let mut report = solved(&source.load()?, Method::InFlight);
    if let Some(cycles) = horizon {
        report.find_task(cycles);
    }
    let origin = source.design.file_name().unwrap_or_default().to_string_lossy();
    Ok(emit::write_all(&output.files(&report, &origin)?)?)
}

/// The report; while it is made, a line on the terminal says so.
fn solved(design: &Design, method: Method) -> Report {
    let told = format!("solving {:?} for N = {}", design.name, design.controller.sequence_length);
    watched(&told, || Report::new(design, method))
}

/// What `work` makes; meanwhile, a line on the terminal tells what is done.
fn watched<T>(told: &str, work: impl FnOnce() -> T) -> T {
    let is_watched = io::stderr().is_terminal();
    if is_watched {
        eprint!("{told} ..");
    }
    let made = work();
    if is_watched {
        // Back to the start of the line, and erase it.
        eprint!("\r\x1b[2K");
    }
    made
}

impl Source {
    fn load(&self) -> Result<Design, DesignError> {
        let mut design = Design::load(&self.design)?;
        match self.default_input {
            None => {}
            // A length that the design leaves open is chosen anew.
            Some(DefaultInputName::Zero) => design.set_default_input(DefaultInput::Zero),
            Some(DefaultInputName::Hold) => design.set_default_input(DefaultInput::Hold),
        }
        if let Some(length) = self.sequence_length {
            design.set_sequence_length(length);
        }
        Ok(design)
    }
}

fn sequence_length(text: &str) -> Result<usize, String> {
    whole_number(text, "inputs", &LENGTHS)
}

fn horizon(text: &str) -> Result<usize, String> {
    whole_number(text, "cycles", &HORIZONS)
}

fn whole_number(text: &str, of: &str, allowed: &RangeInclusive<usize>) -> Result<usize, String> {
    let advice = || format!("give a whole number of {of} from {} to {}", allowed.start(), allowed.end());
    text.parse().ok().filter(|number| allowed.contains(number)).ok_or_else(advice)
}

/// Prints an answer. A reader that has seen enough and closes the pipe is no failure.
fn print(answer: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(answer.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        outcome => outcome,
    }
}
