//! Options of commands that draw what they simulated, and the files they ask for.

use super::{Simulation, command_line, report};
use clap::Args;
use gain_gen::{design::Design, emit};
use std::{fs, io, path::PathBuf};

/// What to draw, and where to.
#[derive(Debug, Clone, Default, Args)]
pub struct Pictures {
    /// Also write a report with pictures, one self-contained HTML file.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Also write every picture of the report as an SVG file of its own to this folder: black on white, for papers.
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
}

/// Why a file was not written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The report.
    #[error("{}: cannot write the report: {error}", path.display())]
    Report {
        /// Where to.
        path: PathBuf,
        /// What the system said.
        error: emit::WriteError,
    },
    /// The folder for pictures.
    #[error("{}: cannot make the folder for pictures: {error}", path.display())]
    Folder {
        /// Where to.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
    /// A picture.
    #[error("{}: cannot write the picture: {error}", path.display())]
    Picture {
        /// Where to.
        path: PathBuf,
        /// What the system said.
        error: emit::WriteError,
    },
}

impl Pictures {
    /// Whether any were asked for.
    pub fn are_wanted(&self) -> bool {
        self.report.is_some() || self.plots.is_some()
    }

    /// Writes what was asked for of `simulation`, for which this program was called. `design` as its file has it.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, simulation: &Simulation<'_>, design: &Design) -> Result<(), PictureError> {
        if !self.are_wanted() {
            return Ok(());
        }
        let drawn = report(simulation, design, &command_line(std::env::args()));
        if let Some(path) = &self.report {
            emit::write(path, &drawn.html)
                .map_err(|error| PictureError::Report { path: path.clone(), error })?;
        }
        let Some(folder) = &self.plots else { return Ok(()) };
        fs::create_dir_all(folder).map_err(|error| PictureError::Folder { path: folder.clone(), error })?;
        for plot in &drawn.plots {
            let path = folder.join(format!("{}.svg", plot.name));
            emit::write(&path, &plot.svg).map_err(|error| PictureError::Picture { path, error })?;
        }
        Ok(())
    }

    /// Lines for people that say where to look.
    pub fn told(&self) -> String {
        let line = |what: &str, path: &Option<PathBuf>| {
            path.as_ref().map(|path| format!("\n{what}: {}\n", path.display())).unwrap_or_default()
        };
        line("report", &self.report) + &line("pictures", &self.plots)
    }
}
