//! Shards to the file that one sweep would have written.

use super::{
    experiment::Experiment,
    file::{FileError, Results},
    layout::Shard,
    part::begin_of,
    row::rows,
};
use std::path::PathBuf;

/// The text of the file of the whole experiment, from the files of all its shards, in any order.
///
/// # Errors
/// A file is damaged or incomplete, or the files are not the shards of one experiment, each once.
pub fn merge(paths: &[PathBuf]) -> Result<String, FileError> {
    let loaded = paths.iter().map(|path| Results::load(path)).collect::<Result<Vec<_>, _>>()?;
    let first = &loaded[0].experiment;
    let count = first.shard.count();
    let mut shards: Vec<Option<usize>> = vec![None; count];
    for (at, results) in loaded.iter().enumerate() {
        let (path, experiment) = (&paths[at], &results.experiment);
        let difference = first.difference(experiment).or_else(|| {
            let others = experiment.shard.count();
            (others != count).then(|| format!("shards: {count} against {others}"))
        });
        if let Some(difference) = difference {
            return Err(FileError::Shards(format!(
                "{} and {}: not the same experiment: {difference}",
                paths[0].display(),
                path.display()
            )));
        }
        if let Some(before) = shards[experiment.shard.index() - 1].replace(at) {
            return Err(FileError::Shards(format!(
                "{} and {}: both are shard {}; give each once",
                paths[before].display(),
                path.display(),
                experiment.shard
            )));
        }
    }
    let missing: Vec<_> = (1..)
        .zip(&shards)
        .filter(|(_, at)| at.is_none())
        .map(|(index, _)| format!("{index}/{count}"))
        .collect();
    if !missing.is_empty() {
        return Err(FileError::Shards(format!(
            "shards {} are missing; give the files of all {count}",
            missing.join(", ")
        )));
    }
    let whole = Experiment { shard: Shard::ALL, ..first.clone() };
    let mut left: Vec<&[_]> = shards.iter().flatten().map(|&at| loaded[at].entries.as_slice()).collect();
    let mut bytes = begin_of(&whole).into_bytes();
    for (number, chunk) in whole.chunks().enumerate() {
        let (entries, rest) = left[number % count].split_at(chunk.len());
        left[number % count] = rest;
        bytes.extend(rows(&whole, chunk.case, chunk.runs.start, entries));
    }
    Ok(String::from_utf8(bytes).expect("rows are text"))
}
