//! The two nodes for a design and a board.

use std::path::{Path, PathBuf};
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
    /// Build nodes whose frames are sealed, for a design that says so: a key file, or `test` for keys that everybody knows
    #[arg(long, value_name = "FILE|test", requires = "design")]
    pub(crate) keys: Option<PathBuf>,
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

/// A key file as the build script finds it, which runs elsewhere.
fn absolute(keys: &Path) -> Result<PathBuf> {
    if keys == Path::new("test") {
        return Ok(keys.into());
    }
    Ok(keys.canonicalize().map_err(|error| format!("--keys: {}: {error}", keys.display()))?)
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
    if let Some(keys) = &options.keys {
        command.args(["--features", "authentication"]).env("SLQG_KEYS", absolute(keys)?);
    }
    if let Some(design) = &options.design {
        // Where it is not needed after all, it is a little code more.
        let text = std::fs::read_to_string(design).unwrap_or_default();
        let is_silent = |line: &str| line.contains("acknowledgement") && line.contains("none");
        if text.lines().any(is_silent) {
            command.args(["--features", "linear"]);
        }
        if text
            .lines()
            .any(|line| line.trim_start().starts_with("base =") || line.trim_start().starts_with("rule ="))
        {
            command.args(["--features", "schedule"]);
        }
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
