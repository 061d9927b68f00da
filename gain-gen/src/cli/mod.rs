//! The command line: what can be asked, where answers go, and what the exit status says.
//!
//! Status 0: done. 2: the input is wrong. 3: the loop is not stable, or not shown to be. Answers go to stdout or into the
//! file named, everything else to stderr.
//!
//! The words themselves, with their help, are in `options`.

mod options;

use gain_gen::certificate::NotCertified;
use gain_gen::console::{NotPrinted, parse, print, print_by, tell};
use gain_gen::design::{Design, DesignError};
use gain_gen::effort::Effort;
use gain_gen::emit::{self, EmitError, Format, Output, WriteError};
use gain_gen::lengths::Lengths;
use gain_gen::report::{ModeGains, NoTask, NotEmittable, NotStabilised, Report};
use gain_gen::solve::{Method, PreviewTooLong, TooManyModes};
use gain_gen::sweep::Sweep;
use gain_gen::warnings;
use options::{Cli, Command, FormatName, Source, SweptInputName};
use slqg::DefaultInput;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// What ends a command early.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error(transparent)]
    Design(#[from] DesignError),
    #[error("{0}")]
    Emit(#[from] EmitError),
    #[error("{0}")]
    NotEmittable(#[from] NotEmittable),
    #[error(transparent)]
    NotStabilised(#[from] NotStabilised),
    #[error(transparent)]
    NotCertified(#[from] NotCertified),
    #[error(transparent)]
    NoTask(#[from] NoTask),
    #[error("--method coupled: {0}")]
    TooManyModes(#[from] TooManyModes),
    #[error(transparent)]
    Preview(#[from] PreviewTooLong),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error(
        "controller.sequence_length: solving takes {0}; give shorter sequences, or --accept-effort if that is to be taken"
    )]
    Effort(Effort),
    #[error(transparent)]
    NotPrinted(#[from] NotPrinted),
}

impl Failure {
    fn status(&self) -> u8 {
        match self {
            Self::NotStabilised(_)
            | Self::NotCertified(_)
            | Self::NotEmittable(NotEmittable::NotStabilised(_)) => 3,
            Self::Design(_)
            | Self::NoTask(_)
            | Self::TooManyModes(_)
            | Self::Preview(_)
            | Self::Emit(_)
            | Self::NotEmittable(_)
            | Self::Write(_)
            | Self::Effort(_)
            | Self::NotPrinted(_) => 2,
        }
    }
}

/// Reads the command line, does what it asks and returns the exit status.
pub(crate) fn run() -> ExitCode {
    let command = match parse::<Cli>() {
        Ok(cli) => cli.command,
        Err(status) => return status,
    };
    let outcome = match command {
        Command::Report { source, method, json, mode_gains, margins, horizon, certificate } => {
            let mode_gains = if mode_gains { ModeGains::All } else { ModeGains::Small };
            let form = if json { Form::Json(mode_gains) } else { Form::Text };
            report(&source, method.method(), form, &Additions { margins, horizon, certificate })
        }
        Command::Sweep { design, lengths, default_input, json, plot, accept_effort } => {
            sweep(&design, &lengths, default_input, json, plot.as_deref(), accept_effort)
        }
        Command::Emit { source, to, horizon, output, accept_undecided_stability } => {
            emit(&source, to, horizon, &output, accept_undecided_stability)
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            tell(format_args!("error: {failure}"));
            ExitCode::from(failure.status())
        }
    }
}

/// How a report is written.
#[derive(Clone, Copy)]
enum Form {
    Text,
    Json(ModeGains),
}

/// What a report is asked for beyond the usual.
struct Additions {
    margins: bool,
    horizon: Option<usize>,
    certificate: Option<PathBuf>,
}

fn report(source: &Source, method: Method, form: Form, additions: &Additions) -> Result<(), Failure> {
    let mut report = solved(&affordable(source)?, method);
    warnings::tell(&report.warnings);
    match additions.horizon {
        Some(cycles) => report.find_task(cycles)?,
        // A task follows its reference without preview gains.
        None => report.require_preview()?,
    }
    if method == Method::Coupled {
        report.find_channel()?;
    }
    if additions.margins {
        report.find_margins();
    }
    if let Some(path) = &additions.certificate {
        report.certify()?;
        if let Some(text) = report.certificate_json() {
            emit::write(path, &text)?;
        }
    }
    match form {
        Form::Text => print(&report)?,
        Form::Json(mode_gains) => print_by(|stdout| report.write_json(stdout, mode_gains))?,
    }
    Ok(report.require_stable()?)
}

fn sweep(
    design: &Path,
    lengths: &Lengths,
    default_input: Option<SweptInputName>,
    json: bool,
    plot: Option<&Path>,
    accepts_effort: bool,
) -> Result<(), Failure> {
    let mut design = warnings::load(design)?;
    let default_inputs = match default_input {
        None => vec![design.controller.default_input],
        Some(SweptInputName::Zero) => vec![DefaultInput::Zero],
        Some(SweptInputName::Hold) => vec![DefaultInput::Hold],
        Some(SweptInputName::Both) => vec![DefaultInput::Zero, DefaultInput::Hold],
    };
    let lengths = lengths.as_slice();
    weigh(Effort::of(&design, &lengths.repeat(default_inputs.len())), accepts_effort)?;
    let told = format!("solving {:?} for {} lengths", design.name, lengths.len());
    let sweep = watched(&told, || Sweep::new(&design, lengths, &default_inputs));
    if let Some(path) = plot {
        emit::write(path, &sweep.to_svg())?;
    }
    print(if json { sweep.to_json() } else { sweep.to_string() })?;
    if sweep.is_any_stable() {
        return Ok(());
    }
    // Why not: what the longest of them fails by.
    design.set_sequence_length(*lengths.last().expect("lengths are never empty"));
    design.controller.default_input = *default_inputs.last().expect("one default input at least");
    Ok(solved(&design, Method::InFlight).require_stable()?)
}

fn emit(
    source: &Source,
    to: FormatName,
    horizon: Option<usize>,
    output: &Path,
    accepts_undecided: bool,
) -> Result<(), Failure> {
    let output = match to {
        FormatName::Rust => Output::text(Format::Rust, output),
        FormatName::C => Output::c(output)?,
        FormatName::Json => Output::text(Format::Json, output),
        FormatName::Blob => Output::blob(output),
    };
    let mut report = solved(&affordable(source)?, Method::InFlight);
    warnings::tell(&report.warnings);
    if accepts_undecided {
        report.accept_undecided_stability();
    }
    if let Some(cycles) = horizon {
        report.find_task(cycles)?;
    }
    let origin = source.design.file_name().unwrap_or_default().to_string_lossy();
    Ok(emit::write_all(&output.files(&report.emission()?, &origin)?)?)
}

/// The design, if solving it takes no more than is accepted.
fn affordable(source: &Source) -> Result<Design, Failure> {
    let design = source.load()?;
    weigh(Effort::of(&design, &[design.controller.sequence_length]), source.accept_effort)?;
    Ok(design)
}

/// Tells what solving takes where that is much, and refuses what is too much unless it is accepted.
fn weigh(effort: Effort, is_accepted: bool) -> Result<(), Failure> {
    if effort.is_too_much() && !is_accepted {
        return Err(Failure::Effort(effort));
    }
    if effort.is_much() {
        tell(format_args!("note: solving takes {effort}"));
    }
    Ok(())
}

/// The report; while it is made, a line on the terminal says so.
fn solved(design: &Design, method: Method) -> Report {
    let told = format!("solving {:?} for N = {}", design.name, design.controller.sequence_length);
    watched(&told, || Report::new(design, method))
}

/// What `work` makes; meanwhile, a line on the terminal tells what is done, and for how long.
fn watched<T>(told: &str, work: impl FnOnce() -> T) -> T {
    if !io::stderr().is_terminal() {
        return work();
    }
    thread::scope(|scope| {
        let (done, is_done) = mpsc::channel::<()>();
        scope.spawn(move || {
            let begun = Instant::now();
            // Until the other end is dropped.
            while is_done.recv_timeout(Duration::from_secs(1)) == Err(RecvTimeoutError::Timeout) {
                let _ = write!(io::stderr(), "\r{told} .. {} s", begun.elapsed().as_secs());
            }
            // Back to the start of the line, and erase it.
            let _ = write!(io::stderr(), "\r\x1b[2K");
        });
        let made = work();
        drop(done);
        made
    })
}
