//! Command line: `host-sim run`.
//!
//! Exit status: 0 done; 2 the input is wrong; 3 the loop cannot be stabilised.

use clap::{Args, Parser, Subcommand};
use gain_gen::{design::Design, emit, report::Report, solve::Method};
use host_sim::{
    contender::{Contender, ContenderError, Kind},
    monte_carlo::{Plan, Simulate},
    output::{self, Simulation},
    size_class::{self, dispatch},
};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::{
    path::{Path, PathBuf},
    process::ExitCode,
};

/// Simulates a closed loop over links that lose and delay packets, with the code that runs on the device.
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate a design many times and compare controllers.
    Run(RunOptions),
}

#[derive(Args)]
struct RunOptions {
    /// Design file (TOML).
    design: PathBuf,
    /// Controllers to simulate, separated by commas: slqg (sequence-based LQG over the design's network), lqg (at the
    /// plant, without a network: the lower bound).
    #[arg(long, value_delimiter = ',', default_value = "slqg,lqg")]
    controllers: Vec<Kind>,
    /// Inputs per sequence, instead of the design's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=128))]
    sequence_length: Option<u16>,
    /// Runs per controller.
    #[arg(long, value_name = "R", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Control cycles per run.
    #[arg(long, value_name = "K", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Seed of all random numbers; the same seed gives the same numbers on any number of threads.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
    /// Also write a report with pictures, one self-contained HTML file.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// What went wrong, by exit status.
enum Failure {
    /// The input is wrong: 2.
    Input(String),
    /// The loop cannot be stabilised: 3.
    Unstable(String),
}

pub(crate) fn main() -> ExitCode {
    let Command::Run(options) = Cli::parse().command;
    match run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Input(message)) => fail(2, &message),
        Err(Failure::Unstable(message)) => fail(3, &message),
    }
}

fn fail(status: u8, message: &str) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::from(status)
}

fn run(options: &RunOptions) -> Result<(), Failure> {
    let mut design = Design::load(&options.design).map_err(|error| Failure::Input(error.to_string()))?;
    if let Some(length) = options.sequence_length {
        design.controller.sequence_length = usize::from(length);
    }
    let plan = Plan { runs: options.runs as usize, steps: options.steps as usize, seed: options.seed };
    let origin = options.design.display();
    // Before gains are computed, which can take longer than saying no.
    size_class::check(&design).map_err(|error| Failure::Input(format!("{origin}: {error}")))?;
    let contenders = options
        .controllers
        .iter()
        .map(|&kind| Contender::new(kind, &design).map_err(|error| refused(&error, &design, &options.design)))
        .collect::<Result<Vec<_>, _>>()?;

    let progress = progress(contenders.len() * plan.runs);
    let mut outcomes = Vec::with_capacity(contenders.len());
    for contender in &contenders {
        let simulate = Simulate { design: &design, contender, plan, done: || progress.inc(1) };
        let outcome = dispatch(&design, simulate)
            .map_err(|error| Failure::Input(format!("{origin}: {error}")))?
            .map_err(|error| {
                Failure::Input(format!("{origin}: controller.scalar: {error}; compute in f64"))
            })?;
        outcomes.push(outcome);
    }
    progress.finish_and_clear();

    let simulation = Simulation { name: &design.name, sample_time: design.plant.sample_time, plan, outcomes };
    if let Some(path) = &options.report {
        emit::write(path, &output::report(&simulation)).map_err(|error| {
            Failure::Input(format!("{}: cannot write the report: {error}", path.display()))
        })?;
    }
    if options.json {
        println!("{}", output::json(&simulation));
    } else {
        print!("{}", output::table(&simulation));
        if let Some(path) = &options.report {
            println!("\nreport: {}", path.display());
        }
    }
    Ok(())
}

fn refused(error: &ContenderError, design: &Design, path: &Path) -> Failure {
    let origin = path.display();
    match error {
        ContenderError::Acknowledgement { .. } => Failure::Input(format!("{origin}: {error}")),
        ContenderError::Unstable { .. } => {
            // Which condition fails is the generator's to say.
            let why = Report::new(design, Method::InFlight).require_stable().err();
            let why = why.map_or_else(String::new, |condition| format!(": {condition}"));
            Failure::Unstable(format!("{origin}: {error}{why}"))
        }
    }
}

/// A bar on stderr, when that is a terminal.
fn progress(runs: usize) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(runs as u64), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} runs, {eta} left");
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
