//! What the project does, on one example: a pendulum over a lossy link.

use std::fs;
use std::process::Command;

use crate::workspace::Workspace;
use crate::{Result, artifacts, process};

const DESIGN: &str = "designs/pendulum.toml";

/// `cargo xtask demo`: the gains and the stability verdict, then a comparison in simulation, with plots.
pub(crate) fn demo(workspace: &Workspace) -> Result<()> {
    let folder = workspace.target.join("demo");
    fs::create_dir_all(&folder).map_err(|error| format!("cannot create {}: {error}", folder.display()))?;
    let report = folder.join("pendulum.html");

    eprintln!("building, which takes some minutes the first time");
    // The whole workspace at once, as `test` builds it: cargo builds dependencies again for another choice of packages.
    let built = artifacts::build(workspace.cargo().args(["build", "--workspace", "--bins"]))?;
    let run = |name: &str| -> Result<Command> {
        let mut command = Command::new(built.binary(name)?);
        command.current_dir(&workspace.root);
        Ok(command)
    };
    process::run(run("gain-gen")?.args(["report", DESIGN]))?;
    process::run(
        run("host-sim")?
            .args(["run", DESIGN, "--controllers", "slqg,lqg", "--runs", "200", "--steps", "500"])
            .args(["--seed", "1", "--report"])
            .arg(&report),
    )
}
