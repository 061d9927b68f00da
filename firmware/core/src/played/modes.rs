//! Probabilities of the age that the actuator played in one cycle.

use super::Age;
use crate::Scalar;
use nalgebra::SVector;

/// How likely each age is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ages<'m, T> {
    /// This one, for certain.
    Certain(Age),
    /// The probabilities of ages `0, 1, ..`, and of the empty buffer last.
    Likely(&'m [T]),
}

/// How likely the actuator played each age in one cycle: `mu` of THEORY 8.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modes<'m, T, const NU: usize> {
    /// How likely each age is.
    pub ages: Ages<'m, T>,
    /// What was applied if the buffer was empty, in input units; a mean if that may be several inputs.
    pub held: SVector<T, NU>,
}

impl<'m, T: Scalar, const NU: usize> Modes<'m, T, NU> {
    /// `age` for certain; `held` is what was applied if that is [`Age::Empty`].
    pub fn certain(age: Age, held: SVector<T, NU>) -> Self {
        Self { ages: Ages::Certain(age), held }
    }

    /// The probability of `age`.
    pub fn probability(&self, age: Age) -> T {
        match self.ages {
            Ages::Certain(certain) => {
                if certain == age {
                    T::one()
                } else {
                    T::zero()
                }
            }
            Ages::Likely(probabilities) => {
                let empty = probabilities.len().saturating_sub(1);
                let place = age.steps().filter(|steps| *steps < empty);
                // Of a sequence that is longer than any there is, nothing can be played.
                let place = if age == Age::Empty { Some(empty) } else { place };
                place.and_then(|place| probabilities.get(place)).copied().unwrap_or_else(T::zero)
            }
        }
    }

    /// Ages that are possible, newest first and the empty buffer last, with their probabilities.
    pub fn iter(&self) -> impl Iterator<Item = (Age, T)> + use<'m, T, NU> {
        let (certain, likely) = match self.ages {
            Ages::Certain(age) => (Some((age, T::one())), &[][..]),
            Ages::Likely(probabilities) => (None, probabilities),
        };
        let length = likely.len().saturating_sub(1);
        let likely = likely.iter().enumerate().filter(|(_, probability)| **probability > T::zero());
        certain
            .into_iter()
            .chain(likely.map(move |(place, probability)| (Age::at(place, length), *probability)))
    }

    /// The age, if only one is possible.
    pub fn known(&self) -> Option<Age> {
        if let Ages::Certain(age) = self.ages {
            return Some(age);
        }
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
        let mean = self.mean_age(length);
        let whole = mean.widen() as usize;
        // Halfway and more counts up. The difference is exact, in the scalar that the device has an adder for.
        let is_up = mean - T::nearest(whole as f64) >= T::nearest(0.5);
        Age::at(whole.saturating_add(is_up.into()), length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HELD: SVector<f32, 1> = SVector::<f32, 1>::new(7.0);
    /// Of sequences of three inputs.
    const ALL: [Age; 4] = [Age::Steps(0), Age::Steps(1), Age::Steps(2), Age::Empty];

    fn likely(probabilities: &[f32]) -> Modes<'_, f32, 1> {
        Modes { ages: Ages::Likely(probabilities), held: HELD }
    }

    #[test]
    fn each_age_has_its_probability_and_the_empty_buffer_the_last() {
        let modes = likely(&[0.5, 0.0, 0.125, 0.375]);
        assert_eq!(ALL.map(|age| modes.probability(age)), [0.5, 0.0, 0.125, 0.375]);
        for beyond in [3, 4, 255] {
            assert_eq!(modes.probability(Age::Steps(beyond)), 0.0, "no sequence is that long");
        }
        assert_eq!(likely(&[]).probability(Age::Empty), 0.0);
        assert_eq!(likely(&[]).iter().count(), 0);
    }

    #[test]
    fn only_ages_that_are_possible_are_told_newest_first() {
        let possible: [_; 2] = [(Age::Steps(1), 0.25), (Age::Empty, 0.75)];
        assert!(likely(&[0.0, 0.25, 0.0, 0.75]).iter().eq(possible));
        assert!(Modes::<f32, 1>::certain(Age::Steps(9), HELD).iter().eq([(Age::Steps(9), 1.0)]));
    }

    #[test]
    fn a_certain_age_has_all_of_the_probability() {
        for certain in ALL {
            let modes = Modes::<f32, 1>::certain(certain, HELD);
            assert_eq!(
                ALL.map(|age| modes.probability(age)),
                ALL.map(|age| f32::from(u8::from(age == certain)))
            );
            assert_eq!((modes.known(), modes.held), (Some(certain), HELD));
        }
    }

    #[test]
    fn an_age_is_known_where_no_other_is_possible() {
        assert_eq!(likely(&[0.0, 1.0, 0.0, 0.0]).known(), Some(Age::Steps(1)));
        assert_eq!(likely(&[0.0, 0.0, 0.0, 1.0]).known(), Some(Age::Empty));
        assert_eq!(likely(&[1e-30, 1.0, 0.0, 0.0]).known(), None);
        assert_eq!(likely(&[0.0; 4]).known(), None, "none is possible");
    }

    #[test]
    fn the_mean_age_counts_the_empty_buffer_as_a_sequence_that_has_run_out() {
        assert_eq!(likely(&[0.25, 0.25, 0.0, 0.5]).mean_age(3), 0.25 + 0.5 * 3.0);
        assert_eq!(Modes::<f32, 1>::certain(Age::Empty, HELD).mean_age(3), 3.0);
    }

    #[test]
    fn the_mean_age_is_rounded_to_the_nearest_and_halves_up() {
        for (probabilities, expected) in [
            ([0.75, 0.25, 0.0, 0.0], Age::Steps(0)),
            ([0.5, 0.5, 0.0, 0.0], Age::Steps(1)),
            ([0.5, 0.0, 0.0, 0.5], Age::Steps(2)),
            ([0.0, 0.0, 0.5, 0.5], Age::Empty),
            ([0.0, 0.0, 0.75, 0.25], Age::Steps(2)),
        ] {
            assert_eq!(likely(&probabilities).rounded(3), expected, "{probabilities:?}");
        }
    }
}
