//! A solved design as files: Rust or C source or bytes for the device, or JSON for anything else.
//!
//! What is written depends on the design and the name of the file alone: no date, no path, no name of a machine.
//! Only loops that are shown to be stable and tasks of finite length are written, others where that was accepted, and files are replaced only by complete new ones.
//!
//! One module per format (`rust`, `c`, `json`, `blob`); `error` says why nothing is written, `literal` spells numbers,
//! `standing` says what is proved of the loop, `identity` says which design they belong to, `files` puts them on the disk.

mod blob;
mod c;
mod error;
mod files;
mod identity;
mod json;
mod literal;
mod rust;
mod standing;

pub use error::EmitError;
pub use files::{File, WriteError, write, write_all};
pub use identity::design_id;

use crate::report::Report;
use std::path::Path;

/// A format that is one text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A source to `include!` in a `no_std` crate that depends on `slqg`.
    Rust,
    /// The report's JSON with the plant's model and the settings of both nodes.
    Json,
}

/// The text of `report` in `format`. `origin` is the name of the design file, without folders.
///
/// # Errors
/// The loop is not shown to be stable and that was not accepted, or a number does not fit the device's scalar.
pub fn emit(report: &Report, origin: &str, format: Format) -> Result<String, EmitError> {
    writable(report)?;
    match format {
        Format::Rust => {
            runs_on_a_device(report, "rust")?;
            rust::source(report, origin)
        }
        Format::Json => Ok(json::document(report)),
    }
}

/// A loop that runs for ever must be shown to be stable, or accepted without, and know its preview; a task that ends needs neither. Frames must fit either way.
fn writable(report: &Report) -> Result<(), EmitError> {
    report.design.misfit().map_or(Ok(()), Err)?;
    if report.task.is_none() {
        report.require_emittable()?;
        report.require_preview()?;
    }
    Ok(())
}

/// Whether a device can run a controller for the plant.
fn runs_on_a_device(report: &Report, format: &'static str) -> Result<(), EmitError> {
    let states = report.design.plant.states();
    if states > slqg::estimator::MOST_STATES {
        Err(EmitError::TooManyStates { states, format })
    } else {
        Ok(())
    }
}

/// Whether a format that carries one law and nothing else carries all of the design.
fn law_alone(report: &Report, format: &'static str) -> Result<(), EmitError> {
    if report.design.tracking.is_some() {
        return Err(EmitError::LawAlone { key: "tracking", format, missing: "the feedforward" });
    }
    if report.design.event.is_some() {
        return Err(EmitError::LawAlone { key: "event", format, missing: "the decision whether to send" });
    }
    if report.design.wire.steps().is_some() {
        return Err(EmitError::LawAlone { key: "wire", format, missing: "the rounding of the inputs" });
    }
    match report.task {
        None => Ok(()),
        Some(_) => Err(EmitError::TimeVarying { format }),
    }
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

    /// A header at `header`, whose name ends in `.h`, and beside it the source, which ends in `.c` instead, and the law
    /// that both are for.
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
    /// The loop is not shown to be stable and that was not accepted, a number does not fit the device's scalar, or the format does not carry all of the design.
    pub fn files(&self, report: &Report, origin: &str) -> Result<Vec<File>, EmitError> {
        writable(report)?;
        Ok(match &self.0 {
            Kind::Text(format, path) => {
                vec![File { path: path.into(), content: emit(report, origin, *format)?.into() }]
            }
            Kind::C(names) => {
                law_alone(report, "c")?;
                c::files(report, origin, names)?.into()
            }
            Kind::Blob(path) => {
                law_alone(report, "blob")?;
                runs_on_a_device(report, "blob")?;
                vec![File { path: path.into(), content: blob::bytes(report)? }]
            }
        })
    }
}
