//! A cargo build and the binaries it has made.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::{Result, process};

/// What a build has brought.
pub(crate) struct Built {
    pub(crate) binaries: Vec<PathBuf>,
    /// Whether the compiler had something to say about the workspace's own code.
    pub(crate) warned: bool,
}

/// Runs a `cargo build` to the end; what the compiler says is passed on.
pub(crate) fn build(cargo_build: &mut Command) -> Result<Built> {
    let (messages, ended) = process::output_of(cargo_build.args(["--quiet", "--message-format=json"]))?;
    let mut built = Built { binaries: Vec::new(), warned: false };
    for message in messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok()) {
        if let Some(rendered) = message["message"]["rendered"].as_str() {
            eprint!("{rendered}");
            built.warned = true;
        }
        // Cargo says where it puts things; its folders are not guessed here.
        if let Some(binary) = message["executable"].as_str() {
            built.binaries.push(binary.into());
        }
    }
    ended?;
    Ok(built)
}

impl Built {
    /// The binary of that name.
    pub(crate) fn binary(&self, name: &str) -> Result<&Path> {
        let found = self.binaries.iter().find(|binary| binary.file_stem().is_some_and(|stem| stem == name));
        Ok(found.ok_or_else(|| format!("cargo has built no binary {name}"))?)
    }
}
