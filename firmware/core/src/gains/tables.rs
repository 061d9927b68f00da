//! The tables of a control law, and why some are none.

use crate::{DefaultInput, Scalar, arrival};

/// The three tables of a control law, row-major.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tables<'a, T> {
    /// `Lx`, `(N nu) x nx`: what the state contributes to each input of the sequence.
    pub lx: &'a [T],
    /// `M`, `(N nu) x (n_v nu)`: what the expected in-flight inputs contribute.
    pub m: &'a [T],
    /// `r(b, m)`, `N (N-1) / 2` conditional arrival probabilities in the order of [`arrival::table_index`].
    pub arrival: &'a [T],
}

/// Why tables are not gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InvalidGains {
    /// The sequence length is zero.
    NoInputs,
    /// `lx` does not have `N nu nx` entries.
    StateGainLength,
    /// `m` does not have `N nu n_v nu` entries.
    InFlightGainLength,
    /// `arrival` does not have `N (N-1) / 2` entries.
    ArrivalLength,
    /// A gain is not finite.
    NotFinite,
    /// An arrival probability is not within 0..=1.
    NotAProbability,
}

impl core::fmt::Display for InvalidGains {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NoInputs => "the sequence length is zero",
            Self::StateGainLength => "lx must have length x inputs x states entries",
            Self::InFlightGainLength => "m must have length x inputs x in-flight inputs entries",
            Self::ArrivalLength => "arrival must have length x (length - 1) / 2 entries",
            Self::NotFinite => "a gain is not finite",
            Self::NotAProbability => "an arrival probability is not within 0..=1",
        })
    }
}

impl core::error::Error for InvalidGains {}

impl<T> Tables<'_, T> {
    /// Whether each table has the entries that these dimensions ask for.
    pub(crate) const fn check_lengths(
        &self,
        length: usize,
        default_input: DefaultInput,
        states: usize,
        inputs: usize,
    ) -> Result<(), InvalidGains> {
        if length == 0 {
            return Err(InvalidGains::NoInputs);
        }
        // Dimensions that were read from somewhere may be absurd; tables are never that long.
        let rows = length.saturating_mul(inputs);
        if self.lx.len() != rows.saturating_mul(states) {
            return Err(InvalidGains::StateGainLength);
        }
        if self.m.len() != rows.saturating_mul(default_input.in_flight(length).saturating_mul(inputs)) {
            return Err(InvalidGains::InFlightGainLength);
        }
        if self.arrival.len() != arrival::table_len(length) {
            return Err(InvalidGains::ArrivalLength);
        }
        Ok(())
    }
}

impl<T: Scalar> Tables<'_, T> {
    /// Whether the numbers are gains and probabilities, where their type is known at run time only.
    pub(crate) fn check_numbers(&self) -> Result<(), InvalidGains> {
        if !self.lx.iter().chain(self.m).all(|gain| gain.is_finite()) {
            return Err(InvalidGains::NotFinite);
        }
        // NaN is outside.
        if !self.arrival.iter().all(|r| (T::zero()..=T::one()).contains(r)) {
            return Err(InvalidGains::NotAProbability);
        }
        Ok(())
    }
}
