//! What holds for the crates that are published: they package, and no dependency needs a newer compiler than they promise.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::toolchain::{TARGET, Toolchain};
use crate::version::numbers;
use crate::workspace::Workspace;
use crate::{Result, process};

/// The crates that go to a registry, each after those it depends on.
const PUBLISHED: [&str; 4] = ["slqg", "slqg-links", "gain-gen", "host-sim"];

/// Packages the published crates as a registry would get them, without an upload, and compiles them from their packages.
///
/// Not by cargo's own check: it compiles a crate against the first package that it ever saw of another one, until the version
/// changes (`findings/cargo_package_compiles_stale_sources.sh`).
pub(crate) fn package(workspace: &Workspace) -> Result<()> {
    let mut cargo = workspace.cargo();
    // What is not committed yet is checked, too.
    cargo.args(["package", "--quiet", "--allow-dirty", "--no-verify"]);
    for name in PUBLISHED {
        cargo.args(["--package", name]);
    }
    eprintln!("   {}", process::shown(&cargo));
    process::run(&mut cargo)?;
    let folder = unpacked(workspace)?;
    process::run(workspace.cargo().args(["check", "--quiet", "--workspace"]).current_dir(&folder))
}

/// A workspace of the packages, each with the others in the place of a registry's, and nothing around it.
fn unpacked(workspace: &Workspace) -> Result<PathBuf> {
    let folder = workspace.target.join("packages");
    if folder.exists() {
        // What an earlier run has compiled stays.
        for name in PUBLISHED {
            let old = folder.join(name);
            if old.exists() {
                fs::remove_dir_all(old)?;
            }
        }
    }
    fs::create_dir_all(&folder)?;
    let (mut members, mut patches) = (String::new(), String::new());
    for name in PUBLISHED {
        let package = format!("{name}-{}", workspace.version);
        let archive = workspace.target.join("package").join(format!("{package}.crate"));
        process::run(Command::new("tar").arg("-xzf").arg(archive).arg("-C").arg(&folder))?;
        fs::rename(folder.join(package), folder.join(name))?;
        members.push_str(&format!("{name:?}, "));
        patches.push_str(&format!("{name} = {{ path = {name:?} }}\n"));
    }
    let manifest =
        format!("[workspace]\nresolver = \"3\"\nmembers = [{members}]\n\n[patch.crates-io]\n{patches}");
    fs::write(folder.join("Cargo.toml"), manifest)?;
    fs::copy(workspace.root.join("Cargo.lock"), folder.join("Cargo.lock"))?;
    Ok(folder)
}

/// Builds the core for the board by itself, without its features and with each of them alone: no other package of the
/// workspace lends it any.
pub(crate) fn core_alone(workspace: &Workspace, toolchain: &Toolchain) -> Result<()> {
    let answer =
        process::stdout_of(workspace.cargo().args(["metadata", "--no-deps", "--format-version", "1"]))?;
    let metadata: Value = serde_json::from_str(&answer)?;
    let core =
        metadata["packages"].as_array().and_then(|all| all.iter().find(|package| package["name"] == "slqg"));
    let features =
        core.and_then(|core| core["features"].as_object()).ok_or("cargo metadata names no slqg")?;
    for feature in [""].into_iter().chain(features.keys().map(String::as_str)) {
        let mut build = toolchain.cargo_build(workspace);
        build.args(["--quiet", "--profile", "firmware", "--package", "slqg", "--no-default-features"]);
        process::run(build.args(["--features", feature]))?;
    }
    Ok(())
}

/// Compares the compiler that the project promises to do with, `rust-version`, with those that its dependencies ask for, on
/// this machine and on the board.
pub(crate) fn compilers(workspace: &Workspace) -> Result<()> {
    let host = process::stdout_of(Command::new("rustc").arg("-vV"))?;
    let host = host.lines().find_map(|line| line.strip_prefix("host: ")).ok_or("rustc -vV names no host")?;
    let mut newer = Vec::new();
    for target in [host, TARGET] {
        let mut cargo = workspace.cargo();
        cargo.args(["metadata", "--locked", "--format-version", "1", "--filter-platform", target]);
        let metadata: Value = serde_json::from_str(&process::stdout_of(&mut cargo)?)?;
        newer.extend(needing_more(&metadata, &workspace.rust_version));
    }
    newer.sort();
    newer.dedup();
    if newer.is_empty() {
        return Ok(());
    }
    Err(format!(
        "Cargo.toml: rust-version: found {}, and dependencies need a newer compiler: {}; raise it, or keep older versions of \
         them in Cargo.lock",
        workspace.rust_version,
        newer.join(", ")
    )
    .into())
}

/// The packages that are resolved and ask for a newer compiler than `promised`.
fn needing_more(metadata: &Value, promised: &str) -> Vec<String> {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let resolved: Vec<Value> =
        list(&metadata["resolve"]["nodes"]).into_iter().map(|node| node["id"].clone()).collect();
    list(&metadata["packages"])
        .into_iter()
        .filter(|package| resolved.contains(&package["id"]))
        .filter_map(|package| {
            let needed = package["rust_version"].as_str()?;
            let is_newer = numbers(needed) > numbers(promised);
            is_newer.then(|| format!("{} ({needed})", package["name"].as_str().unwrap_or("?")))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dependency_that_needs_a_newer_compiler_is_named_if_it_is_used() {
        let metadata = serde_json::json!({
            "packages": [
                { "id": "a", "name": "young", "rust_version": "1.90" },
                { "id": "b", "name": "equal", "rust_version": "1.88.0" },
                { "id": "c", "name": "silent", "rust_version": null },
                { "id": "d", "name": "elsewhere", "rust_version": "1.99" },
            ],
            "resolve": { "nodes": [{ "id": "a" }, { "id": "b" }, { "id": "c" }] },
        });
        assert_eq!(needing_more(&metadata, "1.88"), ["young (1.90)"]);
        assert!(needing_more(&metadata, "1.90").is_empty());
    }
}
