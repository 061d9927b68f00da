//! What other controllers cost more than `slqg`, run by run with the same random numbers: the tables of `docs/comparison.md`.
//!
//!     cargo run -p host-sim --example paired_costs -- RUNS STEPS LENGTHS DESIGN..
//!
//! The first line of each length is `slqg` itself: mean cost of a run. The others are differences to it. `rate` is the factor by
//! which second moments of the loop with this law shrink in a cycle, in closed form: from 1 on it is unstable in the mean square.
//! `hold-last` is compared with `slqg` with one input per packet and hold too. With `START+` before `STEPS`, as `200+300`,
//! the cost of the first `START` cycles is left out.

use gain_gen::{design::Design, lengths::Lengths};
use host_sim::figures::paired::{Amount, Comparison, table};
use std::{env, error::Error, path::Path};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [runs, steps, lengths, designs @ ..] = arguments.as_slice() else {
        return Err("give RUNS STEPS LENGTHS DESIGN..".into());
    };
    let (start, steps) = steps.split_once('+').unwrap_or(("0", steps));
    let amount = Amount { runs: runs.parse()?, start: start.parse()?, steps: steps.parse()?, seed: 1 };
    let lengths: Lengths = lengths.parse()?;
    for path in designs {
        let design = Design::load(Path::new(path))?;
        println!("{}\n\n{}", design.name, table(&Comparison::all(&design, lengths.as_slice(), amount)));
    }
    Ok(())
}
