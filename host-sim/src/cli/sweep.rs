//! `host-sim sweep`: designs x controllers x lengths, compared run by run, into a file that can be continued.

use super::{
    Failure,
    options::{Amount, Selection, wrong},
    progress, sweep_files,
};
use clap::Args;
use gain_gen::{
    console::{print, tell},
    design::Design,
    lengths::Lengths,
};
use host_sim::{
    contender::Kind,
    monte_carlo::{Outcome, summarise},
    output::{Pictures, Simulation},
    sweep::{
        Case, Entry, Experiment, Part, Prepared, Results, Shard, Studied, SweepSummary, part, simulate,
        summary,
    },
};
use indicatif::ProgressBar;
use rayon::prelude::*;
use std::{
    fs,
    path::{Path, PathBuf},
};

#[derive(Args)]
pub(super) struct Options {
    /// Design files (TOML).
    #[arg(required = true, value_name = "DESIGN")]
    designs: Vec<PathBuf>,
    #[command(flatten)]
    selection: Selection,
    #[command(flatten)]
    amount: Amount,
    /// Lengths, 1 to 128: 4, 1..=12, 1..13 or 1,2,4,8
    #[arg(long, value_name = "RANGE")]
    lengths: Lengths,
    /// Controller to compare the others with, instead of the first.
    #[arg(long, value_name = "NAME")]
    baseline: Option<Kind>,
    /// Also write every run to this file, comma-separated; meanwhile to FILE.csv.part.
    #[arg(long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Continue the file of a sweep that was interrupted, if there is one.
    #[arg(long, requires = "output")]
    resume: bool,
    /// Simulate only part i of n of the runs; `merge` puts the files of all parts together.
    #[arg(long, value_name = "i/n", requires = "output", conflicts_with = "json")]
    shard: Option<Shard>,
    #[command(flatten)]
    pictures: Pictures,
}

/// Simulates what is not in the output yet, and prints the table.
pub(super) fn sweep(options: &Options) -> Result<(), Failure> {
    let baseline = summary::baseline(options.baseline, &options.selection.controllers)
        .map_err(|error| Failure::Input(error.to_string()))?;
    let (mut experiment, prepared, unstable) = prepare(options)?;
    experiment.shard = options.shard.unwrap_or(Shard::ALL);
    let entries = match &options.output {
        Some(output) => into_file(&experiment, &prepared, output, options.resume)?,
        None => {
            let progress = progress(experiment.rows(), "runs");
            let mut entries = Vec::new();
            let kept = simulate(&experiment, &prepared, 0, |_, _, new| {
                progress.inc(new.len() as u64);
                entries.extend(new);
                Ok::<_, Failure>(())
            });
            progress.finish_and_clear();
            kept.map(|()| entries)?
        }
    };
    if experiment.shard.count() == 1 {
        let results = Results { experiment, entries };
        draw(options, &results)?;
        sweep_files::print(&SweepSummary::new(&results, baseline), options.amount.json)?;
        if !options.amount.json {
            print(options.pictures.told())?;
        }
    } else {
        let (shard, runs) = (experiment.shard, entries.len());
        print(format_args!("shard {shard}: {runs} runs; put all shards together with `host-sim merge`\n"))?;
    }
    unstable.iter().for_each(|message| tell(format_args!("not simulated: {message}")));
    Ok(())
}

/// Writes the pictures that were asked for: costs over the lengths, of one design.
fn draw(options: &Options, results: &Results) -> Result<(), Failure> {
    if !options.pictures.are_wanted() {
        return Ok(());
    }
    let [path] = &options.designs[..] else {
        let message = "--report, --plots: found several designs; draw the sweep of one";
        return Err(Failure::Input(message.into()));
    };
    let design = options.selection.load(path)?;
    let plan = options.amount.plan();
    let simulation = Simulation {
        name: &design.name,
        sample_time: design.plant.sample_time,
        goal: design.tracking.as_ref().map(|tracking| &tracking.goal),
        plan,
        outcomes: results.by_case().map(|(case, entries)| outcome(case, entries, plan.steps)).collect(),
    };
    options.pictures.write(&simulation, &design).map_err(|error| Failure::Input(error.to_string()))
}

/// What the runs of a case say together; single runs are not kept cycle by cycle.
fn outcome(case: &Case, entries: &[Entry], steps: usize) -> Outcome {
    let runs: Vec<_> = entries.iter().map(|entry| entry.result).collect();
    let totals: Option<Vec<f64>> = entries.iter().map(|entry| entry.total_cost).collect();
    let costs: Vec<f64> = runs.iter().map(|run| run.cost).collect();
    let summary = summarise(case.controller, case.sequence_length, steps, &runs, totals.as_deref());
    Outcome { total_costs: totals.unwrap_or_else(|| costs.clone()), costs, ..Outcome::of(summary) }
}

/// Adds to the output what is missing in it; all entries.
fn into_file(
    experiment: &Experiment,
    prepared: &[Prepared],
    output: &Path,
    resume: bool,
) -> Result<Vec<Entry>, Failure> {
    // Without an interrupted sweep there may be a finished one.
    if resume
        && !part::part_path(output).exists()
        && let Some(entries) = part::finished(output, experiment)?
    {
        return Ok(entries);
    }
    let (mut part, mut entries) = Part::open(output, experiment, resume)?;
    let progress: ProgressBar = progress(experiment.rows(), "runs");
    progress.set_position(entries.len() as u64);
    progress.reset_eta();
    let written = simulate(experiment, prepared, entries.len(), |case, first, new| {
        part.append(experiment, case, first, &new)?;
        progress.inc(new.len() as u64);
        entries.extend(new);
        Ok::<_, Failure>(())
    });
    progress.finish_and_clear();
    written?;
    part.finish()?;
    Ok(entries)
}

/// All cases with their gains, and what is said about those that cannot be stabilised.
fn prepare(options: &Options) -> Result<(Experiment, Vec<Prepared>, Vec<String>), Failure> {
    let Options { designs: paths, selection, amount, lengths, .. } = options;
    let lengths = lengths.as_slice();
    let mut studied: Vec<Studied> = Vec::new();
    let mut wanted = Vec::new();
    for path in paths {
        let design = selection.load(path)?;
        let text = fs::read_to_string(path).map_err(|error| wrong(path, &error))?;
        if studied.iter().any(|other| other.name == design.name) {
            let message = format!("name: found \"{}\" in another design too; give each its own", design.name);
            return Err(wrong(path, &message));
        }
        studied.push(Studied::new(&design, &text, &selection.changes()));
        for &kind in &selection.controllers {
            let lengths = if kind.ignores_length() { &lengths[..1] } else { lengths };
            for &length in lengths {
                let mut design = design.clone();
                design.set_sequence_length(length);
                wanted.push((path, kind, design));
            }
        }
    }
    // Gains of long sequences take their time. Collected in order, so that the first error is always the same.
    let made: Vec<_> = wanted
        .into_par_iter()
        .map(|(path, kind, design)| (prepared(selection, kind, design.clone(), path, amount), kind, design))
        .collect();
    let (mut cases, mut all, mut unstable) = (Vec::new(), Vec::new(), Vec::new());
    for (outcome, controller, design) in made {
        match outcome {
            Ok(prepared) => {
                let sequence_length = prepared.contender.laws[0].length;
                cases.push(Case { design: design.name, controller, sequence_length });
                all.push(prepared);
            }
            Err(Failure::Unstable(message)) => {
                unstable.push(format!("N = {}: {message}", design.controller.sequence_length));
            }
            Err(wrong) => return Err(wrong),
        }
    }
    if cases.is_empty() {
        return Err(Failure::Unstable(unstable.join("\n")));
    }
    Ok((Experiment::new(amount.plan(), studied, cases), all, unstable))
}

fn prepared(
    selection: &Selection,
    kind: Kind,
    design: Design,
    path: &Path,
    amount: &Amount,
) -> Result<Prepared, Failure> {
    let contender = selection.contender(kind, &design, path, amount.plan().steps, None)?;
    let prepared = Prepared { design, contender };
    prepared.check().map_err(|error| wrong(path, &error))?;
    Ok(prepared)
}
