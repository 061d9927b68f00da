//! Command line: which subcommands there are, exit statuses, progress. Each subcommand has a file with its options.
//!
//! Exit status: 0 done; 1 boards and simulator differ, or a board has failed; 2 the input is wrong; 3 the loop cannot be
//! stabilised.

mod bus;
mod figures;
mod options;
mod pil;
mod robustness;
mod run;
mod sweep;
mod sweep_files;

use clap::{Parser, Subcommand};
use gain_gen::console::{NotPrinted, parse, print, tell};
use host_sim::{
    identify,
    node::{self, NodeError},
};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::process::ExitCode;

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
    Run(run::Options),
    /// Simulate designs with several controllers and lengths, and compare them run by run.
    ///
    /// A length with which a controller cannot stabilise the loop is told on stderr and has no row; the status is 0 if
    /// there is any row.
    Sweep(sweep::Options),
    /// Put the shards of a sweep together to the file of a whole one.
    Merge(sweep_files::MergeOptions),
    /// The table of a sweep, from its file.
    Summary(sweep_files::SummaryOptions),
    /// Designs that differ in their network, each simulated on the network of each: what it costs when the link is not what
    /// was assumed.
    Robustness(robustness::Options),
    /// The CAN bus of a design in one run of the loop: load, fates and response times of all messages, delays.
    Bus(bus::Options),
    /// The thesis' figures, recomputed: tables and pictures in a folder.
    Figures(figures::Options),
    /// Logs of a link to the delays of a design file, with confidence intervals and what speaks against them.
    Identify(identify::Options),
    /// Processor in the loop: controller and actuator on boards in QEMU, compared with the simulator bit by bit.
    Pil(pil::Options),
    /// One node of the loop in real time: controller, actuator, plant, or a link between them.
    Node(node::Options),
}

/// What went wrong, by exit status.
enum Failure {
    /// What was run has failed: 1.
    Run(String),
    /// The input is wrong: 2.
    Input(String),
    /// The loop cannot be stabilised: 3.
    Unstable(String),
}

impl From<NotPrinted> for Failure {
    fn from(error: NotPrinted) -> Self {
        Self::Input(error.to_string())
    }
}

pub(crate) fn main() -> ExitCode {
    let command = match parse::<Cli>() {
        Ok(cli) => cli.command,
        Err(status) => return status,
    };
    let outcome = match &command {
        Command::Run(options) => run::run(options),
        Command::Sweep(options) => sweep::sweep(options),
        Command::Merge(options) => sweep_files::merge(options),
        Command::Summary(options) => sweep_files::summary(options),
        Command::Robustness(options) => robustness::robustness(options),
        Command::Bus(options) => bus::bus(options),
        Command::Figures(options) => figures::figures(options),
        Command::Pil(options) => pil::pil(options),
        Command::Identify(options) => identify::run(options)
            .map_err(|error| Failure::Input(error.to_string()))
            .and_then(|text| Ok(print(text)?)),
        Command::Node(options) => node::run(options)
            .map_err(|error| match error {
                NodeError::Input(message) => Failure::Input(message),
                NodeError::Unstable(message) => Failure::Unstable(message),
            })
            .and_then(|text| Ok(print(text)?)),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Run(message)) => fail(1, &message),
        Err(Failure::Input(message)) => fail(2, &message),
        Err(Failure::Unstable(message)) => fail(3, &message),
    }
}

fn fail(status: u8, message: &str) -> ExitCode {
    tell(format_args!("error: {message}"));
    ExitCode::from(status)
}

/// A bar on stderr, when that is a terminal.
fn progress(count: usize, of: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(count as u64), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template(&format!("{{wide_bar}} {{pos}}/{{len}} {of}, {{eta}} left"));
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
