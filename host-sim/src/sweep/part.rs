//! [`Part`]: the file that a sweep grows beside its output, and that takes the output's place when it is complete.
//!
//! An output that is no regular file, such as a pipe, gets the rows as they come, and cannot be continued.

use super::{
    experiment::Experiment,
    file::{FileError, Results, Started},
    lock::lock,
    row::{Entry, Row, rows},
};
use gain_gen::emit::{is_written_through, open_through};
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
pub struct Part {
    rows: Rows,
    /// Where rows are written.
    path: PathBuf,
    output: PathBuf,
}

/// What takes the rows.
enum Rows {
    /// A file beside the output, locked.
    Beside(File),
    /// The output itself.
    Through(Box<dyn Write + Send>),
}

impl Part {
    /// Begins the file beside `output`, or with `resume` continues one that is there; the entries that it has already. A
    /// half-written last line is dropped.
    ///
    /// # Errors
    /// There is one but it is not to be continued, another process writes it, or it is another experiment's or damaged; or it
    /// cannot be written.
    pub fn open(
        output: &Path,
        experiment: &Experiment,
        resume: bool,
    ) -> Result<(Self, Vec<Entry>), FileError> {
        if is_written_through(output) {
            let mut through = open_through(output).map_err(FileError::io(output, "opened"))?;
            through.write_all(begin_of(experiment).as_bytes()).map_err(FileError::io(output, "written"))?;
            let rows = Rows::Through(through);
            return Ok((Self { rows, path: output.into(), output: output.into() }, Vec::new()));
        }
        let path = part_path(output);
        let was_there = path.exists();
        let mut file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(&path)
            .map_err(FileError::io(&path, "opened"))?;
        lock(&file, &path)?;
        if was_there && !resume {
            return Err(FileError::Interrupted { path });
        }
        let started = started(&path, experiment)?;
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
        Ok((Self { rows: Rows::Beside(file), path, output: output.into() }, entries))
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
        let bytes = rows(experiment, case, first, entries);
        let written = match &mut self.rows {
            Rows::Beside(file) => file.write_all(&bytes),
            Rows::Through(output) => output.write_all(&bytes),
        };
        written.map_err(FileError::io(&self.path, "written"))
    }

    /// Puts the complete file in the place of the output, where it is not there already.
    ///
    /// # Errors
    /// It cannot be moved there.
    pub fn finish(self) -> Result<(), FileError> {
        let file = match self.rows {
            Rows::Through(mut output) => {
                return output.flush().map_err(FileError::io(&self.path, "written"));
            }
            Rows::Beside(file) => file,
        };
        file.sync_all().map_err(FileError::io(&self.path, "written"))?;
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
    if !output.exists() || is_written_through(output) {
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
