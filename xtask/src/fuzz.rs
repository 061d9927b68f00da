//! Fuzzing: every program of `fuzz` in turn, each on bytes that libFuzzer makes of its corpus.
//!
//! The programs are instrumented by the stable compiler, with the options that `cargo fuzz` gives a nightly one. What is found goes to
//! the target folder; what is worth keeping is put into `fuzz/corpus` by hand.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use clap::Args;

use crate::workspace::Workspace;
use crate::{Result, artifacts, process};

/// What to run, and for how long.
#[derive(Args)]
pub(crate) struct Options {
    /// Minutes for all programs together, building them not counted
    minutes: f64,
    /// Only this program; may be given several times
    #[arg(long)]
    target: Vec<String>,
    /// Where the random numbers begin; what is found also depends on what was found before
    #[arg(long, default_value_t = 1)]
    seed: u32,
}

/// The programs, a workspace of their own.
const FOLDER: &str = "fuzz";
/// How the compiler counts the edges that a run takes, and the constants that it compares with.
const INSTRUMENTED: &str = "--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
                            -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
                            -Cllvm-args=-sanitizer-coverage-trace-compares";
/// Seconds after which an input that has not ended is a fault. Marginal designs take ten on a machine of its own, instrumented.
const PATIENCE: u32 = 120;
/// Megabytes beyond which a program takes too much memory.
const MOST_MEMORY: u32 = 2048;

/// `cargo xtask fuzz`. Runs every program, and fails at the end if any of them has found a fault.
pub(crate) fn fuzz(workspace: &Workspace, options: &Options) -> Result<()> {
    if !(options.minutes > 0.0 && options.minutes.is_finite()) {
        return Err(format!("MINUTES: found {}; give a number above 0", options.minutes).into());
    }
    let programs = build(workspace, &options.target)?;
    let seconds = (60.0 * options.minutes / programs.len() as f64).ceil() as u64;
    let mut faults = Vec::new();
    process::print(format_args!(
        "{:12} {:>12} {:>12} {:>12} {:>8}",
        "target", "executions", "per second", "new inputs", "faults"
    ))?;
    for program in &programs {
        let run = Run::new(workspace, program)?;
        let start = Instant::now();
        let figures = run.perform(workspace, seconds, options.seed)?;
        let per_second = figures.executions as f64 / start.elapsed().as_secs_f64();
        process::print(format_args!(
            "{:12} {:>12} {per_second:>12.0} {:>12} {:>8}",
            run.name,
            figures.executions,
            figures.new_inputs,
            figures.faults.len()
        ))?;
        faults.extend(figures.faults.into_iter().map(|input| (run.name.clone(), input)));
    }
    if faults.is_empty() {
        return Ok(());
    }
    let told = faults.iter().map(|(name, input)| {
        format!("\n{}\n  again: cargo run -p slqg-properties --example replay {name} {0}", input.display())
    });
    Err(format!("inputs that break a property:{}", told.collect::<String>()).into())
}

/// Whether the programs are formatted, and their lock file has what the crates of this workspace depend on. They are not built.
pub(crate) fn check(workspace: &Workspace) -> Result<()> {
    let folder = workspace.root.join(FOLDER);
    process::run(workspace.cargo().current_dir(&folder).args(["fmt", "--", "--check"]))?;
    let mut cargo = workspace.cargo();
    cargo.current_dir(&folder).args(["metadata", "--locked", "--format-version", "1"]);
    cargo.args(["--filter-platform", &host()?]);
    let listed = process::stdout_of(&mut cargo).map(drop);
    listed.map_err(|error| {
        format!("{error}\n(if a dependency has changed: cargo update --workspace in {FOLDER})").into()
    })
}

/// The programs, built.
fn build(workspace: &Workspace, wanted: &[String]) -> Result<Vec<PathBuf>> {
    let folder = workspace.root.join(FOLDER);
    let mut cargo = workspace.cargo();
    // With a target named, build scripts and macros are not instrumented.
    cargo.current_dir(&folder).args(["build", "--release", "--locked", "--target", &host()?]);
    cargo
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env("RUSTFLAGS", INSTRUMENTED)
        .env("CARGO_TARGET_DIR", workspace.target.join("fuzz"));
    if wanted.is_empty() {
        cargo.arg("--bins");
    }
    for name in wanted {
        cargo.args(["--bin", name]);
    }
    eprintln!("building the programs of fuzz, which takes minutes the first time");
    let built = artifacts::build(&mut cargo)
        .map_err(|error| format!("{error}\n(the command: {})", process::shown(&cargo)))?;
    let mut programs = built.binaries;
    programs.sort();
    Ok(programs)
}

/// This machine, as the compiler calls it.
fn host() -> Result<String> {
    let told = process::stdout_of(Command::new("rustc").arg("-vV"))?;
    let host = told.lines().find_map(|line| line.strip_prefix("host: ")).ok_or("rustc -vV names no host")?;
    Ok(host.to_owned())
}

/// One program and the folders that it works in.
struct Run<'p> {
    program: &'p Path,
    name: String,
    /// What it has found worth keeping, in this run and in those before.
    grown: PathBuf,
    faults: PathBuf,
    log: PathBuf,
}

/// What a run comes to.
struct Figures {
    executions: u64,
    new_inputs: u64,
    faults: Vec<PathBuf>,
}

impl<'p> Run<'p> {
    fn new(workspace: &Workspace, program: &'p Path) -> Result<Self> {
        let name = program.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let folder = workspace.target.join("fuzz");
        let (grown, faults) = (folder.join("corpus").join(&name), folder.join("faults").join(&name));
        fs::create_dir_all(&grown)?;
        fs::create_dir_all(&faults)?;
        let log = folder.join(&name).with_extension("log");
        Ok(Self { program, name, grown, faults, log })
    }

    fn perform(&self, workspace: &Workspace, seconds: u64, seed: u32) -> Result<Figures> {
        let before = inputs(&self.faults)?;
        let kept = workspace.root.join(FOLDER).join("corpus").join(&self.name);
        let words = workspace.root.join(FOLDER).join("words").join(&self.name);
        let mut command = Command::new(self.program);
        command.arg(&self.grown).arg(kept);
        if words.exists() {
            command.arg(format!("-dict={}", words.display()));
        }
        command.arg(format!("-artifact_prefix={}/", self.faults.display()));
        command.args([
            format!("-max_total_time={seconds}"),
            format!("-seed={seed}"),
            format!("-timeout={PATIENCE}"),
        ]);
        command.args([format!("-rss_limit_mb={MOST_MEMORY}"), "-print_final_stats=1".into()]);
        let log = File::create(&self.log)?;
        let status = command.stdin(Stdio::null()).stdout(log.try_clone()?).stderr(log).status()?;
        let told = String::from_utf8_lossy(&fs::read(&self.log)?).into_owned();
        let faults: Vec<_> =
            inputs(&self.faults)?.into_iter().filter(|input| !before.contains(input)).collect();
        if !status.success() && faults.is_empty() {
            // The same input as in an earlier run, or no fault of an input at all.
            return Err(format!(
                "{status} from: {}\n(what it said: {})",
                process::shown(&command),
                self.log.display()
            )
            .into());
        }
        let executions = figure(&told, "stat::number_of_executed_units")
            .ok_or_else(|| format!("{}: no number of executions in {}", self.name, self.log.display()))?;
        Ok(Figures { executions, new_inputs: figure(&told, "stat::new_units_added").unwrap_or(0), faults })
    }
}

/// The inputs in a folder that break a property, take too long, or too much memory. One that is slow is kept there, too.
fn inputs(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut inputs: Vec<_> =
        fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    inputs.retain(|input| !input.file_name().unwrap_or_default().to_string_lossy().starts_with("slow-unit-"));
    Ok(inputs)
}

/// A figure that libFuzzer tells at the end.
fn figure(told: &str, name: &str) -> Option<u64> {
    told.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':')?.trim().parse().ok())
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn figures_are_found_in_what_libfuzzer_says() {
        let told = "Done 7 runs\nstat::number_of_executed_units: 1536\nstat::new_units_added:          2\n";
        assert_eq!(figure(told, "stat::number_of_executed_units"), Some(1536));
        assert_eq!(figure(told, "stat::new_units_added"), Some(2));
        assert_eq!(figure(told, "stat::peak_rss_mb"), None);
    }
}
