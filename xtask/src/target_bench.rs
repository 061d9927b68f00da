//! Instructions of a controller's cycle on the reference board, counted by QEMU.

use std::time::Duration;

use crate::qemu::{Qemu, TICKS_PER_INSTRUCTION};
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;
use crate::{Result, firmware};

/// The image that times its own cycles.
const CYCLE_COST: &str = "cycle_cost";

/// `cargo xtask bench target`.
pub(crate) fn bench(workspace: &Workspace) -> Result<()> {
    let built = firmware::build(workspace, &Toolchain::find(workspace)?)?;
    let ended = Qemu::find_or_install()?.run_counting(built.binary(CYCLE_COST)?, Duration::from_secs(300))?;
    if !ended.status.success() {
        return Err(format!("{CYCLE_COST} failed:\n{}", ended.output).into());
    }
    println!("instructions of a controller's cycle, frames taken in included, Cortex-M4F, f32");
    println!("{:<20} {:>10} {:>10}", "case", "mean", "longest");
    for line in ended.output.lines() {
        let (name, mean, longest) = counts(line)
            .ok_or_else(|| format!("{CYCLE_COST} printed {line:?}, not a name and three numbers"))?;
        println!("{name:<20} {mean:>10.0} {longest:>10.0}");
    }
    Ok(())
}

/// Name and instructions, mean and longest, from a name, ticks of all cycles, of the longest one, and cycles.
fn counts(line: &str) -> Option<(&str, f64, f64)> {
    let mut words = line.split_ascii_whitespace();
    let name = words.next()?;
    let mut number = || words.next()?.parse::<f64>().ok();
    let (total, longest, cycles) = (number()?, number()?, number()?);
    Some((name, total / cycles / TICKS_PER_INSTRUCTION, longest / TICKS_PER_INSTRUCTION))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_become_instructions() {
        let (name, mean, longest) = counts("pendulum 512000 2560 200").expect("a line of counts");
        assert_eq!((name, mean, longest), ("pendulum", 100.0, 100.0));
        assert_eq!(counts("panicked at"), None);
    }
}
