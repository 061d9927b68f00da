//! Files that are replaced only by complete new ones, one alone or several together. What is no regular file, such as a pipe
//! or `/dev/stdout`, is written as it is.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Where.
    pub path: PathBuf,
    /// What.
    pub content: Vec<u8>,
}

/// A file that could not be written; all that were there before are as they were.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {reason}; give a file in a folder that exists and can be written", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub reason: io::Error,
}

/// Where content goes.
enum Place {
    /// To a file, which is replaced: the one that is named, or that a link leads to.
    File(PathBuf),
    /// Into something that is there and cannot be replaced: a pipe, a terminal, a device.
    Through(PathBuf),
    /// To standard output, which may be a file that this program does not own.
    Stdout,
}

impl Place {
    fn of(path: &Path) -> Self {
        if ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|stdout| path == Path::new(stdout)) {
            return Self::Stdout;
        }
        let is_link = fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink());
        match fs::metadata(path) {
            Ok(found) if !found.is_file() && !found.is_dir() => Self::Through(path.into()),
            // The other descriptors of this program, for example.
            Ok(_) if is_link && (path.starts_with("/dev") || path.starts_with("/proc")) => {
                Self::Through(path.into())
            }
            Ok(_) if is_link => Self::File(fs::canonicalize(path).unwrap_or_else(|_| path.into())),
            _ => Self::File(path.into()),
        }
    }
}

/// Whether `path` is something that is written as it is, not replaced: a pipe, a device, standard output.
pub fn is_written_through(path: &Path) -> bool {
    !matches!(Place::of(path), Place::File(_))
}

/// Opens what [`is_written_through`].
///
/// # Errors
/// It cannot be opened for writing.
pub fn open_through(path: &Path) -> io::Result<Box<dyn Write + Send>> {
    Ok(match Place::of(path) {
        Place::Stdout => Box::new(io::stdout()),
        Place::File(path) | Place::Through(path) => Box::new(OpenOptions::new().append(true).open(path)?),
    })
}

/// Writes `text` to `path` in one move: a reader sees the old file or the new one, never a part. What is no regular file is
/// written as it is; a link stays, and the file that it leads to is replaced.
///
/// # Errors
/// The folder does not exist or cannot be written, or `path` cannot be replaced.
pub fn write(path: &Path, text: &str) -> Result<(), WriteError> {
    write_all(&[File { path: path.into(), content: text.into() }])
}

/// Writes all of `files`, or none. Each is replaced in one move, and not before all are on the disk. Before that, what is no
/// regular file is written.
///
/// Between the moves a reader may see some old and some new; files that must not be mixed have to tell by
/// themselves that they are.
///
/// # Errors
/// A folder does not exist or cannot be written, or a file cannot be replaced. Those replaced before it are put back.
pub fn write_all(files: &[File]) -> Result<(), WriteError> {
    let failed = |file: &File, reason| WriteError { path: file.path.clone(), reason };
    let (mut staged, mut others) = (Vec::new(), Vec::new());
    for file in files {
        match Place::of(&file.path) {
            Place::File(path) => {
                let new = stage(&path, &file.content).map_err(|reason| failed(file, reason))?;
                staged.push((file, path, new));
            }
            Place::Through(_) | Place::Stdout => others.push(file),
        }
    }
    for file in others {
        write_through(file).map_err(|reason| failed(file, reason))?;
    }
    let mut replaced: Vec<(PathBuf, Option<NamedTempFile>)> = Vec::new();
    let count = staged.len();
    for (at, (file, path, new)) in staged.into_iter().enumerate() {
        // The last one need not be put back.
        let is_last = at + 1 == count;
        let outcome = (if is_last { Ok(None) } else { backup(&path) }).and_then(|old| {
            new.persist(&path).map_err(|error| error.error)?;
            Ok(old)
        });
        match outcome {
            Ok(old) => replaced.push((path, old)),
            Err(reason) => {
                put_back(replaced);
                return Err(failed(file, reason));
            }
        }
    }
    Ok(())
}

/// A reader of a pipe that has seen enough is no failure.
fn write_through(file: &File) -> io::Result<()> {
    let written = open_through(&file.path).and_then(|mut through| {
        through.write_all(&file.content)?;
        through.flush()
    });
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        outcome => outcome,
    }
}

/// The new content, on the same file system as its place: only then can it be moved there in one step.
fn stage(path: &Path, content: &[u8]) -> io::Result<NamedTempFile> {
    let mut staged = named_file().tempfile_in(folder(path))?;
    staged.write_all(content)?;
    staged.as_file().sync_all()?;
    Ok(staged)
}

/// A copy of what is at `path`, if anything is.
fn backup(path: &Path) -> io::Result<Option<NamedTempFile>> {
    if !path.is_file() {
        return Ok(None);
    }
    let copy = named_file().tempfile_in(folder(path))?;
    fs::copy(path, copy.path())?;
    Ok(Some(copy))
}

/// Undoes replacements. What cannot be undone stays: the error that led here is the one to report.
fn put_back(replaced: Vec<(PathBuf, Option<NamedTempFile>)>) {
    for (path, old) in replaced {
        match old {
            Some(old) => drop(old.persist(&path)),
            None => drop(fs::remove_file(&path)),
        }
    }
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// A temporary file that, once in place, is as readable as any other file of the user's.
fn named_file() -> tempfile::Builder<'static, 'static> {
    #[allow(unused_mut, reason = "permissions are set on Unix only")]
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair(folder: &Path) -> [File; 2] {
        ["a.h", "a.c"].map(|name| File { path: folder.join(name), content: format!("new {name}").into() })
    }

    #[test]
    fn all_files_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let files = pair(folder.path());
        std::fs::write(&files[0].path, "old").unwrap();
        write_all(&files).unwrap();
        assert_eq!(std::fs::read(&files[0].path).unwrap(), b"new a.h");
        assert_eq!(std::fs::read(&files[1].path).unwrap(), b"new a.c");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "temporary files were left behind");
    }

    #[test]
    #[cfg(unix)]
    fn a_link_stays_and_what_it_leads_to_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (link, file) = (folder.path().join("link"), folder.path().join("file"));
        std::fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, "new").unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"new");
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
    }

    #[test]
    #[cfg(unix)]
    fn a_device_is_written_and_stays_what_it_is() {
        use std::os::unix::fs::FileTypeExt;
        write(Path::new("/dev/null"), "nothing").unwrap();
        assert!(std::fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn if_a_device_is_full_nothing_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let [kept, mut full] = pair(folder.path());
        std::fs::write(&kept.path, "old").unwrap();
        full.path = "/dev/full".into();
        let error = write_all(&[kept.clone(), full]).unwrap_err();
        assert_eq!(error.path, Path::new("/dev/full"));
        assert_eq!(std::fs::read(&kept.path).unwrap(), b"old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "something was left behind");
    }

    #[test]
    fn if_one_cannot_be_replaced_the_others_are_as_before() {
        for is_there in [true, false] {
            let folder = tempfile::tempdir().unwrap();
            let files = pair(folder.path());
            if is_there {
                std::fs::write(&files[0].path, "old").unwrap();
            }
            // A folder cannot be replaced by a file.
            std::fs::create_dir(&files[1].path).unwrap();
            let error = write_all(&files).unwrap_err();
            assert_eq!(error.path, files[1].path);
            let left = std::fs::read(&files[0].path).ok();
            assert_eq!(left.as_deref(), is_there.then_some(&b"old"[..]));
            let count = if is_there { 2 } else { 1 };
            assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), count, "something was left behind");
        }
    }
}
