//! Processor in the loop over a set of designs: host and boards must agree in every bit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::ValueEnum;

use crate::nodes::Board;
use crate::qemu::Qemu;
use crate::workspace::Workspace;
use crate::{Result, artifacts, nodes, process};

/// One run: which design, with what changed, for how long, and what happens in it.
struct Run {
    design: &'static str,
    /// Inputs per packet, where the design's are not taken.
    sequence_length: Option<u8>,
    /// Whether the actuator holds the input applied last, where the design has it fall to zero.
    holds: bool,
    /// Whether acknowledgements are taken away.
    is_silent: bool,
}

const fn plain(design: &'static str) -> Run {
    Run { design, sequence_length: None, holds: false, is_silent: false }
}

const fn held(design: &'static str) -> Run {
    Run { holds: true, ..plain(design) }
}

const fn silent(design: &'static str) -> Run {
    Run { is_silent: true, ..plain(design) }
}

/// Every way a loop can be, on a good and on a bad network.
const RUNS: [Run; 15] = [
    plain("double_integrator"),
    plain("double_integrator_bad"),
    held("double_integrator"),
    silent("double_integrator"),
    silent("double_integrator_bad"),
    plain("pendulum"),
    plain("pendulum_bad"),
    held("pendulum"),
    silent("pendulum"),
    plain("pendulum_event"),
    plain("pendulum_event_bad"),
    plain("drive_tracking"),
    plain("drive_tracking_bad"),
    plain("drive_event"),
    plain("drive_event_bad"),
];
/// Cycles of each.
const CYCLES: u32 = 10_000;

/// `cargo xtask pil`: all of [`RUNS`]; prints what each came to.
pub(crate) fn pil(workspace: &Workspace) -> Result<()> {
    Qemu::find_or_install()?;
    let host_sim = host_sim(workspace)?;
    let folder = tempfile::tempdir()?;
    for run in &RUNS {
        let design = run.design_file(workspace, folder.path())?;
        let options = nodes::Options {
            design: Some(design.clone()),
            sequence_length: run.sequence_length,
            default_input: run.holds.then(|| "hold".to_owned()),
            board: Board::Mps2An386,
        };
        loop_with(&host_sim, workspace, &options, &["--cycles", &CYCLES.to_string()])?;
    }
    Ok(())
}

/// What every test run shows: both boards, both lines, and nodes that are killed; on the design that nodes are built for
/// unless told otherwise.
pub(crate) fn check(workspace: &Workspace) -> Result<()> {
    let host_sim = host_sim(workspace)?;
    let design = Some(workspace.root.join("designs/pendulum.toml"));
    for board in [Board::Mps2An386, Board::Lm3s6965evb] {
        let options =
            nodes::Options { design: design.clone(), sequence_length: None, default_input: None, board };
        let runs: [&[&str]; 2] = [
            &["--transport", "uart", "--cycles", "200"],
            &["--transport", "bulk", "--cycles", "2000", "--restarts", "10"],
        ];
        let images = Images::build(workspace, &options)?;
        for run in runs {
            images.run(&host_sim, &options, run)?;
        }
    }
    Ok(())
}

fn host_sim(workspace: &Workspace) -> Result<PathBuf> {
    let built = artifacts::build(workspace.cargo().args(["build", "--workspace", "--bins"]))?;
    Ok(built.binary("host-sim")?.to_owned())
}

fn loop_with(host_sim: &Path, workspace: &Workspace, options: &nodes::Options, run: &[&str]) -> Result<()> {
    Images::build(workspace, options)?.run(host_sim, options, run)
}

/// The nodes' programs for a design and a board.
struct Images(artifacts::Built);

impl Images {
    fn build(workspace: &Workspace, options: &nodes::Options) -> Result<Self> {
        match nodes::build(workspace, options)? {
            built if built.warned => Err("the compiler warns about code for the board".into()),
            built => Ok(Self(built)),
        }
    }

    /// A difference in one bit is an error.
    fn run(&self, host_sim: &Path, options: &nodes::Options, run: &[&str]) -> Result<()> {
        let suffix = if run.contains(&"uart") { "" } else { "_bulk" };
        let mut command = Command::new(host_sim);
        command.arg("pil").args(&options.design).args(run);
        if let Some(length) = options.sequence_length {
            command.args(["--sequence-length", &length.to_string()]);
        }
        if let Some(default_input) = &options.default_input {
            command.args(["--default-input", default_input]);
        }
        if let Some(board) = options.board.to_possible_value() {
            command.args(["--board", board.get_name()]);
        }
        command.arg("--controller-image").arg(self.0.binary(&format!("controller{suffix}"))?);
        command.arg("--actuator-image").arg(self.0.binary(&format!("actuator{suffix}"))?);
        process::run(&mut command)
    }
}

impl Run {
    /// The design as it is, or a copy without acknowledgements.
    fn design_file(&self, workspace: &Workspace, folder: &Path) -> Result<PathBuf> {
        let file = workspace.root.join("designs").join(self.design).with_extension("toml");
        if !self.is_silent {
            return Ok(file);
        }
        let text = fs::read_to_string(&file)?;
        let told = "acknowledgement = \"instant\"";
        if !text.contains(told) {
            return Err(format!("{}: found no `{told}` to take away", file.display()).into());
        }
        let silent = folder.join(format!("{}_silent.toml", self.design));
        fs::write(&silent, text.replace(told, "acknowledgement = \"none\""))?;
        Ok(silent)
    }
}
