//! One process at a time writes to a sweep's file: a lock that ends with the process, however that ends.

use super::file::FileError;
use rustix::fs::{FlockOperation, flock, fstat, stat};
use std::{fs::File, path::Path};

/// Takes the lock of the file at `path`, which is open as `file`. It is free again when `file` is closed.
///
/// # Errors
/// Another process has it, or had it and has put the file elsewhere meanwhile.
pub(super) fn lock(file: &File, path: &Path) -> Result<(), FileError> {
    let busy = || FileError::Busy { path: path.into() };
    match flock(file, FlockOperation::NonBlockingLockExclusive) {
        Ok(()) => (),
        Err(rustix::io::Errno::WOULDBLOCK) => return Err(busy()),
        Err(reason) => return Err(FileError::io(path, "locked")(reason.into())),
    }
    let own = fstat(file).map_err(|reason| FileError::io(path, "read")(reason.into()))?;
    match stat(path) {
        Ok(found) if (found.st_dev, found.st_ino) == (own.st_dev, own.st_ino) => Ok(()),
        _ => Err(busy()),
    }
}
