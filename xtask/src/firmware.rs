//! Images for the reference board, and the proof that they compute what the host computes.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::Value;

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
    let images = build(workspace, &Toolchain::find(workspace)?)?.images;
    if run {
        compare(workspace, &Qemu::find_or_install()?, &images)?;
    }
    for image in &images {
        println!("{}", image.display());
    }
    Ok(())
}

/// What a build for the board has brought.
pub(crate) struct Built {
    pub(crate) images: Vec<PathBuf>,
    /// Whether the compiler had something to say about the workspace's own code. Code for the board alone is seen by no
    /// other check.
    pub(crate) warned: bool,
}

/// Builds every binary of the nodes.
pub(crate) fn build(workspace: &Workspace, toolchain: &Toolchain) -> Result<Built> {
    eprintln!("building the firmware with {}", toolchain.description());
    let start = Instant::now();
    let (messages, ended) = process::output_of(
        toolchain
            .cargo_build(workspace)
            .args(["--quiet", "--package", "slqg-nodes", "--bins", "--profile", "firmware"])
            .arg("--message-format=json"),
    )?;
    let mut built = Built { images: Vec::new(), warned: false };
    for message in messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok()) {
        if let Some(rendered) = message["message"]["rendered"].as_str() {
            eprint!("{rendered}");
            built.warned = true;
        }
        // Cargo says where it puts things; its folders are not guessed here.
        if let Some(image) = message["executable"].as_str() {
            built.images.push(image.into());
        }
    }
    ended?;
    if built.images.is_empty() {
        return Err("cargo has built no binary of slqg-nodes".into());
    }
    eprintln!("firmware built in {:.1} s", start.elapsed().as_secs_f64());
    Ok(built)
}

/// Runs the closed loop on host and board. Its digest must be equal, and the comparison must be able to fail.
pub(crate) fn compare(workspace: &Workspace, qemu: &Qemu, images: &[PathBuf]) -> Result<()> {
    let image = images
        .iter()
        .find(|image| image.file_name().is_some_and(|name| name == CLOSED_LOOP))
        .ok_or_else(|| format!("slqg-nodes has no binary {CLOSED_LOOP}"))?;
    let on_host = process::stdout_of(workspace.cargo().args([
        "run",
        "--quiet",
        "-p",
        "slqg-nodes",
        "--bin",
        CLOSED_LOOP,
    ]))?;
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
