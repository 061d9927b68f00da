//! Files that are replaced only by complete new ones, one alone or several together.

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

/// Writes `text` to `path` in one move: a reader sees the old file or the new one, never a part.
///
/// # Errors
/// The folder does not exist or cannot be written, or `path` cannot be replaced.
pub fn write(path: &Path, text: &str) -> Result<(), WriteError> {
    write_all(&[File { path: path.into(), content: text.into() }])
}

/// Writes all of `files`, or none. Each is replaced in one move, and not before all are on the disk.
///
/// Between the moves a reader may see some old and some new; files that must not be mixed have to tell by
/// themselves that they are.
///
/// # Errors
/// A folder does not exist or cannot be written, or a file cannot be replaced. Those replaced before it are put back.
pub fn write_all(files: &[File]) -> Result<(), WriteError> {
    let failed = |file: &File, reason| WriteError { path: file.path.clone(), reason };
    let staged = files
        .iter()
        .map(|file| stage(file).map_err(|reason| failed(file, reason)))
        .collect::<Result<Vec<_>, _>>()?;
    let mut replaced: Vec<(&File, Option<NamedTempFile>)> = Vec::new();
    for (at, (file, new)) in files.iter().zip(staged).enumerate() {
        // The last one need not be put back.
        let is_last = at + 1 == files.len();
        let outcome = (if is_last { Ok(None) } else { backup(&file.path) }).and_then(|old| {
            new.persist(&file.path).map_err(|error| error.error)?;
            Ok(old)
        });
        match outcome {
            Ok(old) => replaced.push((file, old)),
            Err(reason) => {
                put_back(replaced);
                return Err(failed(file, reason));
            }
        }
    }
    Ok(())
}

/// The new content, on the same file system as its place: only then can it be moved there in one step.
fn stage(file: &File) -> io::Result<NamedTempFile> {
    let mut staged = named_file().tempfile_in(folder(&file.path))?;
    staged.write_all(&file.content)?;
    staged.as_file().sync_all()?;
    Ok(staged)
}

/// A copy of what is at `path`, if anything is.
fn backup(path: &Path) -> io::Result<Option<NamedTempFile>> {
    if !path.is_file() {
        return Ok(None);
    }
    let copy = named_file().tempfile_in(folder(path))?;
    std::fs::copy(path, copy.path())?;
    Ok(Some(copy))
}

/// Undoes replacements. What cannot be undone stays: the error that led here is the one to report.
fn put_back(replaced: Vec<(&File, Option<NamedTempFile>)>) {
    for (file, old) in replaced {
        match old {
            Some(old) => drop(old.persist(&file.path)),
            None => drop(std::fs::remove_file(&file.path)),
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
