//! The distribution's own Rust compiler, in `/usr/bin`, with its library source.
//!
//! It builds firmware where the active toolchain lacks the board's core library. Library source and compiler must be of
//! the same version, hence both from packages. The active toolchain is usually another one, so a command for this
//! compiler starts from an environment in which nothing of the active one is left.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::version::numbers;
use crate::workspace::Workspace;
use crate::{Result, packages, process};

const RUSTC: &str = "/usr/bin/rustc";
const RUSTDOC: &str = "/usr/bin/rustdoc";
const CARGO: &str = "/usr/bin/cargo";
const LINKER: &str = "/usr/bin/ld.lld";

/// A compiler in `/usr/bin` that can build the core library for another target.
pub(crate) struct Distribution {
    /// For example `1.85.0`.
    pub(crate) version: String,
}

impl Distribution {
    /// Looks for the compiler, its source and a linker; installs what is missing where that is possible.
    pub(crate) fn find_or_install(workspace: &Workspace, other_way: &str) -> Result<Self> {
        let missing = match Self::find(&workspace.rust_version) {
            Ok(found) => return Ok(found),
            Err(missing) => missing,
        };
        packages::refresh_index();
        // A stable release keeps its compiler, and has beside it the newer one that its web browser is built with.
        let web = if packages::known("rustc") && !packages::known("rustc-web") { "" } else { "-web" };
        let list = [format!("rustc{web}"), format!("cargo{web}"), format!("rust{web}-src"), "lld".to_owned()];
        let advice = format!(
            "Run one of:\n  {other_way}\n  apt-get install --no-install-recommends {}   (as root, on Debian)",
            list.join(" ")
        );
        packages::install(&list, &missing, &advice)?;
        Self::find(&workspace.rust_version)
            .map_err(|missing| format!("even with {}: {missing}.\n{advice}", list.join(" ")).into())
    }

    /// The compiler if it is complete, otherwise what is missing.
    fn find(rust_version: &str) -> Result<Self, String> {
        for file in [RUSTC, CARGO, LINKER] {
            if !Path::new(file).is_file() {
                return Err(format!("{file} is missing"));
            }
        }
        let version = process::stdout_of(clean(Command::new(RUSTC)).arg("-vV"))
            .ok()
            .and_then(|answer| {
                answer.lines().find_map(|line| line.strip_prefix("release: ").map(str::to_owned))
            })
            .ok_or_else(|| format!("{RUSTC} does not tell its version"))?;
        if numbers(&version) < numbers(rust_version) {
            return Err(format!("{RUSTC} is {version}, the firmware needs {rust_version}"));
        }
        let sysroot = process::stdout_of(clean(Command::new(RUSTC)).args(["--print", "sysroot"]))
            .map_err(|error| error.to_string())?;
        let core = PathBuf::from(sysroot.trim()).join("lib/rustlib/src/rust/library/core/src/lib.rs");
        if !core.is_file() {
            return Err(format!("the library source of {RUSTC} is missing ({})", core.display()));
        }
        Ok(Self { version })
    }

    /// Its cargo, which runs its compiler and nothing of the active toolchain.
    pub(crate) fn cargo(&self) -> Command {
        let mut command = clean(Command::new(CARGO));
        command.env("RUSTC", RUSTC).env("RUSTDOC", RUSTDOC);
        command
    }

    /// The linker for the board.
    pub(crate) fn linker(&self) -> &'static str {
        LINKER
    }
}

/// Takes the active toolchain's variables from a command.
fn clean(mut command: Command) -> Command {
    for (name, _) in env::vars_os() {
        if name.to_str().is_some_and(belongs_to_active_toolchain) {
            command.env_remove(name);
        }
    }
    command
}

/// Whether a variable selects or describes a compiler. Cargo's network settings do not, and stay.
fn belongs_to_active_toolchain(name: &str) -> bool {
    const SETTINGS: [&str; 7] = [
        "CARGO_HOME",
        "CARGO_HTTP_",
        "CARGO_NET_",
        "CARGO_REGISTR",
        "CARGO_SOURCE_",
        "CARGO_TERM_",
        "CARGO_BUILD_JOBS",
    ];
    // `cargo run` puts the active toolchain's libraries on the loader's path.
    const COMPILER: [&str; 6] = ["CARGO", "RUSTUP_", "RUSTC", "RUSTDOC", "RUSTFLAGS", "LD_LIBRARY_PATH"];
    let starts_with_any = |prefixes: &[&str]| prefixes.iter().any(|prefix| name.starts_with(prefix));
    starts_with_any(&COMPILER) && !starts_with_any(&SETTINGS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_of_the_active_toolchain_go_and_network_settings_stay() {
        for name in
            ["CARGO", "CARGO_ENCODED_RUSTFLAGS", "CARGO_BUILD_RUSTC", "RUSTUP_TOOLCHAIN", "RUSTC_WRAPPER"]
        {
            assert!(belongs_to_active_toolchain(name), "{name}");
        }
        for name in
            ["CARGO_HOME", "CARGO_HTTP_CAINFO", "CARGO_NET_OFFLINE", "CARGO_REGISTRIES_X_INDEX", "PATH"]
        {
            assert!(!belongs_to_active_toolchain(name), "{name}");
        }
    }
}
