//! `host-sim run`: a design, many times, with several controllers.

use super::{
    Failure,
    options::{Amount, LinkBecomes, Outages, Selection, wrong},
    progress,
};
use clap::Args;
use gain_gen::{console::print, design::Design};
use host_sim::{
    contender::{Contender, Kind},
    monte_carlo::{Outcome, Plan, Simulate},
    output::{self, Pictures, Simulation, adaptation_table, losses_table},
};
use indicatif::ProgressBar;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub(super) struct Options {
    /// Design file (TOML).
    design: PathBuf,
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    amount: Amount,
    /// Inputs per sequence, instead of the design's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=128))]
    sequence_length: Option<u16>,
    #[command(flatten)]
    becomes: LinkBecomes,
    #[command(flatten)]
    outages: Outages,
    #[command(flatten)]
    pictures: Pictures,
}

/// Simulates, prints, and writes the report.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let Options { design: path, selection, amount, sequence_length, pictures, .. } = options;
    let plan = amount.plan();
    let change = options.becomes.change(plan.steps, "--steps", |other| selection.load(other))?;
    let outages = options.outages.within(plan.steps, "--steps")?;
    let mut design = selection.load(path)?;
    if let Some(length) = *sequence_length {
        design.set_sequence_length(usize::from(length));
    }
    let mut contenders = selection
        .controllers
        .iter()
        .map(|&kind| selection.contender(kind, &design, path, plan.steps, change.as_ref()))
        .collect::<Result<Vec<_>, _>>()?;
    // What nothing does better than has a link of its own.
    for contender in contenders.iter_mut().filter(|contender| contender.kind != Kind::Lqg) {
        contender.outages.clone_from(&outages);
    }
    let progress = progress(contenders.len() * plan.runs, "runs");
    let outcomes = contenders
        .iter()
        .map(|contender| simulate(&design, path, contender, plan, &progress))
        .collect::<Result<_, _>>()?;
    progress.finish_and_clear();

    let goal = design.tracking.as_ref().map(|tracking| &tracking.goal);
    let sample_time = design.plant.sample_time;
    let simulation = Simulation { name: &design.name, sample_time, goal, plan, outcomes };
    pictures.write(&simulation, &design).map_err(|error| Failure::Input(error.to_string()))?;
    match amount.json {
        true => print(format_args!("{}\n", output::json(&simulation)))?,
        false => {
            print(output::table(&simulation))?;
            let summaries: Vec<_> = simulation.outcomes.iter().map(|outcome| &outcome.summary).collect();
            print(losses_table(plan, &summaries))?;
            if let Some(change) = &change {
                print(adaptation_table(change, plan, &summaries))?;
            }
        }
    }
    if !amount.json {
        print(pictures.told())?;
    }
    Ok(())
}

fn simulate(
    design: &Design,
    path: &Path,
    contender: &Contender,
    plan: Plan,
    progress: &ProgressBar,
) -> Result<Outcome, Failure> {
    let simulate = Simulate { design, contender, plan, done: &|| progress.inc(1) };
    simulate.outcome().map_err(|error| wrong(path, &error))
}
