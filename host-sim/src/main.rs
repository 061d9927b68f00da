//! `host-sim`: simulates the loop of a design file.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
