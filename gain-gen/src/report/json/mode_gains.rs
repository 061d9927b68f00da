//! The gains spelled out for every age of the buffer, which grow with the fourth power of the length.

use crate::json::rows;
use crate::solve::Solution;
use serde::ser::{Serialize, SerializeSeq, Serializer};

/// Most numbers that are spelled out unasked: some 200 KB of text.
pub const MOST_MODE_GAINS: usize = 10_000;

/// Which gains per age of the buffer a report's JSON has: `L(i)` over `[x; rho]` for `i = 0..=N`, thesis (3.31).
///
/// No device needs them, and they are `O(N^4)` numbers: all of them follow from `Lx`, `M` and `r`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModeGains {
    /// Those of tables of up to [`MOST_MODE_GAINS`] numbers; in place of larger ones stands null.
    Small,
    /// All of them.
    All,
}

/// The gains, one age after the other: a single one is in memory at a time.
pub(super) struct Spelled<'r>(&'r Solution);

impl<'r> Spelled<'r> {
    pub(super) fn of(solution: &'r Solution, wanted: ModeGains) -> Option<Self> {
        let is_small = solution.law.coupled_table_floats() <= MOST_MODE_GAINS;
        (wanted == ModeGains::All || is_small).then_some(Self(solution))
    }
}

impl Serialize for Spelled<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let ages = self.0.law.length + 1;
        let mut list = serializer.serialize_seq(Some(ages))?;
        (0..ages).try_for_each(|age| list.serialize_element(&rows(&self.0.mode_gain(age))))?;
        list.end()
    }
}
