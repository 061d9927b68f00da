//! Programs for parts that nothing here emulates: they are built, and that is all that is known of them.

use std::time::Instant;

use crate::artifacts;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;
use crate::{Result, process};

/// Folder of the example on a CAN bus: a workspace of its own, whose settings are in its `.cargo`.
const CAN: &str = "firmware/examples/stm32f407_can";

/// Builds the examples with the versions of their lock files. Neither formatter nor compiler may have anything to say.
pub(crate) fn check(workspace: &Workspace, toolchain: &Toolchain) -> Result<()> {
    let folder = workspace.root.join(CAN);
    // Checks of the workspace do not see another one.
    process::run(workspace.cargo().current_dir(&folder).args(["fmt", "--", "--check"]))?;
    eprintln!("building {CAN} with {}", toolchain.description());
    let start = Instant::now();
    let mut command = toolchain.cargo_build(workspace);
    // The linker looks for memory.x in the folder of the workspace first.
    command.current_dir(&folder).args(["--bins", "--profile", "firmware", "--locked"]);
    if !command.get_envs().any(|(name, _)| name == "CARGO_TARGET_DIR") {
        command.env("CARGO_TARGET_DIR", &workspace.target);
    }
    // The design and the board are the example's own, whatever the caller's environment says.
    command.env_remove("SLQG_DESIGN").env_remove("SLQG_BOARD").env_remove("SLQG_SEQUENCE_LENGTH");
    let built = artifacts::build(&mut command)
        .map_err(|error| format!("{error}\n(the command: {})", process::shown(&command)))?;
    if built.warned {
        return Err(format!("the compiler warns about {CAN}").into());
    }
    if built.binaries.len() != 2 {
        return Err(format!("{CAN}: cargo has built {} binaries instead of two", built.binaries.len()).into());
    }
    eprintln!("{CAN} built in {:.1} s", start.elapsed().as_secs_f64());
    Ok(())
}
