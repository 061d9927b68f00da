//! The core library for the board, built once from the distribution's source.
//!
//! Later builds are told where it is by `--sysroot` and need no unstable feature.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::distribution::Distribution;
use crate::{Result, process};

/// The sysroot of this compiler version and target under the folder `below`; built if it is not there.
pub(crate) fn find_or_build(distribution: &Distribution, below: &Path, target: &str) -> Result<PathBuf> {
    let sysroot = below.join(format!("sysroot-{}-{target}", distribution.version));
    if !has_core(&sysroot, target) {
        let start = Instant::now();
        eprintln!("building the core library for {target} with rustc {}", distribution.version);
        build(distribution, below, &sysroot, target)?;
        eprintln!("core library for {target} built in {:.1} s", start.elapsed().as_secs_f64());
    }
    Ok(sysroot)
}

/// Where rustc looks for a target's libraries.
fn libraries_in(sysroot: &Path, target: &str) -> PathBuf {
    sysroot.join("lib/rustlib").join(target).join("lib")
}

/// Whether a sysroot has the target's core library.
pub(crate) fn has_core(sysroot: &Path, target: &str) -> bool {
    let is_core = |name: &str| name.starts_with("libcore-") && is_library(name);
    libraries_in(sysroot, target)
        .read_dir()
        .is_ok_and(|entries| entries.flatten().any(|entry| entry.file_name().to_str().is_some_and(is_core)))
}

fn build(distribution: &Distribution, below: &Path, sysroot: &Path, target: &str) -> Result<()> {
    fs::create_dir_all(below).map_err(|error| format!("cannot create {}: {error}", below.display()))?;
    // A folder of its own, moved into place at the end: an interrupted build leaves no half of a sysroot.
    let scratch = tempfile::Builder::new().prefix("sysroot-build-").tempdir_in(below)?;
    let (krate, output) = (scratch.path().join("crate"), scratch.path().join("target"));
    write_empty_crate(&krate)?;
    process::run(
        distribution
            .cargo()
            .current_dir(&krate)
            .args(["build", "--quiet", "--release", "-Zbuild-std=core,alloc", "--target", target])
            .env("CARGO_TARGET_DIR", &output)
            // The compiler is a stable one; its own library is what this permission exists for.
            .env("RUSTC_BOOTSTRAP", "1")
            // Link-time optimisation of the firmware reaches into these libraries.
            .env("RUSTFLAGS", "-Cembed-bitcode=yes"),
    )
    .map_err(|error| {
        format!("the core library does not build; are /usr/bin/rustc and its source alike? {error}")
    })?;

    let result = scratch.path().join("sysroot");
    let libraries = libraries_in(&result, target);
    fs::create_dir_all(&libraries)?;
    // All of them: which helpers stand between core, alloc and the compiler's built-ins depends on the version.
    for built in libraries_below(&output.join(target)) {
        fs::copy(&built, libraries.join(built.file_name().unwrap_or_default()))?;
    }
    if !has_core(&result, target) {
        return Err(format!("cargo has built no core library under {}", output.display()).into());
    }
    match fs::rename(&result, sysroot) {
        // Another run of this program was faster: its sysroot is as good.
        Err(_) if has_core(sysroot, target) => Ok(()),
        moved => Ok(moved?),
    }
}

/// A package with nothing in it. The workspace table keeps cargo from looking for one further up.
fn write_empty_crate(folder: &Path) -> Result<()> {
    const MANIFEST: &str = r#"
        [package]
        name = "empty"
        edition = "2021"
        [workspace]
        [profile.release]
        lto = false
    "#;
    fs::create_dir_all(folder.join("src"))?;
    fs::write(folder.join("Cargo.toml"), MANIFEST)?;
    fs::write(folder.join("src/lib.rs"), "#![no_std]\n")?;
    Ok(())
}

/// Searches for `lib<name>-<hash>.rlib`; the layout of a target directory is cargo's own affair and changes.
fn libraries_below(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    entries
        .flat_map(|path| match path.file_name().and_then(|name| name.to_str()) {
            _ if path.is_dir() => libraries_below(&path),
            Some(name) if is_library(name) && !name.starts_with("libempty-") => vec![path],
            _ => Vec::new(),
        })
        .collect()
}

fn is_library(file: &str) -> bool {
    file.starts_with("lib") && file.contains('-') && file.ends_with(".rlib")
}
