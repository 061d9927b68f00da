//! A solved design as a file: Rust source for the device, or JSON for anything else.
//!
//! What is written depends on the design alone: no date, no path, no name of a machine. Only stable loops are
//! written, and a file is replaced only by a complete new one.

mod json;
mod literal;
mod rust;

use crate::report::{NotStabilised, Report};
use std::io::Write;
use std::path::{Path, PathBuf};

/// What to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A source to `include!` in a `no_std` crate that depends on `slqg`.
    Rust,
    /// The report's JSON with the plant's model and the settings of both nodes.
    Json,
}

/// Why a design is not written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EmitError {
    /// The loop is not shown to be stable.
    #[error(transparent)]
    NotStabilised(#[from] NotStabilised),
    /// A number is beyond what the device's scalar can hold.
    #[error("{table}: found {value}, which {scalar} cannot hold; {advice}")]
    OutOfRange {
        /// The table with the number.
        table: &'static str,
        /// The number.
        value: f64,
        /// The scalar's name.
        scalar: &'static str,
        /// What to do.
        advice: &'static str,
    },
}

/// A file that could not be written; one that was there before is as it was.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {reason}; give a file in a folder that exists and can be written", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// What the system said.
    pub reason: std::io::Error,
}

/// The text of `report` in `format`. `origin` is the name of the design file, without folders.
///
/// # Errors
/// The loop is not stable, or a number does not fit the device's scalar.
pub fn emit(report: &Report, origin: &str, format: Format) -> Result<String, EmitError> {
    report.require_stable()?;
    match format {
        Format::Rust => rust::source(report, origin),
        Format::Json => Ok(json::document(report)),
    }
}

/// Writes `text` to `path` in one move: a reader sees the old file or the new one, never a part.
///
/// # Errors
/// The folder does not exist or cannot be written, or `path` cannot be replaced.
pub fn write(path: &Path, text: &str) -> Result<(), WriteError> {
    let replace = || {
        // The new file must be on the same file system to be moved in one step.
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let mut file = named_file().tempfile_in(folder)?;
        file.write_all(text.as_bytes())?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|error| error.error)?;
        Ok(())
    };
    replace().map_err(|reason| WriteError { path: path.into(), reason })
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
