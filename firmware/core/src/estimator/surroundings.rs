//! The loop as an estimator sees it: what was sent, how it may have arrived, and what was applied then. THEORY 8.
//!
//! How ages move from cycle to cycle is here; what a measurement makes of them is in `step`.

use super::{Merging, Model, Plausibility};
use crate::{
    Scalar, Tick,
    actuator::Settings,
    gains::Gains,
    in_flight::InFlight,
    played::{Age, DefaultInput, Modes},
};
use nalgebra::SVector;

/// What an estimator is told of the loop around it.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    /// The plant.
    pub model: &'a Model<T, NX, NU, NY>,
    /// What was sent.
    pub in_flight: &'a InFlight<'a, T, NU>,
    /// The actuator at the other end.
    pub actuator: &'a Settings<T, NU>,
    /// The law: how long sequences are, and how likely they arrive late.
    pub gains: &'a Gains<'a, T, NX, NU>,
    /// Probability that a sequence arrives in the cycle it was sent in.
    pub arrives_at_once: T,
    /// What is kept apart.
    pub merging: Merging,
    /// What is believed of the measurements.
    pub plausibility: &'a Plausibility<T, NY>,
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Surroundings<'_, T, NX, NU, NY> {
    /// Probability that the sequence made `age` cycles before `tick` arrives in it, given that it had not before.
    fn arrival(&self, tick: Tick, age: usize) -> T {
        if self.in_flight.made_at(tick - age as u32).is_none() {
            T::zero()
        } else if age == 0 {
            self.arrives_at_once
        } else {
            self.gains.arrival(age, 0)
        }
    }

    /// What left the actuator in cycle `tick` if it played `age`, after `before` in the cycle before: that counts where the
    /// buffer is empty and holds, and where inputs may change so much in a cycle only. `None` if no such sequence is remembered.
    // Once in flash, for all the ways to an estimate.
    #[inline(never)]
    pub fn input(&self, tick: Tick, age: Age, before: &SVector<T, NU>) -> Option<SVector<T, NU>> {
        let default_input = self.actuator.default_input;
        let input = self.in_flight.applied_input(default_input, tick, age, before)?;
        Some(self.actuator.leaves_after(before, &input))
    }

    /// What left the actuator in cycle `tick` if it played `age`, where `modes` are believed after it.
    pub fn applied(&self, tick: Tick, age: Age, modes: &Modes<'_, T, NU>) -> Option<SVector<T, NU>> {
        // What was held is the input itself, and what was applied before it not known any more.
        if self.has_rates() { Some(modes.held) } else { self.input(tick, age, &modes.held) }
    }

    /// Whether an input depends on the one before it whatever is played, so that it is remembered.
    pub(super) fn has_rates(&self) -> bool {
        self.actuator.rate().is_some()
    }

    /// The expected input of cycle `tick`, after which `modes` are believed.
    pub(super) fn expected_input(&self, tick: Tick, modes: &Modes<'_, T, NU>) -> SVector<T, NU> {
        if self.merging.is_linear() {
            return modes.held;
        }
        let possible = || {
            let inputs = modes.iter().map(|(age, probability)| (probability, self.applied(tick, age, modes)));
            inputs.filter_map(|(probability, input)| Some((probability, input?)))
        };
        match modes.known() {
            Some(_) => possible().next().map_or_else(SVector::zeros, |(_, input)| input),
            None => possible().fold(SVector::zeros(), |sum, (probability, input)| sum + input * probability),
        }
    }

    /// Calls `each` with every age that may have been played in cycle `tick`, after what is believed `before` it: its
    /// probability, the input, and how likely each age before leads to it.
    ///
    /// An acknowledged age is certain. If it contradicts all that is believed (an actuator that was started again), any
    /// age before may have led to it.
    pub(super) fn for_each_age(
        &self,
        before: &Modes<'_, T, NU>,
        tick: Tick,
        known: Option<Age>,
        mut each: impl FnMut(Age, T, SVector<T, NU>, &dyn Fn(Age) -> T),
    ) {
        let (zero, one) = (T::zero(), T::one());
        let length = self.gains.length();
        let mut none_newer = one;
        for place in 0..=length {
            let age = Age::at(place, length);
            let arrives = if place < length { self.arrival(tick, place) } else { zero };
            let newest = none_newer * arrives;
            let played_on = none_newer;
            none_newer *= one - arrives;
            if known.is_some_and(|known| known != age) {
                continue;
            }
            let leads = |from: Age| {
                let becomes = from.steps().map_or(length, |steps| (steps + 1).min(length));
                match becomes.cmp(&place) {
                    core::cmp::Ordering::Equal => played_on,
                    core::cmp::Ordering::Greater => newest,
                    core::cmp::Ordering::Less => zero,
                }
            };
            let sum = |leads: &dyn Fn(Age) -> T| {
                before.iter().fold(zero, |sum, (from, probability)| sum + probability * leads(from))
            };
            let anyhow = |_: Age| one;
            let total = sum(&leads);
            let leads: &dyn Fn(Age) -> T = if known.is_some() && total <= zero { &anyhow } else { &leads };
            let probability = if known.is_some() { one } else { total };
            if probability > zero {
                let held = if age == Age::Empty || self.has_rates() {
                    self.held(before, tick, leads)
                } else {
                    SVector::zeros()
                };
                if let Some(input) = self.input(tick, age, &held) {
                    each(age, probability, input, leads);
                }
            }
        }
    }

    /// The input of the cycle before `tick` if `from` was played then.
    pub(super) fn last_input(
        &self,
        before: &Modes<'_, T, NU>,
        tick: Tick,
        from: Age,
    ) -> Option<SVector<T, NU>> {
        self.applied(tick - 1, from, before)
    }

    /// What a buffer that is empty in cycle `tick` holds: the input of the cycle before, as the ages that lead there had it.
    fn held(&self, before: &Modes<'_, T, NU>, tick: Tick, leads: &dyn Fn(Age) -> T) -> SVector<T, NU> {
        if self.has_rates() {
            return before.held;
        }
        if self.actuator.default_input == DefaultInput::Zero {
            return SVector::zeros();
        }
        let mut total = T::zero();
        let mut mean = SVector::zeros();
        for (from, probability) in before.iter() {
            let weight = probability * leads(from);
            let last = if weight > T::zero() { self.last_input(before, tick, from) } else { None };
            let Some(last) = last else { continue };
            total += weight;
            // The first comes out as it is, to the bit.
            mean = if total == weight { last } else { mean + (last - mean) * (weight / total) };
        }
        mean
    }
}
