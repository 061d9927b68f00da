//! Where the workspace is, and its cargo.

use std::env;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::{Result, process};

/// The workspace as cargo sees it, settings and environment included.
pub(crate) struct Workspace {
    pub(crate) root: PathBuf,
    pub(crate) target: PathBuf,
    /// Oldest compiler that builds the firmware, from `rust-version`.
    pub(crate) rust_version: String,
    /// The version that all of the crates have.
    pub(crate) version: String,
}

impl Workspace {
    /// Asks cargo, so that this works from any folder of the workspace and with any target directory.
    pub(crate) fn find() -> Result<Self> {
        let answer =
            process::stdout_of(active_cargo().args(["metadata", "--no-deps", "--format-version", "1"]))?;
        let metadata: Value = serde_json::from_str(&answer)
            .map_err(|error| format!("cargo metadata answered something unexpected: {error}"))?;
        let nodes = metadata["packages"]
            .as_array()
            .and_then(|packages| packages.iter().find(|package| package["name"] == "slqg-bench"));
        Ok(Self {
            root: text(&metadata["workspace_root"], "workspace_root")?.into(),
            target: text(&metadata["target_directory"], "target_directory")?.into(),
            rust_version: text(nodes.map_or(&Value::Null, |nodes| &nodes["rust_version"]), "rust_version")?
                .to_owned(),
            version: text(nodes.map_or(&Value::Null, |nodes| &nodes["version"]), "version")?.to_owned(),
        })
    }

    /// The active toolchain's cargo, in the root of the workspace.
    pub(crate) fn cargo(&self) -> Command {
        let mut cargo = active_cargo();
        cargo.current_dir(&self.root);
        cargo
    }
}

/// The cargo that runs this program.
fn active_cargo() -> Command {
    Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

fn text<'a>(value: &'a Value, key: &str) -> Result<&'a str> {
    Ok(value.as_str().ok_or_else(|| format!("cargo metadata names no {key}"))?)
}
