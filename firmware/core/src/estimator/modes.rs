//! Probabilities of the age that the actuator played in one cycle.

use crate::{Scalar, actuator::Age};
use nalgebra::SVector;

/// How likely the actuator played each age in one cycle: `mu` of THEORY 8, for sequences of up to `N` inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Modes<T: Scalar, const NU: usize, const N: usize> {
    steps: [T; N],
    empty: T,
    /// What was applied if the buffer was empty, in input units; a mean if that may be several inputs.
    held: SVector<T, NU>,
}

impl<T: Scalar, const NU: usize, const N: usize> Modes<T, NU, N> {
    /// No age has any probability yet.
    pub(super) fn none() -> Self {
        Self { steps: [T::zero(); N], empty: T::zero(), held: SVector::zeros() }
    }

    /// `age` for certain; `held` is what was applied if that is [`Age::Empty`].
    pub fn certain(age: Age, held: SVector<T, NU>) -> Self {
        let mut modes = Self { held, ..Self::none() };
        modes.set(age, T::one());
        modes
    }

    /// The probability of `age`.
    pub fn probability(&self, age: Age) -> T {
        match age {
            Age::Steps(steps) => self.steps.get(usize::from(steps)).copied().unwrap_or_else(T::zero),
            Age::Empty => self.empty,
        }
    }

    pub(super) fn set(&mut self, age: Age, probability: T) {
        match age {
            Age::Steps(steps) => {
                if let Some(entry) = self.steps.get_mut(usize::from(steps)) {
                    *entry = probability;
                }
            }
            Age::Empty => self.empty = probability,
        }
    }

    pub(super) fn set_held(&mut self, held: SVector<T, NU>) {
        self.held = held;
    }

    /// What was applied if the buffer was empty, in input units.
    pub fn held(&self) -> &SVector<T, NU> {
        &self.held
    }

    /// Ages that are possible, newest first and the empty buffer last, with their probabilities.
    pub fn iter(&self) -> impl Iterator<Item = (Age, T)> + '_ {
        let steps =
            self.steps.iter().zip(0..=u8::MAX).map(|(probability, steps)| (Age::Steps(steps), *probability));
        let all = steps.chain(core::iter::once((Age::Empty, self.empty)));
        all.filter(|(_, probability)| *probability > T::zero())
    }

    /// The age, if only one is possible.
    pub fn known(&self) -> Option<Age> {
        let mut possible = self.iter();
        let (age, _) = possible.next()?;
        possible.next().is_none().then_some(age)
    }

    /// The mean age in cycles, an empty buffer counting as `length`.
    pub fn mean_age(&self, length: usize) -> T {
        self.iter().fold(T::zero(), |sum, (age, probability)| {
            sum + probability * T::nearest(age.steps().unwrap_or(length) as f64)
        })
    }

    /// The mean age, rounded: thesis (3.43).
    pub fn rounded(&self, length: usize) -> Age {
        // Halfway and more counts up.
        let mean = self.mean_age(length).widen() + 0.5;
        u8::try_from(mean as usize)
            .ok()
            .filter(|steps| usize::from(*steps) < length)
            .map_or(Age::Empty, Age::Steps)
    }

    /// Divides by the sum, if there is any.
    pub(super) fn normalise(&mut self) {
        let sum = self.iter().fold(T::zero(), |sum, (_, probability)| sum + probability);
        if sum > T::zero() {
            self.steps.iter_mut().chain(core::iter::once(&mut self.empty)).for_each(|entry| *entry /= sum);
        }
    }
}
