//! Gains from tables: at compile time for one scalar type, at run time for any.

use super::{Gains, InvalidGains, Tables};
use crate::scalar::{all_within_f32, all_within_f64};
use crate::{DefaultInput, Scalar};

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
}

#[cfg(test)]
mod tests {
    use super::*;

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
