//! For build scripts: from a design file to the source that a firmware crate includes.
//!
//! ```no_run
//! // build.rs
//! gain_gen::build::compile("motor.toml");
//! ```
//!
//! and in the crate, which depends on `slqg`:
//!
//! ```ignore
//! #[allow(dead_code, unreachable_pub)]
//! mod motor {
//!     include!(concat!(env!("OUT_DIR"), "/motor.rs"));
//! }
//! ```

use crate::design::{Design, DesignError};
use crate::emit::{EmitError, Format, WriteError, emit, write};
use crate::report::Report;
use crate::solve::Method;
use std::path::{Path, PathBuf};

/// Why a design did not become source.
#[derive(Debug, thiserror::Error)]
pub enum CompileError {
    /// The design file is wrong.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// The loop cannot be stabilised, or its numbers do not fit the device.
    #[error("{}: {reason}", design.display())]
    Emit {
        /// The design file.
        design: PathBuf,
        /// Why.
        reason: EmitError,
    },
    /// The source cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Compiles `design`, relative to the package's folder, to `OUT_DIR/<file stem>.rs`, and returns that path.
///
/// Tells cargo to run the build script again when the design changes.
///
/// # Panics
/// On a design that is wrong or cannot be stabilised, with the message for whoever wrote it, and outside of a
/// build script.
pub fn compile(design: impl AsRef<Path>) -> PathBuf {
    let folder = |name: &str| {
        PathBuf::from(
            std::env::var_os(name).unwrap_or_else(|| panic!("{name} is not set: call this in build.rs")),
        )
    };
    let design = folder("CARGO_MANIFEST_DIR").join(design);
    println!("cargo:rerun-if-changed={}", design.display());
    compile_into(&design, &folder("OUT_DIR")).unwrap_or_else(|error| panic!("{error}"))
}

/// Compiles `design` to `<file stem>.rs` in `folder`, and returns that path.
///
/// # Errors
/// The design is wrong, cannot be stabilised or does not fit the device's scalar, or `folder` cannot be written.
/// A source that was there before is as it was.
pub fn compile_into(design: &Path, folder: &Path) -> Result<PathBuf, CompileError> {
    let report = Report::new(&Design::load(design)?, Method::InFlight);
    let source = emit(&report, &file_name(design), Format::Rust)
        .map_err(|reason| CompileError::Emit { design: design.into(), reason })?;
    let path = folder.join(Path::new(&file_name(design)).with_extension("rs"));
    write(&path, &source)?;
    Ok(path)
}

/// Name of the design file without its folders: generated text must not depend on where a project lies.
fn file_name(design: &Path) -> String {
    design.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
