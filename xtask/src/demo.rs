//! What the project does, on one example: a pendulum over a lossy link.

use std::fs;

use crate::workspace::Workspace;
use crate::{Result, process};

const DESIGN: &str = "designs/pendulum.toml";

/// `cargo xtask demo`: the gains and the stability verdict, then a comparison in simulation, with plots.
pub(crate) fn demo(workspace: &Workspace) -> Result<()> {
    let folder = workspace.target.join("demo");
    fs::create_dir_all(&folder).map_err(|error| format!("cannot create {}: {error}", folder.display()))?;
    let report = folder.join("pendulum.html");

    process::run(
        workspace
            .cargo()
            .args(["run", "--quiet", "-p", "gain-gen", "--bin", "gain-gen", "--", "report", DESIGN]),
    )?;
    process::run(
        workspace
            .cargo()
            .args(["run", "--quiet", "-p", "host-sim", "--bin", "host-sim", "--", "run", DESIGN])
            .args(["--controllers", "slqg,lqg", "--runs", "200", "--steps", "500", "--seed", "1", "--report"])
            .arg(&report),
    )?;
    Ok(())
}
