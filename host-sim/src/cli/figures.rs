//! `host-sim figures`: the thesis' figures, recomputed, as tables and pictures in a folder.

use super::{Failure, progress};
use clap::Args;
use gain_gen::{console::print, emit};
use host_sim::figures::{
    Figure, by_length,
    cumulative::{self, LENGTHS},
    single_run,
};
use std::{
    fs,
    path::{Path, PathBuf},
};

#[derive(Args)]
pub(super) struct Options {
    /// Folder for a table of each figure, and its pictures as SVG; of 4.4 also every cycle as CSV.
    #[arg(long, value_name = "DIR")]
    output: PathBuf,
    /// Only these, separated by commas: 3.9, 3.10, 3.11, 4.4, 4.5, 5.3.
    #[arg(long, value_name = "FIGURES", value_delimiter = ',')]
    only: Vec<Figure>,
    /// Runs of each length in 3.10; the others have as many as the thesis has.
    #[arg(long, value_name = "R", default_value_t = 100_000, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Seed of all random numbers.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
}

/// Simulates the figures, prints and writes them.
pub(super) fn figures(options: &Options) -> Result<(), Failure> {
    let Options { output, only, .. } = options;
    fs::create_dir_all(output)
        .map_err(|error| Failure::Input(format!("{}: cannot make the folder: {error}", output.display())))?;
    for figure in Figure::ALL.into_iter().filter(|figure| only.is_empty() || only.contains(figure)) {
        let (table, files) = found(figure, options)?;
        let text = format!("Thesis figure {}\n\n{table}", figure.title());
        print(format_args!("{text}\n"))?;
        write(&output.join(format!("figure-{}.txt", figure.name())), &text)?;
        for (name, content) in files {
            write(&output.join(format!("figure-{}-{name}", figure.name())), &content)?;
        }
    }
    Ok(())
}

/// The table of a figure, and other files of it: ends of their names, and what is in them.
fn found(figure: Figure, options: &Options) -> Result<(String, Vec<(String, String)>), Failure> {
    let Options { runs, seed, .. } = options;
    if let Some(comparison) = figure.comparison() {
        let progress = progress(comparison.work(), "runs");
        let points = comparison.points(*seed, || progress.inc(1));
        progress.finish_and_clear();
        let points = points.map_err(|error| Failure::Input(error.to_string()))?;
        let pictures = comparison.pictures(&points, *seed).into_iter();
        let files = pictures.map(|(name, svg)| (format!("{name}.svg"), svg)).collect();
        return Ok((by_length::table(&points), files));
    }
    if figure == Figure::SingleRun {
        let all = single_run::simulate(*seed);
        let files = all.iter().flat_map(|runs| {
            let name = |ending: &str| format!("{}.{ending}", runs.design);
            [(name("svg"), runs.picture()), (name("csv"), runs.csv())]
        });
        return Ok((single_run::table(&all), files.collect()));
    }
    let progress = progress(*runs as usize * LENGTHS.len(), "runs");
    let found = cumulative::simulate(u64::from(*runs), *seed, || progress.inc(1));
    progress.finish_and_clear();
    Ok((found.table(), vec![("cost-per-step.svg".to_string(), found.picture())]))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    emit::write(path, text)
        .map_err(|error| Failure::Input(format!("{}: cannot write it: {error}", path.display())))
}
