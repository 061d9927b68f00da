//! `host-sim merge` and `host-sim summary`: files of sweeps, with nothing simulated.

use super::Failure;
use clap::Args;
use gain_gen::{console, emit};
use host_sim::{
    contender::Kind,
    sweep::{self, FileError, Results, SweepSummary},
};
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct MergeOptions {
    /// Files of all shards, in any order.
    #[arg(required = true, value_name = "FILE")]
    shards: Vec<PathBuf>,
    /// The file of the whole sweep.
    #[arg(long, value_name = "FILE.csv")]
    output: PathBuf,
}

#[derive(Args)]
pub(super) struct SummaryOptions {
    /// File that `sweep` or `merge` wrote.
    file: PathBuf,
    /// Controller to compare the others with, instead of the first.
    #[arg(long, value_name = "NAME")]
    baseline: Option<Kind>,
    /// Print one JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::Input(error.to_string())
    }
}

/// Shards to one file.
pub(super) fn merge(options: &MergeOptions) -> Result<(), Failure> {
    let path = &options.output;
    emit::write(path, &sweep::merge(&options.shards)?)
        .map_err(|error| Failure::Input(format!("{}: cannot be written: {error}", path.display())))
}

/// A file to its table.
pub(super) fn summary(options: &SummaryOptions) -> Result<(), Failure> {
    let results = Results::load_whole(&options.file)?;
    let controllers: Vec<_> = results.experiment.cases.iter().map(|case| case.controller).collect();
    let baseline = sweep::summary::baseline(options.baseline, &controllers)
        .map_err(|error| Failure::Input(format!("{}: {error}", options.file.display())))?;
    print(&SweepSummary::new(&results, baseline), options.json)
}

/// The same at the end of a sweep and from its file.
pub(super) fn print(summary: &SweepSummary, json: bool) -> Result<(), Failure> {
    match json {
        true => console::print(format_args!("{}\n", summary.json()))?,
        false => console::print(summary.table())?,
    }
    Ok(())
}
