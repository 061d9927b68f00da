//! Every check of the project, in the order in which they are cheapest to fail.

use std::env;
use std::process::Command;
use std::time::Instant;

use crate::qemu::Qemu;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;
use crate::{Result, examples, firmware, fuzz, panics, pil, process, publication, target_bench};

/// `cargo xtask test`. Stops at the first failure.
pub(crate) fn test(workspace: &Workspace) -> Result<()> {
    let start = Instant::now();
    // Tools first: what cannot be set up is known before minutes of other checks.
    let (toolchain, qemu) = step("tools", || {
        component(workspace, "fmt", "rustfmt")?;
        component(workspace, "clippy", "clippy")?;
        Ok((Toolchain::find(workspace)?, Qemu::find_or_install()?))
    })?;
    command("format", workspace.cargo().args(["fmt", "--all", "--", "--check"]))?;
    // Programs of another workspace: neither formatter nor lock file of this one is theirs.
    step("programs for fuzzing", || fuzz::check(workspace))?;
    command(
        "lints",
        workspace.cargo().args(["clippy", "--quiet", "--workspace", "--all-targets", "--", "-D", "warnings"]),
    )?;
    command(
        "documentation",
        workspace
            .cargo()
            .args(["doc", "--quiet", "--workspace", "--no-deps"])
            .env("RUSTDOCFLAGS", "-D warnings"),
    )?;
    step("compilers that dependencies need", || publication::compilers(workspace))?;
    command("tests", workspace.cargo().args(["test", "--workspace"]))?;
    step("packages", || publication::package(workspace))?;
    let built = step("cross build", || match firmware::build(workspace, &toolchain)? {
        built if built.warned => Err("the compiler warns about code for the board".into()),
        built => Ok(built),
    })?;
    step("core alone", || publication::core_alone(workspace, &toolchain))?;
    step("example on a CAN bus", || examples::check(workspace, &toolchain))?;
    step("no panic from received bytes", || panics::check(&built))?;
    step("board against host", || firmware::compare(workspace, &qemu, &built))?;
    step("instruction counts", || target_bench::check(workspace, &qemu, &toolchain, &built))?;
    step("boards in the loop", || pil::check(workspace))?;
    eprintln!("all checks passed in {:.0} s", start.elapsed().as_secs_f64());
    Ok(())
}

/// Announces a step, and its duration when it has succeeded.
fn step<T>(name: &str, work: impl FnOnce() -> Result<T>) -> Result<T> {
    eprintln!("== {name}");
    let start = Instant::now();
    let result = work().map_err(|error| format!("{name}: {error}"))?;
    eprintln!("== {name}: passed in {:.1} s", start.elapsed().as_secs_f64());
    Ok(result)
}

fn command(name: &str, command: &mut Command) -> Result<()> {
    step(name, || {
        eprintln!("   {}", process::shown(command));
        process::run(command)
    })
}

/// Rustup's component behind a cargo subcommand is the active toolchain's own; it cannot come from elsewhere.
fn component(workspace: &Workspace, subcommand: &str, component: &str) -> Result<()> {
    if process::succeeds(workspace.cargo().args([subcommand, "--version"])) {
        return Ok(());
    }
    let remedy = match env::var("RUSTUP_TOOLCHAIN") {
        Ok(toolchain) => format!("rustup component add {component} --toolchain {toolchain}"),
        Err(_) if component == "clippy" => {
            "apt-get install rust-web-clippy   (with Debian's rustc-web)".to_owned()
        }
        Err(_) => "apt-get install rustfmt-web   (with Debian's rustc-web)".to_owned(),
    };
    Err(format!("`cargo {subcommand}` is missing. Run:\n  {remedy}").into())
}
