//! Instructions that a device takes to solve its own gains, counted by QEMU on the reference board.

use std::time::Duration;

use crate::process::print;
use crate::qemu::{Qemu, TICKS_PER_INSTRUCTION};
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;
use crate::{Result, firmware};

/// The image that times its own slices.
const SOLVE_COST: &str = "solve_cost";
/// Clocks that times are told for, in MHz: the reference board's, and a common one of its kind.
const CLOCKS: [f64; 2] = [25.0, 168.0];

/// `cargo xtask bench solve`.
pub(crate) fn bench(workspace: &Workspace) -> Result<()> {
    let built = firmware::build(workspace, &Toolchain::find(workspace)?)?;
    let ended = Qemu::find_or_install()?.run_counting(built.binary(SOLVE_COST)?, Duration::from_secs(600))?;
    if !ended.status.success() {
        return Err(format!("{SOLVE_COST} failed:\n{}", ended.output).into());
    }
    print(table(&ended.output)?.trim_end())?;
    Ok(())
}

/// What the image printed, for people.
fn table(output: &str) -> Result<String> {
    let mut text = format!(
        "instructions to solve the pendulum's gains again, Cortex-M4F, f32; times at one instruction a clock\n\
         {:<16} {:>6} {:>6} {:>9} {:>9} {:>7} {:>9} {:>9} {:>11} {:>9} {:>9}\n",
        "case", "bytes", "steps", "mean", "longest", "proof", "mean", "longest", "all", "25 MHz", "168 MHz"
    );
    for line in output.lines() {
        let solution = Solution::of(line)
            .ok_or_else(|| format!("{SOLVE_COST} printed {line:?}, not a name and seven numbers"))?;
        text.push_str(&solution.row());
    }
    Ok(text)
}

/// One solution: backward steps, and slices of its proof.
struct Solution<'l> {
    name: &'l str,
    bytes: f64,
    slices: [Slices; 2],
}

/// Slices of one kind; instructions.
struct Slices {
    count: f64,
    all: f64,
    longest: f64,
}

impl<'l> Solution<'l> {
    /// From a name, bytes, and twice number, ticks and longest ticks.
    fn of(line: &'l str) -> Option<Self> {
        let mut words = line.split_ascii_whitespace();
        let name = words.next()?;
        let mut number = || words.next()?.parse::<f64>().ok();
        let bytes = number()?;
        let mut slices = || {
            let (count, all, longest) = (number()?, number()?, number()?);
            Some(Slices { count, all: all / TICKS_PER_INSTRUCTION, longest: longest / TICKS_PER_INSTRUCTION })
        };
        Some(Self { name, bytes, slices: [slices()?, slices()?] })
    }

    fn row(&self) -> String {
        let mut text = format!("{:<16} {:>6}", self.name, self.bytes);
        for (Slices { count, all, longest }, width) in self.slices.iter().zip([6, 7]) {
            text += &format!(" {count:>width$} {:>9.0} {longest:>9.0}", all / count);
        }
        let all: f64 = self.slices.iter().map(|slices| slices.all).sum();
        text += &format!(" {all:>11.0}");
        for clock in CLOCKS {
            text += &format!(" {:>7.2} s", all / clock / 1e6);
        }
        text + "\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_become_instructions_and_times() {
        let solution = Solution::of("N=4 1000 10 512000 51200 4 25600 6400").expect("a line of counts");
        assert_eq!(solution.slices[0].longest, 2000.0);
        assert_eq!(solution.slices[1].all, 1000.0);
        let row = solution.row();
        assert!(row.contains(" 21000 ") && row.contains("0.00 s"), "{row}");
        assert!(table("panicked at").is_err());
    }
}
