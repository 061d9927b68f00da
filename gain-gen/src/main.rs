//! `gain-gen`: from a design file to gains, a stability verdict and generated source.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
