//! Where the files of a run are: lines to the nodes in a temporary folder, which is gone when the run is over, and the nodes'
//! logs in a folder of their own.

use super::remote::name;
use slqg::wire::Role;
use std::{
    env,
    fs::{self, File},
    io,
    path::{Path, PathBuf, absolute},
};
use tempfile::TempDir;

/// Folders of a run.
#[derive(Debug)]
pub struct Files {
    lines: TempDir,
    logs: Logs,
}

#[derive(Debug)]
enum Logs {
    /// In this folder, where they stay.
    Asked(PathBuf),
    /// Nobody wants them unless the run fails.
    Temporary(TempDir),
}

/// Why there are no folders.
#[derive(Debug, thiserror::Error)]
pub enum NoFiles {
    /// No temporary one.
    #[error(
        "no folder for a run's files can be made in {}: {reason}; set TMPDIR to one that can be written to",
        folder.display()
    )]
    Temporary {
        /// Where.
        folder: PathBuf,
        /// Why not.
        reason: io::Error,
    },
    /// None for logs, or a log in it cannot be written.
    #[error("logs cannot be written: {}: {reason}", path.display())]
    Logs {
        /// Which.
        path: PathBuf,
        /// Why not.
        reason: io::Error,
    },
}

impl Files {
    /// Folders for a run, with an empty log for each node: in `logs`, or in a temporary folder.
    ///
    /// # Errors
    /// If they cannot be made or written to.
    pub fn new(logs: Option<&Path>) -> Result<Self, NoFiles> {
        let logs = match logs {
            Some(folder) => {
                let made = fs::create_dir_all(folder).and_then(|()| absolute(folder));
                Logs::Asked(made.map_err(|reason| NoFiles::Logs { path: folder.to_owned(), reason })?)
            }
            None => Logs::Temporary(temporary("slqg-pil-logs-")?),
        };
        let files = Self { lines: temporary("slqg-pil-lines-")?, logs };
        for role in [Role::Controller, Role::Actuator] {
            let path = files.log(role);
            File::create(&path).map_err(|reason| NoFiles::Logs { path, reason })?;
        }
        Ok(files)
    }

    /// For the ends of lines.
    pub(super) fn lines(&self) -> &Path {
        self.lines.path()
    }

    fn logs(&self) -> &Path {
        match &self.logs {
            Logs::Asked(folder) => folder,
            Logs::Temporary(folder) => folder.path(),
        }
    }

    /// The log of a node: all its starts, one after the other. The first byte of each ends what the one before had not.
    pub(super) fn log(&self, role: Role) -> PathBuf {
        self.logs().join(format!("{}.log", name(role)))
    }

    /// Leaves the logs where they are, and returns their folder.
    pub fn keep_logs(self) -> PathBuf {
        match self.logs {
            Logs::Asked(folder) => folder,
            Logs::Temporary(folder) => folder.keep(),
        }
    }
}

fn temporary(prefix: &str) -> Result<TempDir, NoFiles> {
    // Absolute: emulators run in another folder.
    let folder = absolute(env::temp_dir()).unwrap_or_else(|_| env::temp_dir());
    tempfile::Builder::new()
        .prefix(prefix)
        .tempdir_in(&folder)
        .map_err(|reason| NoFiles::Temporary { folder, reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROLE: Role = Role::Controller;

    #[test]
    fn all_folders_are_gone_unless_logs_are_kept() {
        let files = Files::new(None).unwrap();
        let (lines, logs) = (files.lines().to_owned(), files.logs().to_owned());
        assert!(lines.is_dir() && logs.join("actuator.log").is_file());
        drop(files);
        assert!(!lines.exists() && !logs.exists());

        let files = Files::new(None).unwrap();
        let (lines, log) = (files.lines().to_owned(), files.log(ROLE));
        let kept = files.keep_logs();
        assert!(!lines.exists() && log.is_file());
        assert_eq!(log.parent(), Some(&*kept));
        fs::remove_dir_all(kept).unwrap();
    }

    #[test]
    fn a_run_begins_its_logs_anew_and_puts_nothing_beside_them() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("of a, b");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("controller.log"), "of another run").unwrap();
        let files = Files::new(Some(&folder)).unwrap();
        assert_eq!(fs::read(files.log(ROLE)).unwrap(), b"");
        assert!(!files.lines().starts_with(&folder));
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 2, "a log for each node");
        assert_eq!(files.keep_logs(), folder);
    }

    #[test]
    fn a_folder_for_logs_that_cannot_be_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = Files::new(Some(&file.join("logs"))).unwrap_err().to_string();
        assert!(error.contains("file/logs"), "{error}");
    }
}
