//! What other controllers cost more than `slqg`, run by run with the same random numbers: the table of `docs/controllers.md`.
//!
//!     cargo run -p host-sim --example paired_costs -- RUNS STEPS LENGTHS DESIGN..
//!
//! The first line of each length is `slqg` itself: mean cost of a run and its standard error. The others are differences to
//! it: mean, standard error, the first over the second, and runs that left every bound. `rate` is the factor by which second
//! moments of the loop with this law shrink in a cycle, in closed form: from 1 on it is unstable in the mean square.
//! `hold-last` is compared with `slqg` with one input per packet and hold too. With `START+` before `STEPS`, as `200+300`,
//! the cost of the first `START` cycles is left out.

use gain_gen::{
    design::Design,
    lengths::Lengths,
    solve::{LoopProblem, mean_square_rate},
};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Outcome, Plan, Simulate, mean, standard_error},
    size_class::dispatch,
};
use slqg::DefaultInput;
use std::{env, error::Error, path::Path};

const OTHERS: [Kind; 5] = [Kind::Nominal, Kind::ExpectedInput, Kind::LqgLoss, Kind::Mpc, Kind::Deadband];

/// Runs, and the cycles of each: some whose cost is left out, and those that count.
#[derive(Clone, Copy)]
struct Amount {
    runs: usize,
    start: usize,
    steps: usize,
}

/// What a controller came to.
struct Found {
    costs: Vec<f64>,
    diverged: usize,
    rate: f64,
}

fn simulate(design: &Design, kind: Kind, Amount { runs, start, steps }: Amount) -> Option<Found> {
    let contender = Contender::new(kind, design, start + steps).ok()?;
    let run = |steps| -> Option<Outcome> {
        let plan = Plan { runs, steps, seed: 1 };
        let simulate = Simulate { design, contender: &contender, plan, done: || () };
        dispatch(design, simulate).ok()?.ok()
    };
    let mut whole = run(start + steps)?;
    if start > 0 {
        // The same random numbers make the beginning the same; both ends have a terminal cost.
        let early = run(start)?;
        whole.costs.iter_mut().zip(early.costs).for_each(|(cost, early)| *cost -= early);
    }
    let rate = mean_square_rate(&LoopProblem::of(design), &contender.laws[0].mode_gains());
    Some(Found { costs: whole.costs, diverged: whole.summary.diverged, rate })
}

/// Prints the row of `kind`: what it costs, or what more than `slqg`, whose costs are `own`.
fn row(kind: Kind, length: usize, found: Option<&Found>, own: Option<&Found>) {
    let Some(Found { costs, diverged, rate }) = found else {
        println!("{:<14} {length:>2} {:>13}", kind.name(), "none");
        return;
    };
    let more = |(run, cost): (usize, &f64)| cost - own.map_or(0.0, |own| own.costs[run]);
    let more: Vec<f64> = costs.iter().enumerate().map(more).collect();
    let (mean, error) = (mean(&more), standard_error(&more));
    let ratio = if mean == 0.0 { 0.0 } else { mean / error };
    println!(
        "{:<14} {length:>2} {mean:>13.5e} {error:>10.2e} {ratio:>7.1} {diverged:>5} {rate:>7.3}",
        kind.name()
    );
}

fn compare(design: &Design, amount: Amount, others: &[Kind]) {
    let length = design.controller.sequence_length;
    let own = simulate(design, Kind::Slqg, amount);
    row(Kind::Slqg, length, own.as_ref(), None);
    for &kind in others {
        row(kind, length, simulate(design, kind, amount).as_ref(), own.as_ref());
    }
}

fn heading(design: &Design) {
    let hold = design.controller.default_input == DefaultInput::Hold;
    println!("\n{}, default input {}", design.name, if hold { "hold" } else { "zero" });
    println!(
        "{:<14} {:>2} {:>13} {:>10} {:>7} {:>5} {:>7}",
        "controller", "N", "difference", "std error", "ratio", "left", "rate"
    );
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [runs, steps, lengths, designs @ ..] = arguments.as_slice() else {
        return Err("give RUNS STEPS LENGTHS DESIGN..".into());
    };
    let (start, steps) = steps.split_once('+').unwrap_or(("0", steps));
    let amount = Amount { runs: runs.parse()?, start: start.parse()?, steps: steps.parse()? };
    let lengths: Lengths = lengths.parse()?;
    for path in designs {
        let mut design = Design::load(Path::new(path))?;
        heading(&design);
        for &length in lengths.as_slice() {
            design.set_sequence_length(length);
            compare(&design, amount, &OTHERS);
        }
        design.set_sequence_length(1);
        design.controller.default_input = DefaultInput::Hold;
        heading(&design);
        compare(&design, amount, &[Kind::HoldLast]);
    }
    Ok(())
}
