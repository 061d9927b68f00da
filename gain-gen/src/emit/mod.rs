//! A solved design as files: Rust or C source or bytes for the device, or JSON for anything else.
//!
//! What is written depends on the design and the name of the file alone: no date, no path, no name of a machine.
//! What may be written is an [`Emission`], which a report has only of loops that are shown to be stable, of tasks of finite length, and
//! of others where that was accepted. Files are replaced only by complete new ones.
//!
//! One module per format (`rust`, `c`, `json`, `blob`); `emission` is what they take, `error` says why one does not, `literal` spells numbers,
//! `standing` says what is proved of the loop, `identity` says which design they belong to, `files` puts them on the disk.

mod blob;
mod c;
mod emission;
mod error;
mod files;
mod identity;
mod json;
mod literal;
mod rust;
mod standing;

pub use emission::{Emission, Figures, TaskGains};
pub use error::EmitError;
pub use files::{File, WriteError, is_written_through, open_through, write, write_all};
pub use identity::design_id;
pub use standing::Standing;

use slqg::estimator::Merging;
use std::path::Path;

/// A format that is one text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A source to `include!` in a `no_std` crate that depends on `slqg`.
    Rust,
    /// The report's JSON with the plant's model and the settings of both nodes.
    Json,
}

/// The text of `emission` in `format`. `origin` is the name of the design file, without folders.
///
/// # Errors
/// A number does not fit the device's scalar, or no device runs the design.
pub fn emit(emission: &Emission<'_>, origin: &str, format: Format) -> Result<String, EmitError> {
    match format {
        Format::Rust => {
            runs_on_a_device(emission, "rust")?;
            rust::source(emission, origin)
        }
        Format::Json => Ok(json::document(emission)),
    }
}

/// Whether a device can run a controller for the plant.
fn runs_on_a_device(emission: &Emission<'_>, format: &'static str) -> Result<(), EmitError> {
    let states = emission.design.plant.states();
    if states > slqg::estimator::MOST_STATES {
        Err(EmitError::TooManyStates { states, format })
    } else {
        Ok(())
    }
}

/// Whether a format that carries one law and nothing else carries all of the design.
fn law_alone(emission: &Emission<'_>, format: &'static str) -> Result<(), EmitError> {
    if emission.design.tracking.is_some() {
        return Err(EmitError::LawAlone { key: "tracking", format, missing: "the feedforward" });
    }
    if emission.design.event.is_some() {
        return Err(EmitError::LawAlone { key: "event", format, missing: "the decision whether to send" });
    }
    if emission.design.wire.counts_values() {
        return Err(EmitError::LawAlone { key: "wire", format, missing: "the rounding of the inputs" });
    }
    if format == "c" && emission.merging() == Merging::Linear {
        let (key, missing) = ("network.acknowledgement", "the mean of the inputs in place of ages");
        return Err(EmitError::LawAlone { key, format, missing });
    }
    match emission.task {
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

    /// The files for `emission`, to be written together. `origin` is the name of the design file, without folders.
    ///
    /// # Errors
    /// A number does not fit the device's scalar, no device runs the design, or the format does not carry all of it.
    pub fn files(&self, emission: &Emission<'_>, origin: &str) -> Result<Vec<File>, EmitError> {
        Ok(match &self.0 {
            Kind::Text(format, path) => {
                vec![File { path: path.into(), content: emit(emission, origin, *format)?.into() }]
            }
            Kind::C(names) => {
                law_alone(emission, "c")?;
                c::files(emission, origin, names)?.into()
            }
            Kind::Blob(path) => {
                law_alone(emission, "blob")?;
                runs_on_a_device(emission, "blob")?;
                vec![File { path: path.into(), content: blob::bytes(emission)? }]
            }
        })
    }
}
