//! Placeholder.

/// What the actuator applies when its buffer has run out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DefaultInput {
    /// Zero input, thesis (3.9).
    Zero,
    /// The input applied last, thesis 3.6.1.
    Hold,
}
