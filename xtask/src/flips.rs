//! Bits that flip in the memory of both nodes, in QEMU, and what becomes of them.

use std::path::PathBuf;

use clap::Args;

use crate::nodes::{self, Board};
use crate::qemu::Qemu;
use crate::workspace::Workspace;
use crate::{Result, artifacts, process};

/// What is flipped, and in which programs.
#[derive(Args)]
pub(crate) struct Options {
    /// Flips in the memory of each node
    #[arg(long, default_value_t = 1000)]
    flips: u32,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print each flip that was not masked
    #[arg(long)]
    each: bool,
    /// A folder with `controller_bulk` and `actuator_bulk` of the pendulum with N = 4, of another version of the nodes; without it
    /// they are built
    #[arg(long, value_name = "FOLDER")]
    images: Option<PathBuf>,
}

/// `cargo xtask flips`: prints a table by node and kind of memory, see `firmware/faults`.
pub(crate) fn flips(workspace: &Workspace, options: &Options) -> Result<()> {
    Qemu::find_or_install()?;
    let images = ["controller_bulk", "actuator_bulk"];
    let images: Vec<PathBuf> = match &options.images {
        Some(folder) => images.iter().map(|name| folder.join(name)).collect(),
        None => {
            let built = nodes::build(workspace, &nodes_of_the_pendulum(workspace))?;
            images.iter().map(|name| Ok(built.binary(name)?.to_owned())).collect::<Result<_>>()?
        }
    };
    let built = artifacts::build(workspace.cargo().args(["build", "--package", "slqg-faults"]))?;
    let mut command = std::process::Command::new(built.binary("slqg-faults")?);
    command.args(&images).arg("--flips").arg(options.flips.to_string());
    command.arg("--seed").arg(options.seed.to_string()).args(options.each.then_some("--each"));
    process::run(&mut command)
}

fn nodes_of_the_pendulum(workspace: &Workspace) -> nodes::Options {
    nodes::Options {
        design: Some(workspace.root.join("designs/pendulum.toml")),
        sequence_length: None,
        default_input: None,
        accept_undecided_stability: false,
        tuning: false,
        slices: None,
        keys: None,
        board: Board::Mps2An386,
    }
}
