//! One cycle of the filter: hypotheses about the age apart, predicted, measured and merged. THEORY 8.

use super::estimate::Merged;
use super::{Estimate, Merging, Modes, Surroundings};
use crate::{DefaultInput, Scalar, Tick, actuator::Age};
use heapless::Vec;
use nalgebra::{SMatrix, SVector};

/// What is believed in one cycle, given all measurements up to it.
#[derive(Debug, Clone)]
pub(super) struct Belief<T: Scalar, const NX: usize, const NU: usize, const N: usize, const E: usize> {
    /// The age played in the cycle before.
    pub(super) modes: Modes<T, NU, N>,
    /// One for each possible age, in the order of [`Modes::iter`]; or a single one for all of them.
    pub(super) estimates: Vec<Estimate<T, NX>, E>,
}

impl<T: Scalar, const NX: usize, const NU: usize, const N: usize, const E: usize> Belief<T, NX, NU, N, E> {
    /// Of one estimate that does not depend on the age.
    pub(super) fn of(modes: Modes<T, NU, N>, estimate: Estimate<T, NX>) -> Self {
        let mut estimates = Vec::new();
        // There is room: E >= 1.
        let _ = estimates.push(estimate);
        Self { modes, estimates }
    }

    /// Possible ages with their probabilities and estimates.
    fn iter(&self) -> impl Iterator<Item = (Age, T, &Estimate<T, NX>)> {
        let common = self.estimates.len() == 1;
        self.modes.iter().enumerate().filter_map(move |(place, (age, probability))| {
            Some((age, probability, self.estimates.get(if common { 0 } else { place })?))
        })
    }

    /// The estimate, if there is one for all ages.
    pub(super) fn single(&self) -> Option<&Estimate<T, NX>> {
        self.estimates.first().filter(|_| self.estimates.len() == 1)
    }

    /// All of it as one estimate.
    pub(super) fn merged(&self) -> Option<Estimate<T, NX>> {
        if let Some(single) = self.single() {
            return Some(single.clone());
        }
        let mut merged = Merged::none();
        self.iter().for_each(|(_, probability, estimate)| merged.absorb(probability.logarithm(), estimate));
        merged.into_estimate()
    }
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize, const N: usize, const H: usize>
    Surroundings<'_, T, NX, NU, NY, N, H>
{
    /// What is believed in the cycle after `tick`, of which `known` was acknowledged, given the measurement `output`.
    pub(super) fn step<const E: usize>(
        &self,
        before: &Belief<T, NX, NU, N, E>,
        tick: Tick,
        known: Option<Age>,
        output: Option<&SVector<T, NY>>,
    ) -> Belief<T, NX, NU, N, E> {
        let one_estimate = before.estimates.len() == 1;
        let certain = known
            .filter(|_| one_estimate)
            .and_then(|age| Some((age, self.certain_input(before, tick, age)?)));
        if let (Some((age, input)), Some(estimate)) = (certain, before.estimates.first()) {
            let held = if age == Age::Empty { input } else { SVector::zeros() };
            let predicted = estimate.predict(self.model, &input, None);
            return Belief::of(Modes::certain(age, held), self.corrected(predicted, output));
        }
        let found = if one_estimate && (self.merging == Merging::Single || known.is_some()) {
            self.step_in_one(before, tick, known, output)
        } else {
            self.step_apart(before, tick, known, output)
        };
        // No input is remembered that could have been applied: the age is lost, the state not.
        found.unwrap_or_else(|| {
            let estimate = before.merged().unwrap_or_else(|| Estimate::initial(self.model));
            let modes = Modes::certain(Age::Empty, SVector::zeros());
            Belief::of(modes, self.corrected(estimate.predict(self.model, &SVector::zeros(), None), output))
        })
    }

    /// The input of cycle `tick`, in which `age` was played for certain, where that is all it takes to know it: the Kalman
    /// filter's case, and the shortest way to it.
    fn certain_input<const E: usize>(
        &self,
        before: &Belief<T, NX, NU, N, E>,
        tick: Tick,
        age: Age,
    ) -> Option<SVector<T, NU>> {
        if age != Age::Empty || self.actuator.default_input == DefaultInput::Zero {
            return self.input(tick, age, &SVector::zeros());
        }
        let held = self.last_input(&before.modes, tick, before.modes.known()?)?;
        self.input(tick, age, &held)
    }

    /// All ages in one estimate.
    fn step_in_one<const E: usize>(
        &self,
        before: &Belief<T, NX, NU, N, E>,
        tick: Tick,
        known: Option<Age>,
        output: Option<&SVector<T, NY>>,
    ) -> Option<Belief<T, NX, NU, N, E>> {
        let mut modes = Modes::none();
        let mut total = T::zero();
        let mut mean = SVector::zeros();
        let mut spread: Option<SMatrix<T, NU, NU>> = None;
        self.for_each_age(&before.modes, tick, known, |age, probability, input, _| {
            modes.set(age, probability);
            if age == Age::Empty {
                modes.set_held(input);
            }
            if total > T::zero() {
                let between = input - mean;
                let share = probability / (total + probability);
                let sum = spread.unwrap_or_else(SMatrix::zeros) * (T::one() - share);
                spread = Some(sum + between * between.transpose() * (share * (T::one() - share)));
                mean += between * share;
            } else {
                mean = input;
            }
            total += probability;
        });
        if spread.is_some() {
            modes.normalise();
        } else {
            // One age only: certain, whatever rounding makes of its probability.
            let age = modes.known()?;
            modes.set(age, T::one());
        }
        let predicted = before.estimates.first()?.predict(self.model, &mean, spread.as_ref());
        Some(Belief::of(modes, self.corrected(predicted, output)))
    }

    /// One estimate for each age.
    fn step_apart<const E: usize>(
        &self,
        before: &Belief<T, NX, NU, N, E>,
        tick: Tick,
        known: Option<Age>,
        output: Option<&SVector<T, NY>>,
    ) -> Option<Belief<T, NX, NU, N, E>> {
        let mut hypotheses: Vec<(Age, T, Estimate<T, NX>), E> = Vec::new();
        let mut held = SVector::zeros();
        self.for_each_age(&before.modes, tick, known, |age, _, input, leads| {
            if age == Age::Empty {
                held = input;
            }
            let mut merged = Merged::none();
            for (from, probability, estimate) in before.iter() {
                let weight = probability * leads(from);
                if weight <= T::zero() {
                    continue;
                }
                if self.merging == Merging::Gpb2 {
                    // What is held is not the same after every age.
                    let empty =
                        if age == Age::Empty { self.last_input(&before.modes, tick, from) } else { None };
                    let own = empty.and_then(|last| self.input(tick, age, &last)).unwrap_or(input);
                    let predicted = estimate.predict(self.model, &own, None);
                    let (posterior, log_likelihood) = self.weighed(predicted, output);
                    merged.absorb(weight.logarithm() + log_likelihood, &posterior);
                } else {
                    merged.absorb(weight.logarithm(), estimate);
                }
            }
            let log_weight = merged.log_weight();
            let Some(estimate) = merged.into_estimate() else { return };
            let hypothesis = if self.merging == Merging::Gpb2 {
                (age, log_weight, estimate)
            } else {
                let (posterior, log_likelihood) =
                    self.weighed(estimate.predict(self.model, &input, None), output);
                (age, log_weight + log_likelihood, posterior)
            };
            // There is room for every age.
            let _ = hypotheses.push(hypothesis);
        });
        let largest = hypotheses.iter().map(|(_, log_weight, _)| *log_weight).reduce(|a, b| a.max(b))?;
        let mut modes = Modes::none();
        for (age, log_weight, _) in &hypotheses {
            modes.set(*age, (*log_weight - largest).exponential());
        }
        modes.normalise();
        modes.set_held(held);
        let possible = hypotheses.into_iter().filter(|(age, _, _)| modes.probability(*age) > T::zero());
        let estimates = possible.map(|(_, _, estimate)| estimate).collect();
        Some(Belief { modes, estimates })
    }

    /// The estimate with the measurement in it; one that cannot be used changes nothing.
    pub(super) fn corrected(
        &self,
        predicted: Estimate<T, NX>,
        output: Option<&SVector<T, NY>>,
    ) -> Estimate<T, NX> {
        match output.and_then(|output| predicted.update(self.model, output)) {
            Some((posterior, _)) => posterior,
            None => predicted,
        }
    }

    /// The same, and how well the measurement fits: the logarithm of its likelihood. What cannot be used fits all alike.
    fn weighed(&self, predicted: Estimate<T, NX>, output: Option<&SVector<T, NY>>) -> (Estimate<T, NX>, T) {
        match output.and_then(|output| predicted.update(self.model, output)) {
            Some((posterior, innovation)) => (posterior, innovation.log_likelihood()),
            None => (predicted, T::zero()),
        }
    }
}
