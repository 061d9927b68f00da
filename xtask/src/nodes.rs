//! The two nodes for a design and a board.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};

use crate::artifacts::{self, Built};
use crate::process::print;
use crate::toolchain::{SOFT_FLOAT_TARGET, TARGET, Toolchain};
use crate::workspace::Workspace;
use crate::{Result, process};

/// Which nodes to build.
#[derive(Args, Clone)]
pub(crate) struct Options {
    /// Build controller and actuator for this design file
    #[arg(long)]
    pub(crate) design: Option<PathBuf>,
    /// Inputs per packet, instead of the design's
    #[arg(long, requires = "design")]
    pub(crate) sequence_length: Option<u8>,
    /// What the actuator does when its buffer has run out, instead of the design's: zero or hold
    #[arg(long, requires = "design")]
    pub(crate) default_input: Option<String>,
    /// Build a loop whose stability is undecided, too
    #[arg(long, requires = "design")]
    pub(crate) accept_undecided_stability: bool,
    /// Also build the controller that solves its own gains
    #[arg(long, requires = "design")]
    pub(crate) tuning: bool,
    /// Slices of a solution that it does in a cycle
    #[arg(long, requires = "tuning", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) slices: Option<u16>,
    /// The board that the nodes are for
    #[arg(long, value_enum, default_value_t = Board::Mps2An386, requires = "design")]
    pub(crate) board: Board,
}

/// A folder of `firmware/nodes/boards`.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Board {
    /// Arm MPS2 with a Cortex-M4F
    #[value(name = "mps2_an386")]
    Mps2An386,
    /// Stellaris LM3S6965, a Cortex-M3 without floating-point unit
    #[value(name = "lm3s6965evb")]
    Lm3s6965evb,
}

impl Board {
    fn target(self) -> &'static str {
        match self {
            Self::Mps2An386 => TARGET,
            Self::Lm3s6965evb => SOFT_FLOAT_TARGET,
        }
    }
}

/// `cargo xtask firmware --design FILE`: builds, and prints where the images are.
pub(crate) fn nodes(workspace: &Workspace, options: &Options) -> Result<()> {
    for image in build(workspace, options)?.binaries {
        print(image.display())?;
    }
    Ok(())
}

/// Builds the nodes.
pub(crate) fn build(workspace: &Workspace, options: &Options) -> Result<Built> {
    let toolchain = Toolchain::find_for(workspace, options.board.target())?;
    let start = Instant::now();
    let mut command = toolchain.cargo_build(workspace);
    command.args(["--package", "slqg-nodes", "--bins", "--profile", "firmware"]);
    if options.tuning {
        command.args(["--features", "tuning"]);
    }
    if let Some(slices) = options.slices {
        command.env("SLQG_SLICES", slices.to_string());
    }
    if let Some(design) = &options.design {
        let design =
            design.canonicalize().map_err(|error| format!("--design: {}: {error}", design.display()))?;
        command.env("SLQG_DESIGN", design);
    }
    if let Some(length) = options.sequence_length {
        command.env("SLQG_SEQUENCE_LENGTH", length.to_string());
    }
    if let Some(default_input) = &options.default_input {
        command.env("SLQG_DEFAULT_INPUT", default_input);
    }
    if options.accept_undecided_stability {
        command.env("SLQG_ACCEPT_UNDECIDED_STABILITY", "1");
    }
    // Messages are for messages: whoever calls reads the paths.
    eprintln!("building the nodes with {}", toolchain.description());
    let built = artifacts::build(&mut command)
        .map_err(|error| format!("{error}\n(the command: {})", process::shown(&command)))?;
    eprintln!("nodes built in {:.1} s", start.elapsed().as_secs_f64());
    Ok(built)
}
