//! Flips bits in the memory of a node while it closes the loop, and sorts what comes of it.
//!
//! | file | what lives there |
//! |---|---|
//! | `image` | where a program's functions, variables and messages are |
//! | `debugger` | the emulator's debugger stub: stops in a function, and flips a bit there |
//! | `node` | a node in the emulator, and the line to it |
//! | `log` | whether its log tells that something is wrong |
//! | `closed_loop` | the loop: one end in the emulator, the other one and the plant in this process |
//! | `campaign` | where and when bits flip |
//! | `outcome` | what became of each |
//!
//! The design is `designs/pendulum.toml` with N = 4, as the generator's tests have it. A run is told by its seed, and two are equal to
//! the bit: faults are the only difference.

mod campaign;
mod closed_loop;
mod debugger;
mod image;
mod log;
mod node;
mod outcome;

/// The loop's constant data.
#[allow(dead_code, unreachable_pub, missing_docs)]
mod design {
    include!("../../../gain-gen/tests/generated/pendulum.rs");
}

use clap::Parser;
use std::{path::PathBuf, process::ExitCode};

/// What went wrong, in words.
type Error = Box<dyn std::error::Error + Send + Sync>;

/// Flips bits in the memory of both nodes, one in each run, and prints what became of them.
#[derive(Parser)]
struct Options {
    /// The controller's program, its line files of a debugger.
    controller: PathBuf,
    /// The actuator's program likewise.
    actuator: PathBuf,
    /// Flips in each node's memory.
    #[arg(long, default_value_t = 1000)]
    flips: u32,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print each flip that was not masked.
    #[arg(long)]
    each: bool,
}

fn main() -> ExitCode {
    let options = Options::parse();
    match campaign::run(&options) {
        Ok(table) => {
            println!("{table}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
