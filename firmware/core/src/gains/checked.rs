//! Gains from tables: the one constructor, for constants and for what is loaded.

use super::{Gains, InvalidGains, Tables};
use crate::played::DefaultInput;

impl<'a, T, const NX: usize, const NU: usize> Gains<'a, T, NX, NU> {
    /// Gains for sequences of `length` inputs.
    ///
    /// # Errors
    /// Says which table has the wrong length.
    pub const fn check(
        length: usize,
        default_input: DefaultInput,
        tables: Tables<'a, T>,
    ) -> Result<Self, InvalidGains> {
        match tables.check_lengths(length, default_input, NX, NU) {
            Ok(()) => Ok(Self { length, default_input, tables }),
            Err(error) => Err(error),
        }
    }

    /// Gains for sequences of `length` inputs, from constant tables.
    ///
    /// # Panics
    /// On tables that [`Gains::check`] refuses. Meant for `const` items, where that is a compile error.
    pub const fn new(length: usize, default_input: DefaultInput, tables: Tables<'a, T>) -> Self {
        match tables.check_lengths(length, default_input, NX, NU) {
            Ok(()) => Self { length, default_input, tables },
            Err(error) => panic!("{}", error.message()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checked::{Finite, Probabilities};

    const GOOD: Tables<'static, f32> = Tables {
        lx: Finite::<f32>::new(&[0.0; 4]),
        m: Finite::<f32>::new(&[0.0; 2]),
        arrival: Probabilities::<f32>::new(&[0.5]),
    };

    #[test]
    fn tables_of_wrong_length_are_refused_by_name() {
        let check = |length, tables| Gains::<f32, 2, 1>::check(length, DefaultInput::Zero, tables);
        let three = Finite::<f32>::new(&[0.0; 3]);
        assert!(check(2, GOOD).is_ok());
        assert_eq!(check(0, GOOD), Err(InvalidGains::NoInputs));
        assert_eq!(check(2, Tables { lx: three, ..GOOD }), Err(InvalidGains::StateGainLength));
        assert_eq!(check(2, Tables { m: three, ..GOOD }), Err(InvalidGains::InFlightGainLength));
        let arrival = Probabilities::<f32>::new(&[]);
        assert_eq!(check(2, Tables { arrival, ..GOOD }), Err(InvalidGains::ArrivalLength));
    }

    #[test]
    fn numbers_that_are_no_gains_or_no_probabilities_are_refused() {
        let (zeros, half) = ([0.0f32; 4], [0.5f32]);
        assert!(Tables::check(&zeros, &zeros, &half).is_ok());
        assert_eq!(Tables::check(&[f32::NAN], &zeros, &half), Err(InvalidGains::NotFinite));
        assert_eq!(Tables::check(&zeros, &[f32::INFINITY], &half), Err(InvalidGains::NotFinite));
        assert_eq!(Tables::check(&zeros, &zeros, &[1.5]), Err(InvalidGains::NotAProbability));
        assert_eq!(Tables::check(&zeros, &zeros, &[f32::NAN]), Err(InvalidGains::NotAProbability));
    }

    #[test]
    fn hold_takes_one_more_in_flight_input_than_zero() {
        let tables = Tables { m: Finite::<f32>::new(&[0.0; 4]), ..GOOD };
        assert!(Gains::<f32, 2, 1>::check(2, DefaultInput::Hold, tables).is_ok());
        assert!(Gains::<f32, 2, 1>::check(2, DefaultInput::Zero, tables).is_err());
    }
}
