//! Reading a sweep's file: the head, then as many rows as there are, each checked to be the one that belongs there.

use super::{
    experiment::{Case, Experiment},
    row::{Entry, Row},
};
use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// Why a file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file cannot be read or written.
    #[error("{}: cannot be {what}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Read, written, ..
        what: &'static str,
        /// What the system says.
        reason: io::Error,
    },
    /// The file is no sweep's, or damaged.
    #[error("{}: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where and why.
        reason: String,
    },
    /// The file is another experiment's.
    #[error("{}: another experiment: {difference}; give another file, or delete it", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// In what.
        difference: String,
    },
    /// An interrupted sweep would be lost.
    #[error("{}: an interrupted sweep; continue it with --resume, or delete it", path.display())]
    Interrupted {
        /// Its file.
        path: PathBuf,
    },
    /// Another process writes it.
    #[error(
        "{}: another sweep is writing it; wait until that has ended, give this one another --output, or share the runs \
         with --shard",
        path.display()
    )]
    Busy {
        /// The file.
        path: PathBuf,
    },
    /// Rows are missing.
    #[error("{}: found {found} of {expected} rows; continue the sweep with --resume", path.display())]
    Incomplete {
        /// The file.
        path: PathBuf,
        /// Rows found.
        found: usize,
        /// Rows of the complete file.
        expected: usize,
    },
    /// A part of an experiment where all of it is needed.
    #[error("{}: shard {shard} only; put all shards together with `host-sim merge`", path.display())]
    Shard {
        /// The file.
        path: PathBuf,
        /// Which.
        shard: super::Shard,
    },
    /// Files that do not make one experiment.
    #[error("{0}")]
    Shards(String),
}

impl FileError {
    /// For [`Result::map_err`].
    pub(super) fn io<'p>(path: &'p Path, what: &'static str) -> impl FnOnce(io::Error) -> Self + 'p {
        move |reason| Self::Io { path: path.into(), what, reason }
    }
}

/// An experiment with its rows in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// What was simulated.
    pub experiment: Experiment,
    /// As many rows as there are, in the order of the file.
    pub entries: Vec<Entry>,
}

impl Results {
    /// The file at `path`, which must be complete.
    ///
    /// # Errors
    /// It cannot be read, is damaged, or rows are missing.
    pub fn load(path: &Path) -> Result<Self, FileError> {
        let text = fs::read_to_string(path).map_err(FileError::io(path, "read"))?;
        let damaged = |reason| FileError::Damaged { path: path.into(), reason };
        let Started { results, length } = Started::parse(&text)
            .map_err(damaged)?
            .ok_or_else(|| damaged("not written by `host-sim sweep`".into()))?;
        let (found, expected) = (results.entries.len(), results.experiment.rows());
        match found == expected && length == text.len() {
            true => Ok(results),
            false => Err(FileError::Incomplete { path: path.into(), found, expected }),
        }
    }

    /// As [`Results::load`], but no shard.
    ///
    /// # Errors
    /// As there, or the file is a shard of more than one.
    pub fn load_whole(path: &Path) -> Result<Self, FileError> {
        let results = Self::load(path)?;
        match results.experiment.shard {
            shard if shard.count() > 1 => Err(FileError::Shard { path: path.into(), shard }),
            _ => Ok(results),
        }
    }

    /// The cases with their entries, for a complete experiment.
    pub fn by_case(&self) -> impl Iterator<Item = (&Case, &[Entry])> {
        self.experiment.cases.iter().zip(self.entries.chunks(self.experiment.runs.max(1) as usize))
    }
}

/// A file as far as it goes.
#[derive(Debug)]
pub(super) struct Started {
    pub(super) results: Results,
    /// Bytes up to the end of the last complete row.
    pub(super) length: usize,
}

impl Started {
    /// `None` if not even the two head lines are complete. A last line without its end does not count.
    pub(super) fn parse(text: &str) -> Result<Option<Self>, String> {
        let complete = &text[..text.rfind('\n').map_or(0, |at| at + 1)];
        let Some((head, rest)) = complete.split_once('\n') else { return Ok(None) };
        let experiment = Experiment::from_head(head)?;
        if rest.is_empty() {
            return Ok(None);
        }
        let mut reader = csv::Reader::from_reader(rest.as_bytes());
        if reader.headers().map_err(|error| error.to_string())? != Row::COLUMNS.as_slice() {
            return Err(format!("line 2: the columns are not {}", Row::COLUMNS.join(",")));
        }
        let fingerprint = experiment.fingerprint();
        let mut expected = experiment.chunks().flat_map(|chunk| chunk.runs.map(move |run| (chunk.case, run)));
        let mut entries = Vec::new();
        for (line, record) in (3..).zip(reader.records()) {
            let wrong = |reason: &dyn std::fmt::Display| {
                format!(
                    "line {line}: {reason}; delete from this line on, and continue the sweep with --resume"
                )
            };
            let record = record.map_err(|error| wrong(&error))?;
            let row: Row<'_> = record.deserialize(None).map_err(|error| wrong(&error))?;
            match expected.next() {
                Some((case, run)) if row.is(&experiment.cases[case], run) => {
                    if !row.is_unchanged(fingerprint) {
                        return Err(wrong(
                            &"the figures do not fit their check: changed after they were written",
                        ));
                    }
                    entries.push(row.entry());
                }
                Some((case, run)) => {
                    let Case { design, controller, sequence_length } = &experiment.cases[case];
                    let controller = controller.name();
                    return Err(wrong(&format_args!(
                        "expected {design}, {controller}, N = {sequence_length}, run {run}"
                    )));
                }
                None => return Err(wrong(&"expected no further row")),
            }
        }
        drop(expected);
        Ok(Some(Self { results: Results { experiment, entries }, length: complete.len() }))
    }
}
