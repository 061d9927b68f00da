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
//!
//! [`Compile`] changes in a design what the command line can change:
//!
//! ```no_run
//! use gain_gen::build::Compile;
//! use slqg::DefaultInput;
//!
//! Compile::new("motor.toml").run();
//! Compile::new("motor.toml").default_input(DefaultInput::Hold).sequence_length(6).name("motor_hold").run();
//! ```

use crate::design::{Design, DesignError, LONGEST_SEQUENCE};
use crate::emit::{EmitError, Format, WriteError, emit, write};
use crate::report::{LONGEST_TASK, NoTask, NotEmittable, Report};
use crate::solve::Method;
use crate::warnings::Warning;
use slqg::DefaultInput;
use std::path::{Path, PathBuf};

/// Why a design did not become source.
#[derive(Debug, thiserror::Error)]
pub enum CompileError {
    /// The design file is wrong.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// What the build script asks for is wrong.
    #[error("{}: {setting}: found {found}; give {allowed}", design.display())]
    Setting {
        /// The design file.
        design: PathBuf,
        /// The method of [`Compile`].
        setting: &'static str,
        /// What it was given.
        found: String,
        /// What it may be given.
        allowed: String,
    },
    /// The design has no task of finite length.
    #[error("{}: {reason}", design.display())]
    NoTask {
        /// The design file.
        design: PathBuf,
        /// Why.
        reason: NoTask,
    },
    /// The loop is not shown to be stable, or cannot be as the design has it.
    #[error("{}: {reason}", design.display())]
    NotEmittable {
        /// The design file.
        design: PathBuf,
        /// Why.
        reason: NotEmittable,
    },
    /// Its numbers do not fit the device.
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

/// Compiles `design`, relative to the package's folder, to `OUT_DIR/<file stem>.rs`, and returns that path:
/// [`Compile::run`] without changes.
///
/// # Panics
/// As [`Compile::run`].
pub fn compile(design: impl AsRef<Path>) -> PathBuf {
    Compile::new(design).run()
}

/// Compiles `design` to `<file stem>.rs` in `folder`, and returns that path: [`Compile::run_into`] without changes.
///
/// # Errors
/// As [`Compile::run_into`].
pub fn compile_into(design: &Path, folder: &Path) -> Result<PathBuf, CompileError> {
    Compile::new(design).run_into(folder)
}

/// A design file on its way to source, and what is changed in it.
#[derive(Debug, Clone, PartialEq, Eq)]
#[must_use = "nothing is compiled before `run`"]
pub struct Compile {
    design: PathBuf,
    sequence_length: Option<usize>,
    default_input: Option<DefaultInput>,
    horizon: Option<usize>,
    name: Option<String>,
    accepts_undecided_stability: bool,
}

/// A design that was compiled.
#[derive(Debug, Clone, PartialEq)]
pub struct Compiled {
    /// The source.
    pub path: PathBuf,
    /// The design, with what was changed in it.
    pub design: Design,
    /// Outputs that follow a reference in the source, `nz`; 0 if none does.
    pub tracked_outputs: usize,
    /// Samples of the reference that make a difference, `T`; 0 if none is followed.
    pub preview_samples: usize,
    /// What makes no sense in the design.
    pub warnings: Vec<Warning>,
}

impl Compile {
    /// The design as it is in its file.
    pub fn new(design: impl AsRef<Path>) -> Self {
        Self {
            design: design.as_ref().into(),
            sequence_length: None,
            default_input: None,
            horizon: None,
            name: None,
            accepts_undecided_stability: false,
        }
    }

    /// Inputs per packet, 1 to [`LONGEST_SEQUENCE`], instead of the design's.
    pub fn sequence_length(self, length: usize) -> Self {
        Self { sequence_length: Some(length), ..self }
    }

    /// What the actuator applies when its buffer has run out, instead of the design's.
    pub fn default_input(self, default_input: DefaultInput) -> Self {
        Self { default_input: Some(default_input), ..self }
    }

    /// The time-varying gains of a task of so many cycles, 1 to [`LONGEST_TASK`], instead of the steady-state ones.
    pub fn horizon(self, cycles: usize) -> Self {
        Self { horizon: Some(cycles), ..self }
    }

    /// Writes `<name>.rs` instead of `<file stem>.rs`.
    pub fn name(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// Compiles the design although its stability is undecided, as it is for instance with late acknowledgements or with input
    /// limits on an unstable plant. The source says so, and which condition is not shown. An unstable loop is refused all
    /// the same.
    pub fn accept_undecided_stability(self) -> Self {
        Self { accepts_undecided_stability: true, ..self }
    }

    /// Compiles the design, relative to the package's folder, to a source in `OUT_DIR`, and returns its path.
    ///
    /// Tells cargo to run the build script again when the design changes, and what makes no sense in it as warnings
    /// ([`crate::warnings`]).
    ///
    /// # Panics
    /// On a design that is wrong or not shown to be stable, with the message for whoever wrote it, and outside of a
    /// build script.
    pub fn run(self) -> PathBuf {
        self.run_for_more().path
    }

    /// [`Compile::run`] for build scripts that write more of the design than its source.
    ///
    /// # Panics
    /// As [`Compile::run`].
    pub fn run_for_more(self) -> Compiled {
        let folder = |name: &str| {
            PathBuf::from(
                std::env::var_os(name).unwrap_or_else(|| panic!("{name} is not set: call this in build.rs")),
            )
        };
        let design = folder("CARGO_MANIFEST_DIR").join(&self.design);
        println!("cargo:rerun-if-changed={}", design.display());
        let compiled = Self { design, ..self }.compiled_into(&folder("OUT_DIR"));
        let compiled = compiled.unwrap_or_else(|error| panic!("{error}"));
        compiled.warnings.iter().for_each(|warning| println!("cargo:warning={warning}"));
        compiled
    }

    /// Compiles the design to a source in `folder`, and returns its path.
    ///
    /// # Errors
    /// The design is wrong, is not shown to be stable or does not fit the device's scalar, what was asked for is not
    /// possible, or `folder` cannot be written. A source that was there before is as it was.
    pub fn run_into(&self, folder: &Path) -> Result<PathBuf, CompileError> {
        Ok(self.compiled_into(folder)?.path)
    }

    /// [`Compile::run_into`] for whoever writes more of the design than its source.
    ///
    /// # Errors
    /// As [`Compile::run_into`].
    pub fn compiled_into(&self, folder: &Path) -> Result<Compiled, CompileError> {
        let name = self.file_name()?;
        self.within("sequence_length", "inputs", self.sequence_length, LONGEST_SEQUENCE)?;
        self.within("horizon", "cycles", self.horizon, LONGEST_TASK)?;
        let mut report = Report::new(&self.changed()?, Method::InFlight);
        if self.accepts_undecided_stability {
            report.accept_undecided_stability();
        }
        if let Some(cycles) = self.horizon {
            let no_task = |reason| CompileError::NoTask { design: self.design.clone(), reason };
            report.find_task(cycles).map_err(no_task)?;
        }
        // Without folders: generated text must not depend on where a project lies.
        let origin = self.design.file_name().unwrap_or_default().to_string_lossy();
        let not_emittable = |reason| CompileError::NotEmittable { design: self.design.clone(), reason };
        let emission = report.emission().map_err(not_emittable)?;
        let source = emit(&emission, &origin, Format::Rust)
            .map_err(|reason| CompileError::Emit { design: self.design.clone(), reason })?;
        let path = folder.join(name);
        write(&path, &source)?;
        let tracked = emission.design.tracking.as_ref().zip(emission.preview);
        Ok(Compiled {
            path,
            tracked_outputs: tracked.map_or(0, |(tracking, _)| tracking.outputs()),
            preview_samples: tracked.map_or(0, |(_, gains)| gains.samples),
            design: report.design,
            warnings: report.warnings,
        })
    }

    fn changed(&self) -> Result<Design, DesignError> {
        let mut design = Design::load(&self.design)?;
        if let Some(default_input) = self.default_input {
            // A length that the design leaves open is chosen anew.
            design.set_default_input(default_input);
        }
        if let Some(length) = self.sequence_length {
            design.set_sequence_length(length);
        }
        Ok(design)
    }

    fn file_name(&self) -> Result<PathBuf, CompileError> {
        let Some(name) = &self.name else {
            return Ok(Path::new(self.design.file_name().unwrap_or_default()).with_extension("rs"));
        };
        if name.is_empty() || name.contains(['/', '\\']) {
            let allowed = "the name of a file without folders and extension, such as \"motor_hold\"";
            return Err(self.refused("name", format!("{name:?}"), allowed.into()));
        }
        Ok(format!("{name}.rs").into())
    }

    fn within(
        &self,
        setting: &'static str,
        of: &str,
        given: Option<usize>,
        most: usize,
    ) -> Result<(), CompileError> {
        match given {
            Some(found) if !(1..=most).contains(&found) => {
                Err(self.refused(setting, found.to_string(), format!("a number of {of} from 1 to {most}")))
            }
            _ => Ok(()),
        }
    }

    fn refused(&self, setting: &'static str, found: String, allowed: String) -> CompileError {
        CompileError::Setting { design: self.design.clone(), setting, found, allowed }
    }
}
