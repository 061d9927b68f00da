//! The tables of a control law, and why some are none.

use crate::{
    Scalar, arrival,
    checked::{Finite, Probabilities},
    played::DefaultInput,
};

/// The three tables of a control law, row-major.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tables<'a, T> {
    /// `Lx`, `(N nu) x nx`: what the state contributes to each input of the sequence.
    pub lx: Finite<'a, T>,
    /// `M`, `(N nu) x (n_v nu)`: what the expected in-flight inputs contribute.
    pub m: Finite<'a, T>,
    /// `r(b, m)`, `N (N-1) / 2` conditional arrival probabilities in the order of [`arrival::table_index`].
    pub arrival: Probabilities<'a, T>,
}

/// Why tables are not gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

impl InvalidGains {
    pub(super) const fn message(self) -> &'static str {
        match self {
            Self::NoInputs => "the sequence length is zero",
            Self::StateGainLength => "lx must have length x inputs x states entries",
            Self::InFlightGainLength => "m must have length x inputs x in-flight inputs entries",
            Self::ArrivalLength => "arrival must have length x (length - 1) / 2 entries",
            Self::NotFinite => "a gain is not finite",
            Self::NotAProbability => "an arrival probability is not within 0..=1",
        }
    }
}

impl core::fmt::Display for InvalidGains {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.message())
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

impl<'a, T: Scalar> Tables<'a, T> {
    /// Tables of these numbers, row-major.
    ///
    /// # Errors
    /// If they are no gains or no probabilities. How many there must be, [`super::Gains::check`] knows.
    pub fn check(lx: &'a [T], m: &'a [T], arrival: &'a [T]) -> Result<Self, InvalidGains> {
        let (lx, m) = Finite::check(lx).zip(Finite::check(m)).ok_or(InvalidGains::NotFinite)?;
        Ok(Self { lx, m, arrival: Probabilities::check(arrival).ok_or(InvalidGains::NotAProbability)? })
    }
}
