//! `ControlSequence`: inputs that are valid from a tick on.
//!
//! How sequences are chosen is [`crate::controller`]'s business, which of them is played
//! [`crate::actuator`]'s, and how they look as bytes [`crate::wire`]'s.

use crate::{Scalar, Tick};
use nalgebra::SVector;

/// The inputs `u_{k|k}, u_{k+1|k}, ..` decided at tick `k` for the cycles `k, k+1, ..`, thesis (3.7).
///
/// Inputs are in the plant's input units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlSequence<'s, T: Scalar, const NU: usize> {
    /// The cycle the sequence was made in, and for which its first input is meant.
    pub tick: Tick,
    /// One input a cycle, from `tick` on.
    pub inputs: &'s [SVector<T, NU>],
}

impl<'s, T: Scalar, const NU: usize> ControlSequence<'s, T, NU> {
    /// The input meant for `tick`: `None` before the sequence begins and after it has run out.
    pub fn input_at(&self, tick: Tick) -> Option<&'s SVector<T, NU>> {
        let age = tick.age_of(self.tick)?;
        self.inputs.get(usize::try_from(age).ok()?)
    }

    /// Whether every number in it is finite.
    pub fn is_finite(&self) -> bool {
        all_finite(self.inputs)
    }
}

/// Whether every number of these inputs is finite.
pub(crate) fn all_finite<T: Scalar, const NU: usize>(inputs: &[SVector<T, NU>]) -> bool {
    is_finite(inputs.iter().flatten())
}

/// Whether every one of these numbers is finite.
pub(crate) fn is_finite<'n, T: Scalar>(numbers: impl Iterator<Item = &'n T>) -> bool {
    // A number times zero is zero, unless it is infinite or none: one comparison for all of them.
    numbers.fold(T::zero(), |sum, number| sum + *number * T::zero()) == T::zero()
}

#[cfg(test)]
mod tests {
    use super::*;

    const THREE: [SVector<f32, 1>; 3] =
        [SVector::<f32, 1>::new(1.0), SVector::<f32, 1>::new(2.0), SVector::<f32, 1>::new(3.0)];

    #[test]
    fn a_sequence_has_an_input_for_each_of_its_cycles_and_for_no_other() {
        let sequence = ControlSequence { tick: Tick(u32::MAX), inputs: &THREE };
        assert_eq!(sequence.input_at(Tick(u32::MAX - 1)), None);
        assert_eq!(sequence.input_at(Tick(u32::MAX)), Some(&SVector::from([1.0])));
        assert_eq!(sequence.input_at(Tick(1)), Some(&SVector::from([3.0])));
        assert_eq!(sequence.input_at(Tick(2)), None);
    }

    #[test]
    fn one_bad_number_makes_a_sequence_not_finite() {
        assert!(ControlSequence { tick: Tick(0), inputs: &THREE }.is_finite());
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut inputs = THREE;
            inputs[2][0] = bad;
            assert!(!ControlSequence { tick: Tick(0), inputs: &inputs }.is_finite());
        }
    }
}
