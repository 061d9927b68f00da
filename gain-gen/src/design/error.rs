//! The one error of the design reader: where a design is wrong, what was found there and what is allowed.
//!
//! Building it from a place in the file is in `document`; the rules that raise it are beside the keys they guard.

/// A design file that was rejected.
///
/// `Display` gives one line, for example
/// `motor.toml:12: cost.q: found a 2x3 matrix, but the plant has 3 states; give a 3x3 symmetric positive
/// semidefinite matrix`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{origin}{}: {}{found}; {allowed}", at(*line), prefix(key))]
pub struct DesignError {
    /// The file, or whatever name the caller gave the text.
    pub origin: String,
    /// Line of the offending entry, counted from 1. A missing key is reported on the line of the table it
    /// belongs to. `None` if the file could not be read at all.
    pub line: Option<usize>,
    /// Dotted key, for example `plant.discrete.a`; empty if the error belongs to no key.
    pub key: String,
    /// What was found, as a clause: `found the number -1`.
    pub found: String,
    /// What is allowed or what to do, as a request: `give a number above 0`.
    pub allowed: String,
}

fn at(line: Option<usize>) -> String {
    line.map(|line| format!(":{line}")).unwrap_or_default()
}

fn prefix(key: &str) -> String {
    if key.is_empty() { String::new() } else { format!("{key}: ") }
}
