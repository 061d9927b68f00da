//! What generated source says of the loop's stability: the verdict, what it rests on, and what was accepted.

use crate::paragraph::wrapped;

/// Width of a line, without what makes it a comment.
const WIDTH: usize = 110;

/// What is shown of a loop that is written.
#[derive(Debug, Clone, PartialEq)]
pub enum Standing {
    /// It is stable: every condition holds.
    Stable,
    /// Its stability is not shown, which was accepted.
    Accepted {
        /// The verdict, as reports name it.
        verdict: &'static str,
        /// What is not shown, in sentences.
        open: Vec<String>,
    },
    /// It ends, and stability is not asked for.
    Ends {
        /// After so many cycles.
        cycles: usize,
    },
}

impl Standing {
    /// Lines of a comment.
    pub(super) fn lines(&self) -> Vec<String> {
        match self {
            Self::Ends { cycles } => {
                vec![format!("Stability: not asked for, as this is a task that ends after {cycles} cycles.")]
            }
            Self::Stable => wrapped(
                "Stability: stable in the mean square, if plant and noise are as the design has them and packets are \
                 independent of each other, with its delays. docs/certificate.md says what is not proved.",
                WIDTH,
            ),
            Self::Accepted { verdict, open } => {
                let mut lines = vec![format!("Stability: {verdict}, which was accepted. Not shown:")];
                lines.extend(open.iter().flat_map(|sentence| wrapped(&format!("- {sentence}"), WIDTH)));
                lines
            }
        }
    }
}
