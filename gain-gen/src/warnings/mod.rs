//! What a design asks for that makes no sense, though gains for it exist. A warning changes no verdict, no gain and no
//! status.
//!
//! | file | what it looks at |
//! |---|---|
//! | `sampling` | the sample time against the plant and against the loop that it closes |
//! | `noise` | noise without which an estimator stops listening, and measurements that differ beyond measure |
//! | `weights` | weights that have no say beside others, and what no weight sees |
//! | `spread` | how far numbers on a diagonal are apart, as written and in balanced units |
//!
//! Limits are wide: what is warned of is off by orders of magnitude, and no unit of a state, input or output brings a
//! warning about by itself.

mod noise;
mod sampling;
mod spread;
mod weights;

use crate::console;
use crate::design::{Design, DesignError, modes};
use crate::solve::{Outcome, Solution};
use nalgebra::{Complex, DMatrix};
use std::fmt::{self, Display, Formatter};
use std::path::Path;

/// Something that makes no sense, and where.
///
/// `Display` gives one line with the file, for example `motor.toml:3: plant.sample_time: found .. ; sample ..`.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// The design file.
    pub origin: String,
    /// Line of the key, counted from 1, if the design has the key.
    pub line: Option<usize>,
    /// Dotted key.
    pub key: &'static str,
    /// What was found and why it makes no sense, as a clause.
    pub found: String,
    /// What to do.
    pub advice: String,
}

impl Warning {
    fn new(design: &Design, key: &'static str, found: String, advice: String) -> Self {
        Self { origin: design.places.origin.clone(), line: design.places.line(key), key, found, advice }
    }

    /// The same without the file: it depends on the design alone, not on where that lies.
    pub fn within_file(&self) -> String {
        let line = self.line.map(|line| format!(" (line {line})")).unwrap_or_default();
        format!("{}{line}: {}; {}", self.key, self.found, self.advice)
    }
}

impl Display for Warning {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let line = self.line.map(|line| format!(":{line}")).unwrap_or_default();
        write!(f, "{}{line}: {}: {}; {}", self.origin, self.key, self.found, self.advice)
    }
}

/// [`Design::load`], and what makes no sense in the design itself goes to stderr.
///
/// # Errors
/// As [`Design::load`].
pub fn load(path: &Path) -> Result<Design, DesignError> {
    let design = Design::load(path)?;
    tell(&of_design(&design));
    Ok(design)
}

/// Each on a line of stderr.
pub fn tell(warnings: &[Warning]) {
    warnings.iter().for_each(|warning| console::tell(format_args!("warning: {warning}")));
}

/// Those of the square matrix `a`; `None` if the iteration for them does not converge.
fn eigenvalues(a: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    Some(modes::modes(a)?.into_iter().map(|mode| mode.value).collect())
}

/// What the design itself shows.
pub fn of_design(design: &Design) -> Vec<Warning> {
    let mut found = Vec::new();
    found.extend(sampling::of_plant(design));
    found.extend(noise::of(design));
    found.extend(weights::of_design(design));
    found
}

/// What only the loop shows, with `solution` the design's. Nothing where none was found.
pub fn of_loop(design: &Design, solution: &Solution) -> Vec<Warning> {
    if solution.outcome != Outcome::Converged {
        return Vec::new();
    }
    let mut found = Vec::new();
    found.extend(sampling::of_loop(design, solution.mean_square_rate));
    found.extend(weights::of_loop(design, &solution.cost_to_go));
    found
}
