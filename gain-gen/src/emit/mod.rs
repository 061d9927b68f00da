//! A solved design as files: Rust or C source or bytes for the device, or JSON for anything else.
//!
//! What is written depends on the design and the name of the file alone: no date, no path, no name of a machine.
//! Only stable loops and tasks of finite length are written, and files are replaced only by complete new ones.
//!
//! One file per format (`rust`, `c`, `json`, `blob`), and one for what differs in a task of finite length (`task`); `literal` spells numbers, `identity` says which design they
//! belong to, `files` puts them on the disk.

mod blob;
mod c;
mod files;
mod identity;
mod json;
mod literal;
mod rust;
mod task;

pub use files::{File, WriteError, write, write_all};
pub use identity::design_id;

use crate::report::{NotStabilised, Report};
use slqg::blob::EncodeError;
use std::path::Path;

/// A format that is one text.
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
    /// The law is beyond what a blob can hold.
    #[error("blob: {0}")]
    Blob(EncodeError),
    /// Time-varying gains have no such format.
    #[error("--horizon: time-varying gains are written as rust or json, not as {format}")]
    TimeVarying {
        /// The format asked for.
        format: &'static str,
    },
    /// C needs a header by that name.
    #[error("--output: found {path:?} for C; {advice}")]
    HeaderName {
        /// The file named.
        path: String,
        /// What to do.
        advice: String,
    },
}

/// The text of `report` in `format`. `origin` is the name of the design file, without folders.
///
/// # Errors
/// The loop is not stable, or a number does not fit the device's scalar.
pub fn emit(report: &Report, origin: &str, format: Format) -> Result<String, EmitError> {
    writable(report)?;
    match format {
        Format::Rust => rust::source(report, origin),
        Format::Json => Ok(json::document(report)),
    }
}

/// A loop that runs for ever must be stable; a task that ends need not.
fn writable(report: &Report) -> Result<(), NotStabilised> {
    if report.task.is_some() { Ok(()) } else { report.require_stable() }
}

/// What to write, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct Output<'p>(Kind<'p>);

#[derive(Debug, Clone, PartialEq)]
enum Kind<'p> {
    Text(Format, &'p Path),
    C(c::Names),
    Blob(&'p Path),
}

impl<'p> Output<'p> {
    /// One text in `format` at `path`.
    pub fn text(format: Format, path: &'p Path) -> Self {
        Self(Kind::Text(format, path))
    }

    /// A header at `header`, whose name ends in `.h`, and beside it the source, which ends in `.c` instead.
    ///
    /// # Errors
    /// The name does not end in `.h`, or could not be told to a C compiler.
    pub fn c(header: &'p Path) -> Result<Self, EmitError> {
        c::Names::of(header).map(|names| Self(Kind::C(names)))
    }

    /// Bytes for [`slqg::blob::load`] at `path`.
    pub fn blob(path: &'p Path) -> Self {
        Self(Kind::Blob(path))
    }

    /// The files for `report`, to be written together. `origin` is the name of the design file, without folders.
    ///
    /// # Errors
    /// The loop is not stable, or a number does not fit the device's scalar.
    pub fn files(&self, report: &Report, origin: &str) -> Result<Vec<File>, EmitError> {
        writable(report)?;
        let steady = |format| match report.task {
            None => Ok(()),
            Some(_) => Err(EmitError::TimeVarying { format }),
        };
        Ok(match &self.0 {
            Kind::Text(format, path) => {
                vec![File { path: path.into(), content: emit(report, origin, *format)?.into() }]
            }
            Kind::C(names) => {
                steady("c")?;
                c::files(report, origin, names)?.into()
            }
            Kind::Blob(path) => {
                steady("blob")?;
                vec![File { path: path.into(), content: blob::bytes(report)? }]
            }
        })
    }
}
