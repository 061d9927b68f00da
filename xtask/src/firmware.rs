//! Images for the reference board, and the proof that they compute what the host computes.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::artifacts::{self, Built};
use crate::process::print;
use crate::qemu::Qemu;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;
use crate::{Result, process};

/// The loop that host and board run alike.
const CLOSED_LOOP: &str = "closed_loop";

/// Far beyond any run: it is there so that a hanging image fails.
const LIMIT: Duration = Duration::from_secs(120);

/// `cargo xtask firmware`.
pub(crate) fn firmware(workspace: &Workspace, run: bool) -> Result<()> {
    let built = build(workspace, &Toolchain::find(workspace)?)?;
    if run {
        compare(workspace, &Qemu::find_or_install()?, &built)?;
    }
    for image in &built.binaries {
        print(image.display())?;
    }
    Ok(())
}

/// Builds every binary of the nodes. Code for the board alone is seen by no other check.
pub(crate) fn build(workspace: &Workspace, toolchain: &Toolchain) -> Result<Built> {
    eprintln!("building the firmware with {}", toolchain.description());
    let start = Instant::now();
    let built = artifacts::build(toolchain.cargo_build(workspace).args([
        "--package",
        "slqg-bench",
        "--bins",
        "--profile",
        "firmware",
    ]))?;
    if built.binaries.is_empty() {
        return Err("cargo has built no binary of slqg-bench".into());
    }
    eprintln!("firmware built in {:.1} s", start.elapsed().as_secs_f64());
    Ok(built)
}

/// Runs the closed loop on host and board. Its digest must be equal, and the comparison must be able to fail.
pub(crate) fn compare(workspace: &Workspace, qemu: &Qemu, built: &Built) -> Result<()> {
    let image = built.binary(CLOSED_LOOP)?;
    let for_host = artifacts::build(workspace.cargo().args(["build", "--workspace", "--bins"]))?;
    let on_host = process::stdout_of(&mut Command::new(for_host.binary(CLOSED_LOOP)?))?;
    let digest = digest_in(&on_host)
        .ok_or_else(|| format!("{CLOSED_LOOP} on the host ends without a line `end 1a2b3c4d`:\n{on_host}"))?;

    let board = qemu.run(image, &[digest], LIMIT)?;
    if !board.status.success() {
        let printed = &board.output;
        return Err(format!("board and host differ.\n-- host:\n{on_host}-- board:\n{printed}").into());
    }
    must_fail(qemu, image, &[&another(digest)], "a wrong digest")?;
    must_fail(qemu, image, &[], "no digest")?;
    eprintln!("board and host agree, digest {digest}");
    Ok(())
}

/// A check that cannot fail proves nothing.
fn must_fail(qemu: &Qemu, image: &Path, arguments: &[&str], what: &str) -> Result<()> {
    let ended = qemu.run(image, arguments, LIMIT)?;
    if ended.status.code() == Some(1) {
        return Ok(());
    }
    Err(format!("given {what}, the image must exit with status 1; {}:\n{}", ended.status, ended.output)
        .into())
}

/// The digest in the last line, `end 1a2b3c4d`.
fn digest_in(output: &str) -> Option<&str> {
    let digest = output.lines().next_back()?.strip_prefix("end ")?;
    (digest.len() == 8 && digest.bytes().all(|byte| byte.is_ascii_hexdigit())).then_some(digest)
}

/// A digest that differs in one bit.
fn another(digest: &str) -> String {
    format!("{:08x}", u32::from_str_radix(digest, 16).unwrap_or_default() ^ 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digest_is_read_from_the_last_line_only() {
        assert_eq!(digest_in("state 1\nend 0a1b2c3d\n"), Some("0a1b2c3d"));
        assert_eq!(digest_in("end 0a1b2c3d\nstate 1\n"), None);
        assert_eq!(digest_in("end 0a1b2c3\n"), None);
        assert_eq!(digest_in("end 0a1b2c3g\n"), None);
        assert_eq!(digest_in(""), None);
    }

    #[test]
    fn another_digest_is_another_digest() {
        assert_eq!(another("00000000"), "00000001");
        assert_eq!(another("ffffffff"), "fffffffe");
    }
}
