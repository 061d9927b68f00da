//! The project's tasks, run as `cargo xtask <task>`.
//!
//! `demo` shows what the project does, `test` is every check there is, `fuzz` looks for bytes that nobody thought of,
//! `firmware` and `size` deal with the image for the reference board. Whatever cross-building and emulation need is looked for first, and set up from distribution
//! packages where that is possible; otherwise a task stops and says what to run. Nothing is skipped silently.

use std::io::{Write, stderr};
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};

use crate::workspace::Workspace;

mod artifacts;
mod checks;
mod counts;
mod demo;
mod distribution;
mod examples;
mod firmware;
mod flips;
mod fuzz;
mod nodes;
mod packages;
mod panics;
mod pil;
mod process;
mod publication;
mod qemu;
mod size;
mod solve_bench;
mod sysroot;
mod target_bench;
mod toolchain;
mod version;
mod workspace;

/// What went wrong, in words for whoever typed the command.
pub(crate) type Result<T, E = Box<dyn std::error::Error>> = std::result::Result<T, E>;

/// Tasks of the slqg project.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Report on the example pendulum, simulate it over a lossy link, and say where the plots are
    Demo,
    /// Run every check: format, lints, documentation, tests, cross build, board against host, instruction counts
    Test,
    /// Build the images for the reference board, an Arm MPS2 with a Cortex-M4F; with --design both nodes for a design
    Firmware {
        /// Also run them in QEMU, and compare with the same loop on the host
        #[arg(long, conflicts_with = "design")]
        run: bool,
        #[command(flatten)]
        nodes: nodes::Options,
    },
    /// Run controller and actuator on boards in QEMU for every kind of loop, and compare with the simulator bit by bit
    Pil,
    /// Look for bytes that break a property of those that read them, for so many minutes
    Fuzz(fuzz::Options),
    /// Flip bits in the memory of controller and actuator while they close the loop in QEMU, and say what becomes of them
    Flips(flips::Options),
    /// Build the images for the reference board and show how much memory they take
    Size,
    /// Measure: ratios within one run, rates, or instructions
    Bench {
        /// What to measure
        what: Bench,
        /// Also write what is counted to the file that `cargo xtask test` compares with
        #[arg(long)]
        update: bool,
    },
}

/// What can be measured.
#[derive(Clone, Copy, ValueEnum)]
enum Bench {
    /// Time to compute gains: in-flight against coupled, and growth with the sequence length
    Gains,
    /// Control cycles per second of the simulator, and how they grow from one thread to two
    Simulate,
    /// Instructions of a control cycle and each of its steps on the reference board, as QEMU counts them
    Target,
    /// The same for solving gains again on the board, when its link has changed
    Solve,
}

fn main() -> ExitCode {
    let ended = match Cli::try_parse() {
        Ok(cli) => perform(&cli.task),
        Err(answer) if answer.use_stderr() => {
            let _ = answer.print();
            return ExitCode::from(2);
        }
        // Help.
        Err(answer) => process::print(answer.render().to_string().trim_end()),
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(stderr(), "error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn perform(task: &Task) -> Result<()> {
    let workspace = Workspace::find()?;
    match task {
        Task::Bench { what: Bench::Gains | Bench::Simulate, update: true } => {
            Err("--update: only `bench target` has counts that are kept".into())
        }
        Task::Demo => demo::demo(&workspace),
        Task::Test => checks::test(&workspace),
        Task::Firmware { nodes, .. } if nodes.design.is_some() => nodes::nodes(&workspace, nodes),
        Task::Firmware { run, .. } => firmware::firmware(&workspace, *run),
        Task::Pil => pil::pil(&workspace),
        Task::Fuzz(options) => fuzz::fuzz(&workspace, options),
        Task::Flips(options) => flips::flips(&workspace, options),
        Task::Size => size::size(&workspace),
        Task::Bench { what: Bench::Gains, .. } => {
            process::run(workspace.cargo().args(["bench", "--quiet", "-p", "gain-gen", "--bench", "gains"]))
        }
        // With the profile that `host-sim` is run in.
        Task::Bench { what: Bench::Simulate, .. } => process::run(workspace.cargo().args([
            "bench",
            "--quiet",
            "--profile",
            "dev",
            "-p",
            "host-sim",
            "--bench",
            "simulate",
        ])),
        Task::Bench { what: Bench::Target, update } => target_bench::bench(&workspace, *update),
        Task::Bench { what: Bench::Solve, .. } => solve_bench::bench(&workspace),
    }
}
