//! `ControlSequence`: up to `N` inputs, valid from a tick on.
//!
//! How sequences are chosen is [`crate::controller`]'s business, which of them is played
//! [`crate::actuator`]'s, and how they look as bytes [`crate::wire`]'s.

use crate::{Scalar, Tick};
use heapless::Vec;
use nalgebra::SVector;

/// The inputs `u_{k|k}, u_{k+1|k}, ..` decided at tick `k` for the cycles `k, k+1, ..`, thesis (3.7).
///
/// `N` is the capacity; the length is data. Inputs are in the plant's input units.
#[derive(Debug, Clone, PartialEq)]
pub struct ControlSequence<T: Scalar, const NU: usize, const N: usize> {
    /// The cycle the sequence was made in, and for which its first input is meant.
    pub tick: Tick,
    /// One input a cycle, from `tick` on.
    pub inputs: Vec<SVector<T, NU>, N>,
}

impl<T: Scalar, const NU: usize, const N: usize> ControlSequence<T, NU, N> {
    /// The input meant for `tick`: `None` before the sequence begins and after it has run out.
    pub fn input_at(&self, tick: Tick) -> Option<&SVector<T, NU>> {
        let age = tick.age_of(self.tick)?;
        self.inputs.get(usize::try_from(age).ok()?)
    }

    /// Whether every number in it is finite.
    pub fn is_finite(&self) -> bool {
        self.inputs.iter().all(|input| input.iter().all(|value| value.is_finite()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn three_inputs_from(tick: Tick) -> ControlSequence<f32, 1, 4> {
        ControlSequence { tick, inputs: [1.0, 2.0, 3.0].iter().map(|&u| SVector::from([u])).collect() }
    }

    #[test]
    fn a_sequence_has_an_input_for_each_of_its_cycles_and_for_no_other() {
        let sequence = three_inputs_from(Tick(u32::MAX));
        assert_eq!(sequence.input_at(Tick(u32::MAX - 1)), None);
        assert_eq!(sequence.input_at(Tick(u32::MAX)), Some(&SVector::from([1.0])));
        assert_eq!(sequence.input_at(Tick(1)), Some(&SVector::from([3.0])));
        assert_eq!(sequence.input_at(Tick(2)), None);
    }

    #[test]
    fn one_bad_number_makes_a_sequence_not_finite() {
        let mut sequence = three_inputs_from(Tick(0));
        assert!(sequence.is_finite());
        sequence.inputs[2][0] = f32::NAN;
        assert!(!sequence.is_finite());
    }
}
