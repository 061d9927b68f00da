//! Numbers in tables that were looked at once: at compile time where they are constants, else when they are loaded.
//!
//! Comparisons of a type parameter cannot be constant, so the look is written for each scalar; what is made of the numbers,
//! [`crate::gains`], [`crate::tracking`], [`crate::event`], is written once for all.

use crate::{Scalar, sequence::is_finite};

/// Numbers none of which is infinite or no number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finite<'a, T>(&'a [T]);

/// Numbers within 0..=1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Probabilities<'a, T>(&'a [T]);

/// A number that is not below zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NonNegative<T>(T);

impl<T: Scalar> NonNegative<T> {
    /// The number, if it is not below zero; NaN is none.
    pub fn check(number: T) -> Option<Self> {
        (number >= T::zero()).then_some(Self(number))
    }

    /// The number, or zero.
    pub(crate) fn or_zero(number: T) -> Self {
        Self::check(number).unwrap_or(Self(T::zero()))
    }

    /// The number.
    pub fn number(&self) -> T {
        self.0
    }
}

impl<T> NonNegative<T> {
    /// Where the number is.
    pub(crate) const fn number_ref(&self) -> &T {
        &self.0
    }
}

impl<'a, T: Scalar> Finite<'a, T> {
    /// The numbers, if they are finite.
    // Once in flash, whatever the table.
    #[inline(never)]
    pub fn check(numbers: &'a [T]) -> Option<Self> {
        is_finite(numbers.iter()).then_some(Self(numbers))
    }
}

impl<'a, T: Scalar> Probabilities<'a, T> {
    /// The numbers, if they are probabilities.
    pub fn check(numbers: &'a [T]) -> Option<Self> {
        // NaN is outside.
        numbers.iter().all(|p| (T::zero()..=T::one()).contains(p)).then_some(Self(numbers))
    }
}

impl<'a, T> Finite<'a, T> {
    /// No numbers.
    pub const NONE: Self = Self(&[]);

    /// The numbers.
    pub const fn numbers(&self) -> &'a [T] {
        self.0
    }

    /// How many there are.
    pub const fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Numbers that were checked before, and have not changed.
    pub(crate) const fn checked(numbers: &'a [T]) -> Self {
        Self(numbers)
    }
}

impl<'a, T> Probabilities<'a, T> {
    /// The numbers.
    pub const fn numbers(&self) -> &'a [T] {
        self.0
    }

    /// How many there are.
    pub const fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Numbers that were checked before, and have not changed.
    pub(crate) const fn checked(numbers: &'a [T]) -> Self {
        Self(numbers)
    }
}

macro_rules! constants {
    ($scalar:ty) => {
        impl<'a> Finite<'a, $scalar> {
            /// The numbers of a constant.
            ///
            /// # Panics
            /// If one of them is not finite. Meant for constants, where that is a compile error.
            pub const fn new(numbers: &'a [$scalar]) -> Self {
                let mut i = 0;
                while i < numbers.len() {
                    assert!(numbers[i].is_finite(), "a number is not finite");
                    i += 1;
                }
                Self(numbers)
            }
        }

        impl NonNegative<$scalar> {
            /// A constant.
            ///
            /// # Panics
            /// If it is below zero or no number. Meant for constants, where that is a compile error.
            pub const fn new(number: $scalar) -> Self {
                assert!(number >= 0.0, "a number is below zero");
                Self(number)
            }
        }

        impl<'a> Probabilities<'a, $scalar> {
            /// The numbers of a constant.
            ///
            /// # Panics
            /// If one of them is no probability. Meant for constants, where that is a compile error.
            pub const fn new(numbers: &'a [$scalar]) -> Self {
                let mut i = 0;
                while i < numbers.len() {
                    // NaN is outside.
                    assert!(
                        numbers[i] >= 0.0 && numbers[i] <= 1.0,
                        "an arrival probability is not within 0..=1"
                    );
                    i += 1;
                }
                Self(numbers)
            }
        }
    };
}
constants!(f32);
constants!(f64);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_are_not_finite_or_no_probabilities_are_refused() {
        assert!(Finite::check(&[0.0f32, -1e30]).is_some());
        assert!(Probabilities::check(&[0.0f64, 1.0]).is_some());
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(Finite::check(&[0.0, bad]), None);
            assert_eq!(Probabilities::check(&[0.0, bad]), None);
        }
        assert_eq!(Probabilities::check(&[1.5f32]), None);
        assert_eq!(Probabilities::check(&[-0.5f32]), None);
    }
}
