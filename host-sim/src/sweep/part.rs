//! [`Part`]: the file that a sweep grows beside its output, and that takes the output's place when it is complete.

use super::{
    experiment::Experiment,
    file::{FileError, Results, Started},
    row::{Entry, Row, rows},
};
use std::{
    fs::{self, File, OpenOptions},
    io::Write,
    path::{Path, PathBuf},
};

/// `output` with `.part` after its name.
pub fn part_path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// A sweep's file as it grows.
#[derive(Debug)]
pub struct Part {
    file: File,
    path: PathBuf,
    output: PathBuf,
}

impl Part {
    /// Begins the file beside `output`, or with `resume` continues one that is there; the entries that it has already. A
    /// half-written last line is dropped.
    ///
    /// # Errors
    /// There is one but it is not to be continued, is another experiment's or damaged; or it cannot be written.
    pub fn open(
        output: &Path,
        experiment: &Experiment,
        resume: bool,
    ) -> Result<(Self, Vec<Entry>), FileError> {
        let path = part_path(output);
        if path.exists() && !resume {
            return Err(FileError::Interrupted { path });
        }
        let started = match path.exists() {
            true => started(&path, experiment)?,
            false => None,
        };
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&path)
            .map_err(FileError::io(&path, "opened"))?;
        let (length, entries) =
            started.map_or((0, Vec::new()), |started| (started.length, started.results.entries));
        let mut begin = || {
            file.set_len(length as u64)?;
            match length {
                0 => file.write_all(begin_of(experiment).as_bytes()),
                _ => Ok(()),
            }
        };
        begin().map_err(FileError::io(&path, "written"))?;
        Ok((Self { file, path, output: output.into() }, entries))
    }

    /// Adds rows of runs from `first` on of a case: all of them or, if the process ends meanwhile, some.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn append(
        &mut self,
        experiment: &Experiment,
        case: usize,
        first: u64,
        entries: &[Entry],
    ) -> Result<(), FileError> {
        let bytes = rows(&experiment.cases[case], first, entries);
        self.file.write_all(&bytes).map_err(FileError::io(&self.path, "written"))
    }

    /// Puts the complete file in the place of the output.
    ///
    /// # Errors
    /// It cannot be moved there.
    pub fn finish(self) -> Result<(), FileError> {
        self.file.sync_all().map_err(FileError::io(&self.path, "written"))?;
        fs::rename(&self.path, &self.output).map_err(FileError::io(&self.output, "replaced"))
    }
}

/// The lines before the rows.
pub(super) fn begin_of(experiment: &Experiment) -> String {
    format!("{}{}\n", experiment.head(), Row::COLUMNS.join(","))
}

/// What is in the file already; `None` if that does not even reach to the first row.
fn started(path: &Path, experiment: &Experiment) -> Result<Option<Started>, FileError> {
    let mut bytes = fs::read(path).map_err(FileError::io(path, "read"))?;
    if begin_of(experiment).as_bytes().starts_with(&bytes) {
        return Ok(None);
    }
    // A half-written line may end within a character.
    bytes.truncate(bytes.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1));
    let damaged = |reason: String| FileError::Damaged { path: path.into(), reason };
    let text = String::from_utf8(bytes).map_err(|error| damaged(error.to_string()))?;
    let started = Started::parse(&text)
        .map_err(damaged)?
        .ok_or_else(|| damaged("not written by `host-sim sweep`".into()))?;
    same(path, experiment, &started.results)?;
    Ok(Some(started))
}

/// The entries of a complete output of `experiment`, if there is one.
///
/// # Errors
/// There is a file, but it is damaged or another experiment's.
pub fn finished(output: &Path, experiment: &Experiment) -> Result<Option<Vec<Entry>>, FileError> {
    if !output.exists() {
        return Ok(None);
    }
    let results = Results::load(output)?;
    same(output, experiment, &results)?;
    Ok(Some(results.entries))
}

fn same(path: &Path, experiment: &Experiment, found: &Results) -> Result<(), FileError> {
    let difference = found.experiment.difference(experiment).or_else(|| {
        let (found, wanted) = (found.experiment.shard, experiment.shard);
        (found != wanted).then(|| format!("shard: {found} against {wanted}"))
    });
    match difference {
        Some(difference) => Err(FileError::Foreign { path: path.into(), difference }),
        None => Ok(()),
    }
}
