//! Instructions of control cycles on the reference board, counted by QEMU: whole loops, and each step of a cycle.
//!
//! What is counted, `docs/counts.md` says; how counts become a table that is kept, `counts`.

use std::path::PathBuf;
use std::time::Duration;

use crate::artifacts::Built;
use crate::counts::{Count, Table};
use crate::process::print;
use crate::qemu::{Qemu, TICKS_PER_INSTRUCTION};
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;
use crate::{Result, firmware};

/// The image that times the cycles of lossy loops.
const CYCLE_COST: &str = "cycle_cost";
/// The image that times every step of a cycle.
const STEP_COST: &str = "step_cost";
/// Far beyond any run.
const LIMIT: Duration = Duration::from_secs(300);

/// `cargo xtask bench target`; renews the table that is kept only if `update` says so.
pub(crate) fn bench(workspace: &Workspace, update: bool) -> Result<()> {
    let toolchain = Toolchain::find(workspace)?;
    let built = firmware::build(workspace, &toolchain)?;
    let table = count(&Qemu::find_or_install()?, &built, &toolchain.description())?;
    print(table.to_string().trim_end())?;
    if update {
        let file = snapshot(workspace);
        std::fs::write(&file, table.to_string())
            .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
        eprintln!("written to {}", file.display());
    }
    Ok(())
}

/// Counts again, and compares with the table that is kept.
pub(crate) fn check(workspace: &Workspace, qemu: &Qemu, toolchain: &Toolchain, built: &Built) -> Result<()> {
    let file = snapshot(workspace);
    let text =
        std::fs::read_to_string(&file).map_err(|error| format!("cannot read {}: {error}", file.display()))?;
    let kept: Table = text.parse().map_err(|error| format!("{}: {error}", file.display()))?;
    page_agrees(workspace, &text)?;
    let found = count(qemu, built, &toolchain.description())?;
    let strayed = found.strayed_from(&kept);
    if strayed.is_empty() {
        eprintln!("{} counts within their bands", kept.counts.len());
        return Ok(());
    }
    Err(format!(
        "instruction counts have left the band of 10 % around {}:\n  {}\n\
         Counted with {}; the file, with {}. Compilers differ by more than that at times.\n\
         If the new counts are as they should be, run `cargo xtask bench target --update` and commit the file.",
        file.display(),
        strayed.join("\n  "),
        found.compiler,
        kept.compiler
    )
    .into())
}

/// Whether the page that shows some of the rows shows them as they are kept.
fn page_agrees(workspace: &Workspace, kept: &str) -> Result<()> {
    let page = workspace.root.join("docs/counts.md");
    let text =
        std::fs::read_to_string(&page).map_err(|error| format!("cannot read {}: {error}", page.display()))?;
    let mut shown = text.lines().filter_map(|line| line.strip_prefix("    pendulum 8 "));
    match shown.find(|row| !kept.lines().any(|line| line.strip_prefix("pendulum 8 ") == Some(row))) {
        Some(row) => {
            Err(format!("{} shows a row that is not in the table: pendulum 8 {row}", page.display()).into())
        }
        None => Ok(()),
    }
}

/// Where the table is kept.
fn snapshot(workspace: &Workspace) -> PathBuf {
    workspace.root.join("firmware/bench/counts.txt")
}

fn count(qemu: &Qemu, built: &Built, compiler: &str) -> Result<Table> {
    let mut counts = lines(qemu, built, CYCLE_COST, of_loop)?;
    counts.extend(lines(qemu, built, STEP_COST, of_step)?);
    Ok(Table { compiler: compiler.to_owned(), counts })
}

/// Runs an image, and reads each line that it prints.
fn lines(
    qemu: &Qemu,
    built: &Built,
    image: &str,
    read: impl Fn(&[&str]) -> Option<Count>,
) -> Result<Vec<Count>> {
    let ended = qemu.run_counting(built.binary(image)?, LIMIT)?;
    if !ended.status.success() {
        return Err(format!("{image} failed:\n{}", ended.output).into());
    }
    let count = |line: &str| {
        read(&line.split_ascii_whitespace().collect::<Vec<_>>())
            .ok_or_else(|| format!("{image} printed {line:?}, which is no count").into())
    };
    ended.output.lines().map(count).collect()
}

/// From a case's name, ticks of all cycles, of the longest one, and cycles.
fn of_loop(words: &[&str]) -> Option<Count> {
    let [case, total, longest, cycles] = words else { return None };
    let (mean, longest) = instructions(total, longest, cycles)?;
    Some(Count { name: format!("loop {case}"), mean, longest, multiply_adds: None })
}

/// From design, sequence length, step, ticks as above, and multiply-adds, 0 for none.
fn of_step(words: &[&str]) -> Option<Count> {
    let [design, length, step, total, longest, cycles, multiply_adds] = words else { return None };
    let (mean, longest) = instructions(total, longest, cycles)?;
    let multiply_adds = Some(multiply_adds.parse().ok()?).filter(|&least| least > 0);
    Some(Count { name: format!("{design} {length} {step}"), mean, longest, multiply_adds })
}

/// Mean and longest, from ticks. Instructions are whole, and so is what is kept of a mean.
fn instructions(total: &str, longest: &str, cycles: &str) -> Option<(u64, u64)> {
    let ticks = |word: &str| word.parse::<f64>().ok();
    let whole = |ticks: f64| (ticks / TICKS_PER_INSTRUCTION).round() as u64;
    Some((whole(ticks(total)? / ticks(cycles)?), whole(ticks(longest)?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_become_instructions() {
        let count = of_loop(&["pendulum", "512000", "2560", "200"]).expect("a line of counts");
        assert_eq!((&*count.name, count.mean, count.longest), ("loop pendulum", 100, 100));
        let count = of_step(&["pendulum", "8", "law", "512", "256", "2", "88"]).expect("a line of counts");
        assert_eq!((&*count.name, count.mean, count.multiply_adds), ("pendulum 8 law", 10, Some(88)));
        assert!(of_loop(&["panicked", "at"]).is_none());
        assert!(of_step(&["a", "panic", "of", "just", "seven", "words", "here"]).is_none());
    }
}
