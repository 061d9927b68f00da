//! Which compiler builds for the board.
//!
//! First choice is the active toolchain, if it has the target's core library; then the distribution's compiler with a
//! core library built from its source. Rustup is never made to download anything: what it installs is its owner's choice.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::distribution::Distribution;
use crate::workspace::Workspace;
use crate::{Result, process, sysroot};

/// Cortex-M4F and M7F, with the floating-point unit's calling convention.
pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";
/// Cortex-M3, without floating-point unit.
pub(crate) const SOFT_FLOAT_TARGET: &str = "thumbv7m-none-eabi";

/// A way to compile for a target.
pub(crate) struct Toolchain {
    target: &'static str,
    way: Way,
}

enum Way {
    /// The active toolchain as it is, with its own linker.
    Active,
    /// The distribution's compiler and linker, with a core library of our building.
    Distribution { compiler: Distribution, sysroot: PathBuf },
}

impl Toolchain {
    /// Looks for a way to compile for [`TARGET`].
    pub(crate) fn find(workspace: &Workspace) -> Result<Self> {
        Self::find_for(workspace, TARGET)
    }

    /// Looks for a way, and sets up the second one where it can.
    pub(crate) fn find_for(workspace: &Workspace, target: &'static str) -> Result<Self> {
        if active_has_target(workspace, target) {
            return Ok(Self { target, way: Way::Active });
        }
        let compiler = Distribution::find_or_install(workspace, &rustup_command(target))?;
        let sysroot = sysroot::find_or_build(&compiler, &workspace.target, target)?;
        Ok(Self { target, way: Way::Distribution { compiler, sysroot } })
    }

    /// `cargo build` for the board. Arguments that select packages and profile are the caller's.
    pub(crate) fn cargo_build(&self, workspace: &Workspace) -> Command {
        let mut command = match &self.way {
            Way::Active => workspace.cargo(),
            Way::Distribution { compiler, sysroot } => {
                let mut command = compiler.cargo();
                command
                    .current_dir(&workspace.root)
                    // Build scripts are compiled for the host by this compiler, too. In a folder of their own they do
                    // not push out what the active one has built.
                    .env("CARGO_TARGET_DIR", workspace.target.join(format!("rustc-{}", compiler.version)))
                    .env(linker_of(self.target), compiler.linker())
                    // One flag without a separator, so that the folder's name may hold blanks. With `--target`, flags
                    // do not reach build scripts.
                    .env("CARGO_ENCODED_RUSTFLAGS", format!("--sysroot={}", sysroot.display()));
                command
            }
        };
        command.args(["build", "--target", self.target]);
        command
    }

    /// For messages.
    pub(crate) fn description(&self) -> String {
        match &self.way {
            Way::Active => "the active toolchain".to_owned(),
            Way::Distribution { compiler, .. } => format!("the distribution's rustc {}", compiler.version),
        }
    }
}

/// Asks the active rustc where its libraries for the target are, and looks.
fn active_has_target(workspace: &Workspace, target: &str) -> bool {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let mut command = Command::new(rustc);
    command.current_dir(&workspace.root).args(["--print", "sysroot"]);
    process::stdout_of(&mut command).is_ok_and(|answer| sysroot::has_core(Path::new(answer.trim()), target))
}

/// What the owner of a rustup installation would run.
fn rustup_command(target: &str) -> String {
    match env::var("RUSTUP_TOOLCHAIN") {
        Ok(toolchain) => format!("rustup target add {target} --toolchain {toolchain}"),
        Err(_) => format!("rustup target add {target}"),
    }
}

/// Cargo's variable for the linker of one target alone.
fn linker_of(target: &str) -> String {
    format!("CARGO_TARGET_{}_LINKER", target.to_uppercase().replace('-', "_"))
}
