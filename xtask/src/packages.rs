//! Distribution packages: what is missing is installed where that needs no questions, and named where not.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::{Result, process};

/// Fetches the package index where [`install`] would make use of it. A fresh container has none.
pub(crate) fn refresh_index() {
    if can_install() {
        // An index that is partly out of reach may still do; installing shows it.
        if let Err(error) = process::run(apt_get().arg("update")) {
            eprintln!("warning: {error}");
        }
    }
}

/// Installs Debian packages if this is root on a system with apt-get; otherwise fails with `advice`.
pub(crate) fn install(packages: &[String], why: &str, advice: &str) -> Result<()> {
    if !can_install() {
        return Err(format!("{why}.\n{advice}").into());
    }
    let list = packages.join(" ");
    eprintln!("{why}; installing Debian packages: {list}");
    // Never at the price of something else on this machine: Debian's compilers conflict with one another.
    process::run(
        apt_get().args(["install", "--yes", "--no-install-recommends", "--no-remove"]).args(packages),
    )
    .map_err(|error| format!("could not install {list}: {error}\n{advice}").into())
}

/// Unpacks a package and what it needs into `folder/root`, beside what this machine has: for a program that could only be
/// installed at the price of another one.
pub(crate) fn unpack(package: &str, folder: &Path) -> Result<PathBuf> {
    if !can_install() {
        return Err(format!("{package} can be fetched by root on a Debian-like system only").into());
    }
    eprintln!("unpacking {package} and what it needs into {}", folder.display());
    let (archives, root) = (folder.join("archives"), folder.join("root"));
    fs::create_dir_all(archives.join("partial"))?;
    fs::create_dir_all(&root)?;
    let kept = format!("Dir::Cache::archives={}", archives.display());
    process::run(apt_get().args([
        "-o",
        &kept,
        "-o",
        "APT::Sandbox::User=root",
        "install",
        "--yes",
        "--no-install-recommends",
        "--download-only",
        package,
    ]))?;
    for file in fs::read_dir(&archives)? {
        let file = file?.path();
        if file.extension().is_some_and(|extension| extension == "deb") {
            process::run(Command::new("dpkg-deb").arg("-x").arg(file).arg(&root))?;
        }
    }
    Ok(root)
}

fn can_install() -> bool {
    process::on_path("apt-get").is_some() && is_root()
}

/// Whether the package index knows a package.
pub(crate) fn known(package: &str) -> bool {
    process::succeeds(Command::new("apt-cache").args(["show", package]))
}

fn apt_get() -> Command {
    let mut command = Command::new("apt-get");
    command
        .env("DEBIAN_FRONTEND", "noninteractive")
        // Wait for another package manager rather than fail.
        .args(["-qq", "-o", "DPkg::Lock::Timeout=300", "-o", "Dpkg::Use-Pty=0"])
        .stdin(Stdio::null())
        .stdout(std::io::stderr());
    command
}

fn is_root() -> bool {
    process::stdout_of(Command::new("id").arg("-u")).is_ok_and(|user| user.trim() == "0")
}
