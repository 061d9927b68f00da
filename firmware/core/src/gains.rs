//! `Gains`: the optimal control law as constant data, checked at compile time.
//!
//! The law itself is here too. Where gains come from is [`crate::synthesis`]; what they multiply is
//! [`crate::estimator`]'s state and [`crate::in_flight`]'s expected inputs.

use crate::scalar::{all_within_f32, all_within_f64};
use crate::{DefaultInput, Scalar, arrival};
use heapless::Vec;
use nalgebra::SVector;

/// Steady-state gains `U = Lx xhat + M vbar`, THEORY 3; equal to thesis (3.30) for every mode.
///
/// All tables are row-major. Build them with [`Gains::new`], in a `const` where they are known at compile
/// time: tables of a wrong length then do not compile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains<'a, T, const NX: usize, const NU: usize> {
    length: usize,
    default_input: DefaultInput,
    lx: &'a [T],
    m: &'a [T],
    arrival: &'a [T],
}

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

/// Constructors for one scalar type: floating-point comparisons in `const` need a concrete type.
macro_rules! checked_construction {
    ($scalar:ty, $all_within:path) => {
        impl<'a, const NX: usize, const NU: usize> Gains<'a, $scalar, NX, NU> {
            /// Gains for sequences of `length` inputs, or why the tables are none.
            pub const fn check(
                length: usize,
                default_input: DefaultInput,
                tables: Tables<'a, $scalar>,
            ) -> Result<Self, InvalidGains> {
                if let Err(error) = tables.check_lengths(length, default_input, NX, NU) {
                    return Err(error);
                }
                let Tables { lx, m, arrival } = tables;
                if !$all_within(lx, <$scalar>::MIN, <$scalar>::MAX)
                    || !$all_within(m, <$scalar>::MIN, <$scalar>::MAX)
                {
                    return Err(InvalidGains::NotFinite);
                }
                if !$all_within(arrival, 0.0, 1.0) {
                    return Err(InvalidGains::NotAProbability);
                }
                Ok(Self { length, default_input, lx, m, arrival })
            }

            /// Gains for sequences of `length` inputs, from constant tables.
            ///
            /// # Panics
            /// On tables that [`Gains::check`] refuses. Meant for `const` items, where that is a compile error.
            pub const fn new(
                length: usize,
                default_input: DefaultInput,
                tables: Tables<'a, $scalar>,
            ) -> Self {
                match Self::check(length, default_input, tables) {
                    Ok(gains) => gains,
                    Err(InvalidGains::NoInputs) => panic!("the sequence length is zero"),
                    Err(InvalidGains::StateGainLength) => panic!("lx must have length * NU * NX entries"),
                    Err(InvalidGains::InFlightGainLength) => {
                        panic!("m must have length * NU * in_flight * NU entries")
                    }
                    Err(InvalidGains::ArrivalLength) => {
                        panic!("arrival must have length * (length - 1) / 2 entries")
                    }
                    Err(InvalidGains::NotFinite) => panic!("a gain is not finite"),
                    Err(InvalidGains::NotAProbability) => {
                        panic!("an arrival probability is not within 0..=1")
                    }
                }
            }
        }
    };
}
checked_construction!(f32, all_within_f32);
checked_construction!(f64, all_within_f64);

impl<'a, T: Scalar, const NX: usize, const NU: usize> Gains<'a, T, NX, NU> {
    /// As `check`, for any scalar; comparisons of a type parameter cannot be `const`.
    pub(crate) fn check_any(
        length: usize,
        default_input: DefaultInput,
        tables: Tables<'a, T>,
    ) -> Result<Self, InvalidGains> {
        tables.check_lengths(length, default_input, NX, NU)?;
        tables.check_numbers()?;
        Ok(Self::checked(length, default_input, tables))
    }

    /// Gains from tables that have been checked before, and have not changed.
    pub(crate) const fn checked(length: usize, default_input: DefaultInput, tables: Tables<'a, T>) -> Self {
        let Tables { lx, m, arrival } = tables;
        Self { length, default_input, lx, m, arrival }
    }

    /// Inputs per sequence, `N`.
    pub const fn length(&self) -> usize {
        self.length
    }

    /// What the actuator does when its buffer has run out; the gains are optimal for this choice only.
    pub const fn default_input(&self) -> DefaultInput {
        self.default_input
    }

    /// Expected in-flight inputs the law takes, `n_v`: `N-1` with zero default, `N` with hold.
    pub const fn in_flight(&self) -> usize {
        self.default_input.in_flight(self.length)
    }

    /// `r(b, m)`: probability that a packet of age `b >= 1` arrives by cycle `k+m`, given that it had not by `k-1`.
    pub fn arrival(&self, b: usize, m: usize) -> T {
        self.arrival[arrival::table_index(self.length, b, m)]
    }

    /// `r(b, 0), r(b, 1), .. r(b, N-1-b)` for `b = 1, 2, .. N-1`, row after row: each until the packet's last input is due.
    pub const fn arrival_table(&self) -> &'a [T] {
        self.arrival
    }

    /// The control sequence `U = Lx xhat + M vbar`, one entry per cycle from the current one on.
    ///
    /// `posterior_mean`: estimate of the state given all that has arrived. `expected`: `vbar`, `n_v` inputs.
    /// Holds the first `N` of `Gains::length` inputs if the capacity is smaller, which
    /// [`crate::controller::Controller::new`] rules out.
    pub fn sequence<const N: usize>(
        &self,
        posterior_mean: &SVector<T, NX>,
        expected: &[SVector<T, NU>],
    ) -> Vec<SVector<T, NU>, N> {
        // A controller's capacity is its gains' length, as a rule. Lengths that are constants then halve the work: no loop
        // counts, and `expected` stays in registers.
        let count = expected.len();
        match self.default_input {
            DefaultInput::Zero if self.length == N && count + 1 == N => {
                self.times(N, N - 1, posterior_mean, expected)
            }
            DefaultInput::Hold if self.length == N && count == N => {
                self.times(N, N, posterior_mean, expected)
            }
            _ => self.times(self.length.min(N), self.in_flight(), posterior_mean, expected),
        }
    }

    /// `length` inputs of the law for `in_flight` expected ones.
    #[inline(always)]
    fn times<const N: usize>(
        &self,
        length: usize,
        in_flight: usize,
        posterior_mean: &SVector<T, NX>,
        expected: &[SVector<T, NU>],
    ) -> Vec<SVector<T, NU>, N> {
        let (rows, columns) = (length * NU, in_flight * NU);
        // Checked tables are as long.
        let tables = self.lx.get(..rows * NX).zip(self.m.get(..rows * columns));
        let Some((of_state, of_sent)) = tables else { return Vec::new() };
        let mut of_state = of_state.chunks_exact(NX);
        // Without anything in flight there is no table to cut into rows.
        let mut of_sent = of_sent.chunks_exact(columns.max(1));
        let mut sequence = [SVector::zeros(); N];
        for input in sequence.iter_mut().take(length) {
            *input = SVector::from_fn(|_, _| {
                let from_state =
                    of_state.next().map_or_else(T::zero, |row| add_dot(T::zero(), row, posterior_mean));
                let from_sent = of_sent.next().map_or_else(T::zero, |row| {
                    row.chunks_exact(NU)
                        .zip(expected)
                        .fold(T::zero(), |sum, (gains, input)| add_dot(sum, gains, input))
                });
                from_state + from_sent
            });
        }
        let mut sequence = Vec::from(sequence);
        sequence.truncate(length);
        sequence
    }
}

/// Sum of products in index order: the order is part of the promise that host and target agree to the bit.
pub(crate) fn dot<'v, T: Scalar>(row: &[T], vector: impl Iterator<Item = &'v T>) -> T {
    row.iter().zip(vector).fold(T::zero(), |sum, (gain, value)| sum + *gain * *value)
}

/// `sum + row . vector`, in index order likewise.
pub(crate) fn add_dot<T: Scalar, const D: usize>(sum: T, row: &[T], vector: &SVector<T, D>) -> T {
    row.iter().zip(vector.iter()).fold(sum, |sum, (gain, value)| sum + *gain * *value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Gains<'static, f64, 2, 1> = Gains::<f64, 2, 1>::new(
        2,
        DefaultInput::Zero,
        Tables { lx: &[1.0, 2.0, 3.0, 4.0], m: &[10.0, 20.0], arrival: &[0.5] },
    );

    #[test]
    fn the_law_is_state_gain_plus_in_flight_gain() {
        let sequence: Vec<_, 4> = LAW.sequence(&SVector::from([1.0, -1.0]), &[SVector::from([0.5])]);
        assert_eq!(sequence.as_slice(), &[SVector::from([4.0]), SVector::from([9.0])]);
    }

    #[test]
    fn tables_of_wrong_length_are_refused_by_name() {
        let good = Tables { lx: &[0.0f32; 4], m: &[0.0f32; 2], arrival: &[0.5f32] };
        let check = |length, tables| Gains::<f32, 2, 1>::check(length, DefaultInput::Zero, tables);
        assert!(check(2, good).is_ok());
        assert_eq!(check(0, good), Err(InvalidGains::NoInputs));
        assert_eq!(check(2, Tables { lx: &[0.0; 3], ..good }), Err(InvalidGains::StateGainLength));
        assert_eq!(check(2, Tables { m: &[0.0; 3], ..good }), Err(InvalidGains::InFlightGainLength));
        assert_eq!(check(2, Tables { arrival: &[], ..good }), Err(InvalidGains::ArrivalLength));
    }

    #[test]
    fn numbers_that_are_no_gains_or_no_probabilities_are_refused() {
        let good = Tables { lx: &[0.0f32; 4], m: &[0.0f32; 2], arrival: &[0.5f32] };
        let check = |tables| Gains::<f32, 2, 1>::check(2, DefaultInput::Zero, tables);
        assert_eq!(check(Tables { lx: &[0.0, f32::NAN, 0.0, 0.0], ..good }), Err(InvalidGains::NotFinite));
        assert_eq!(check(Tables { m: &[0.0, f32::INFINITY], ..good }), Err(InvalidGains::NotFinite));
        assert_eq!(check(Tables { arrival: &[1.5], ..good }), Err(InvalidGains::NotAProbability));
        assert_eq!(check(Tables { arrival: &[f32::NAN], ..good }), Err(InvalidGains::NotAProbability));
    }

    #[test]
    fn hold_takes_one_more_in_flight_input_than_zero() {
        let tables = Tables { lx: &[0.0f32; 4], m: &[0.0f32; 4], arrival: &[0.5f32] };
        assert!(Gains::<f32, 2, 1>::check(2, DefaultInput::Hold, tables).is_ok());
        assert!(Gains::<f32, 2, 1>::check(2, DefaultInput::Zero, tables).is_err());
    }
}
