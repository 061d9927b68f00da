//! The nodes' programs for a design: built by the project's own task.

use super::emulator::{Board, Transport};
use slqg::DefaultInput;
use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// What is to be built.
#[derive(Debug, Clone)]
pub struct Request<'a> {
    /// The design file.
    pub design: &'a Path,
    /// Inputs per sequence, if not as in the design.
    pub sequence_length: Option<usize>,
    /// What the actuator does when its buffer has run out, if not as in the design.
    pub default_input: Option<DefaultInput>,
    /// The board.
    pub board: Board,
    /// The line to it.
    pub transport: Transport,
    /// Slices of a solution in a cycle, if the controller tunes itself.
    pub slices: Option<usize>,
    /// Whether frames are sealed; with keys for tests, which everybody knows.
    pub is_sealed: bool,
}

/// Why there are no images.
#[derive(Debug, thiserror::Error)]
pub enum NoImages {
    /// The task cannot be run.
    #[error("cannot run `cargo xtask firmware`: {0}; give --controller-image and --actuator-image")]
    Start(#[from] std::io::Error),
    /// The task has failed, and has said why.
    #[error("`cargo xtask firmware` has failed; its message is above")]
    Failed,
    /// It has not built what it should.
    #[error("`cargo xtask firmware` has built no {0}")]
    Missing(String),
}

/// Builds controller and actuator, and returns where they are. Messages of the build go to stderr.
///
/// # Errors
/// If the sources are not where they were when this program was built, or the build fails.
pub fn build(request: &Request<'_>) -> Result<[PathBuf; 2], NoImages> {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    command.args(["xtask", "firmware", "--board", request.board.name(), "--design"]);
    command.arg(std::path::absolute(request.design)?);
    // The boards are emulated: this is where an undecided loop is to be looked at.
    command.arg("--accept-undecided-stability");
    if let Some(length) = request.sequence_length {
        command.args(["--sequence-length", &length.to_string()]);
    }
    if let Some(default_input) = request.default_input {
        command.args(["--default-input", default_input.name()]);
    }
    if let Some(slices) = request.slices {
        command.args(["--tuning", "--slices", &slices.to_string()]);
    }
    if request.is_sealed {
        command.args(["--keys", "test"]);
    }
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output()?;
    if !output.status.success() {
        return Err(NoImages::Failed);
    }
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let image = |node: &str| {
        let name = match request.transport {
            Transport::Uart => node.to_owned(),
            Transport::Bulk => format!("{node}_bulk"),
        };
        let found =
            text.lines().map(PathBuf::from).find(|path| path.file_name().is_some_and(|file| *file == *name));
        found.ok_or(NoImages::Missing(name))
    };
    let controller = if request.slices.is_some() { "tuning_controller" } else { "controller" };
    Ok([image(controller)?, image("actuator")?])
}
