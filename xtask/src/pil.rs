//! Processor in the loop over a set of designs: host and boards must agree in every bit.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::ValueEnum;
use serde_json::Value;

use crate::nodes::Board;
use crate::process::print;
use crate::qemu::Qemu;
use crate::workspace::Workspace;
use crate::{Result, artifacts, nodes, process, size};

/// One run: which design, with what changed, for how long, and what happens in it.
struct Run {
    design: &'static str,
    /// Whether the actuator holds the input applied last, where the design has it fall to zero.
    holds: bool,
    /// Whether acknowledgements are taken away.
    is_silent: bool,
    /// Whether frames are sealed, with keys for tests.
    is_sealed: bool,
}

const fn plain(design: &'static str) -> Run {
    Run { design, holds: false, is_silent: false, is_sealed: false }
}

const fn held(design: &'static str) -> Run {
    Run { holds: true, ..plain(design) }
}

const fn silent(design: &'static str) -> Run {
    Run { is_silent: true, ..plain(design) }
}

const fn sealed(design: &'static str) -> Run {
    Run { is_sealed: true, ..plain(design) }
}

/// Every way a loop can be, on a good and on a bad network.
const RUNS: [Run; 22] = [
    plain("double_integrator"),
    plain("double_integrator_bad"),
    held("double_integrator"),
    held("double_integrator_bad"),
    silent("double_integrator"),
    silent("double_integrator_bad"),
    plain("pendulum"),
    plain("pendulum_bad"),
    held("pendulum"),
    held("pendulum_bad"),
    silent("pendulum"),
    silent("pendulum_bad"),
    plain("pendulum_event"),
    plain("pendulum_event_bad"),
    plain("drive_tracking"),
    plain("drive_tracking_bad"),
    silent("drive_tracking"),
    silent("drive_tracking_bad"),
    plain("drive_event"),
    plain("drive_event_bad"),
    sealed("pendulum"),
    sealed("pendulum_bad"),
];
/// What the nodes of the pendulum with eight inputs per packet may take: flash and RAM in bytes, stack included.
const LIMITS: [(&str, u64, u64); 2] =
    [("controller", 48 * 1024, 8 * 1024), ("actuator", 16 * 1024, 2 * 1024)];
/// Cycles of each in which links are dead: a second in one go, and single links. The simulated plant is held by nobody meanwhile.
const OUTAGES: [&str; 6] =
    ["--outage", "3000+50", "--outage", "sensor@5000+30", "--outage", "control@7000+30"];
/// Inputs per packet in the test.
const TESTED_LENGTH: u8 = 8;
/// Cycles of each.
const CYCLES: u32 = 10_000;

/// `cargo xtask pil`: all of [`RUNS`], a row of a table for each. Ends at the first difference, which `host-sim` then tells.
pub(crate) fn pil(workspace: &Workspace) -> Result<()> {
    Qemu::find_or_install()?;
    let host_sim = host_sim(workspace)?;
    let folder = tempfile::tempdir()?;
    print(format_args!("{:49}   controller        actuator", ""))?;
    print("design                 loop            N  cycles    sent    flash    RAM    flash    RAM")?;
    for run in &RUNS {
        let options = nodes::Options {
            design: Some(run.design_file(workspace, folder.path())?),
            sequence_length: None,
            default_input: run.holds.then(|| "hold".to_owned()),
            tuning: false,
            slices: None,
            keys: run.is_sealed.then(|| "test".into()),
            accept_undecided_stability: true,
            board: Board::Mps2An386,
        };
        let images = Images::build(workspace, &options)?;
        let outcome = images.outcome(&host_sim, &options, CYCLES, &OUTAGES)?;
        let number = |of: &str| outcome[of].as_u64().unwrap_or_default();
        let (length, sent) = (number("sequence_length"), number("sent"));
        let mut line = format!("{:<22} {:<14} {length:>2} {CYCLES:>7} {sent:>7}", run.design, run.changed());
        for (node, ..) in LIMITS {
            let (flash, ram) = (size::flash(images.0.binary(node)?)?, ram(&outcome, node)?);
            line.push_str(&format!("   {flash:>6} {ram:>6}"));
        }
        print(line)?;
    }
    print("every frame and every applied input of all of them equal, to the bit; flash and RAM in bytes")?;
    Ok(())
}

/// Variables and stack of a node, in bytes.
fn ram(outcome: &Value, node: &str) -> Result<u64> {
    let bytes = |of: &str| outcome[node][of].as_u64().ok_or_else(|| format!("no {node}.{of} in the outcome"));
    Ok(bytes("stack")? + bytes("variables")?)
}

/// What every test run shows: both boards, both lines, nodes that are killed, a controller that tunes itself or is sent gains, and
/// that the nodes are small.
pub(crate) fn check(workspace: &Workspace) -> Result<()> {
    let host_sim = host_sim(workspace)?;
    for board in [Board::Mps2An386, Board::Lm3s6965evb] {
        let options = nodes::Options {
            design: Some(workspace.root.join("designs/pendulum.toml")),
            sequence_length: Some(TESTED_LENGTH),
            default_input: None,
            // The controller that tunes itself beside the others; it does as many slices as `host-sim` expects.
            tuning: board == Board::Mps2An386,
            slices: None,
            keys: None,
            accept_undecided_stability: false,
            board,
        };
        let images = Images::build(workspace, &options)?;
        images.run(&host_sim, &options, &["--transport", "uart", "--cycles", "200"])?;
        images.run(&host_sim, &options, &["--cycles", "2000", "--restarts", "10"])?;
        // Long enough for both ends to be lost, and to say so.
        images.run(&host_sim, &options, &["--cycles", "1500", "--outage", "700+130"])?;
        if board == Board::Mps2An386 {
            images.check_size(&host_sim, &options)?;
            let bad = workspace.root.join("designs/pendulum_bad.toml");
            let change = ["--tuning", "--at", "500", "--cycles", "3000", "--changes-to"];
            let bad = bad.to_str().ok_or("the workspace's folder has a name that is not UTF-8")?;
            images.run(&host_sim, &options, &[&change[..], &[bad]].concat())?;
            // Gains for the other network come over the link: status 0 says that they are in force.
            let replace = ["--gains-at", "500", "--cycles", "1000", "--gains-of"];
            images.run(&host_sim, &options, &[&replace[..], &[bad]].concat())?;
        }
    }
    Ok(())
}

fn host_sim(workspace: &Workspace) -> Result<PathBuf> {
    let built = artifacts::build(workspace.cargo().args(["build", "--workspace", "--bins"]))?;
    Ok(built.binary("host-sim")?.to_owned())
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
        process::run(&mut self.command(host_sim, options, run)?)
    }

    /// Holds flash, and the RAM of a run, against [`LIMITS`].
    fn check_size(&self, host_sim: &Path, options: &nodes::Options) -> Result<()> {
        let outcome = self.outcome(host_sim, options, 2000, &[])?;
        for (node, most_flash, most_ram) in LIMITS {
            let flash = size::flash(self.0.binary(node)?)?;
            let ram = ram(&outcome, node)?;
            eprintln!("{node}: flash {flash} of {most_flash} bytes, RAM {ram} of {most_ram}");
            if flash > most_flash || ram > most_ram {
                return Err(format!("the {node} node has outgrown its limits").into());
            }
        }
        Ok(())
    }

    /// What a run came to, as `host-sim` tells it; a difference in one bit is an error.
    fn outcome(
        &self,
        host_sim: &Path,
        options: &nodes::Options,
        cycles: u32,
        more: &[&str],
    ) -> Result<Value> {
        let cycles = cycles.to_string();
        let run = [&["--cycles", &cycles, "--json"], more].concat();
        Ok(serde_json::from_str(&process::stdout_of(&mut self.command(host_sim, options, &run)?)?)?)
    }

    fn command(&self, host_sim: &Path, options: &nodes::Options, run: &[&str]) -> Result<Command> {
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
        let tuning = if run.contains(&"--tuning") { "tuning_" } else { "" };
        command.arg("--controller-image").arg(self.0.binary(&format!("{tuning}controller{suffix}"))?);
        command.arg("--actuator-image").arg(self.0.binary(&format!("actuator{suffix}"))?);
        Ok(command)
    }
}

impl Run {
    /// What is changed in the design.
    fn changed(&self) -> &'static str {
        match self {
            Self { holds: true, .. } => "held",
            Self { is_silent: true, .. } => "unacknowledged",
            Self { is_sealed: true, .. } => "sealed",
            _ => "as it is",
        }
    }

    /// The design as it is, or a copy without acknowledgements or with sealed frames.
    fn design_file(&self, workspace: &Workspace, folder: &Path) -> Result<PathBuf> {
        let file = workspace.root.join("designs").join(self.design).with_extension("toml");
        if self.is_sealed {
            let copy = folder.join(format!("{}_sealed.toml", self.design));
            let wire = "\n[wire]\nformat = \"bytes\"\nauthentication = \"cmac\"\n";
            fs::write(&copy, fs::read_to_string(&file)? + wire)?;
            return Ok(copy);
        }
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
