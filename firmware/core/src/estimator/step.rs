//! One cycle of the filter: hypotheses about the age apart, predicted, measured and merged. THEORY 8.

use super::{
    Estimate, Merging, Surroundings,
    estimate::{Innovation, Merged, Update, absurd},
    memory::{Belief, Room},
    plausibility::{Heard as Measured, Standing},
    prepared::Prepared,
};
use crate::{
    Scalar, Tick,
    played::{Age, DefaultInput},
};
use nalgebra::{SMatrix, SVector};

/// What is known of one cycle: its tick, the age that was acknowledged, and the next one's measurement.
type Heard<'o, T, const NY: usize> = (Tick, Option<Age>, Option<&'o SVector<T, NY>>);

impl<'b, T: Scalar, const NX: usize, const NU: usize> Belief<'b, T, NX, NU> {
    /// Possible ages with their probabilities and estimates.
    fn iter(&self) -> impl Iterator<Item = (Age, T, &'b Estimate<T, NX>)> + use<'b, T, NX, NU> {
        let estimates = self.estimates;
        let common = estimates.len() == 1;
        self.modes.iter().enumerate().filter_map(move |(place, (age, probability))| {
            Some((age, probability, estimates.get(if common { 0 } else { place })?))
        })
    }

    /// The estimate, if there is one for all ages.
    pub(super) fn single(&self) -> Option<&'b Estimate<T, NX>> {
        match self.estimates {
            [single] => Some(single),
            _ => None,
        }
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

/// One cycle of the filter, with all that does not change from cycle to cycle.
pub(super) struct Step<'s, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    pub(super) around: &'s Surroundings<'s, T, NX, NU, NY>,
    pub(super) prepared: &'s Prepared<T, NX, NY>,
    /// How measurements fitted up to the cycle before.
    pub(super) standing: Standing<NY>,
    /// What became of this cycle's.
    measured: Measured,
    /// Whether an estimate of this cycle was of no use any more, and began anew.
    pub(super) begins_anew: bool,
}

impl<'s, T: Scalar, const NX: usize, const NU: usize, const NY: usize> Step<'s, T, NX, NU, NY> {
    /// Of the cycle before which `standing` was how measurements had fitted.
    pub(super) fn new(
        around: &'s Surroundings<'s, T, NX, NU, NY>,
        prepared: &'s Prepared<T, NX, NY>,
        standing: Standing<NY>,
    ) -> Self {
        Self { around, prepared, standing, measured: Measured::NOTHING, begins_anew: false }
    }

    /// How measurements have fitted, with this cycle's.
    pub(super) fn standing_after(&self) -> Standing<NY> {
        self.standing.after(&self.measured)
    }

    /// Writes into `room` what is believed in the first cycle of all: nothing was played before it.
    pub(super) fn first(&mut self, output: Option<&SVector<T, NY>>, room: &mut Room<'_, T, NX, NU>) {
        let model = self.around.model;
        if let Some(posterior) = room.certain(Age::Empty, SVector::zeros()) {
            self.corrected(|prior| *prior = Estimate::initial(model), output, posterior);
        }
    }

    /// Writes into `room` what is believed in the cycle after `tick`, of which `known` was acknowledged, given the measurement
    /// `output`.
    pub(super) fn step(
        &mut self,
        before: &Belief<'_, T, NX, NU>,
        tick: Tick,
        known: Option<Age>,
        output: Option<&SVector<T, NY>>,
        room: &mut Room<'_, T, NX, NU>,
    ) {
        let single = before.single();
        let certain = known.and_then(|age| Some((age, single?, self.certain_input(before, tick, age)?)));
        if let Some((age, estimate, input)) = certain {
            let held = if age == Age::Empty || self.around.has_rates() { input } else { SVector::zeros() };
            if let Some(posterior) = room.certain(age, held) {
                self.filtered(estimate, (&input, None), output, posterior);
            }
            return;
        }
        self.step_uncertain(before, (tick, known, output), room);
    }

    /// The same where it takes more to know the input, or where that remains unknown.
    // What this needs of the stack, and all below it, the shortest way does without.
    #[inline(never)]
    fn step_uncertain(
        &mut self,
        before: &Belief<'_, T, NX, NU>,
        (tick, known, output): Heard<'_, T, NY>,
        room: &mut Room<'_, T, NX, NU>,
    ) {
        // Then nothing is acknowledged, and the room has the mean input already.
        let is_told = self.around.merging.is_linear();
        let is_found = match before.single() {
            _ if is_told => false,
            Some(estimate) if self.around.merging == Merging::Single || known.is_some() => {
                self.step_in_one(before, estimate, (tick, known, output), room)
            }
            _ => self.step_apart(before, (tick, known, output), room),
        };
        if !is_found {
            // Or no input is remembered that could have been applied: the age is lost, the state not.
            let input = if is_told { *room.held } else { SVector::zeros() };
            let estimate = before.merged().unwrap_or_else(|| self.anew());
            if let Some(posterior) = room.certain(Age::Empty, input) {
                self.filtered(&estimate, (&input, None), output, posterior);
            }
        }
    }

    /// The input of cycle `tick`, in which `age` was played for certain, where that is all it takes to know it: the Kalman
    /// filter's case, and the shortest way to it.
    fn certain_input(&self, before: &Belief<'_, T, NX, NU>, tick: Tick, age: Age) -> Option<SVector<T, NU>> {
        if self.around.has_rates() {
            return self.around.input(tick, age, &before.modes.held);
        }
        if age != Age::Empty || self.around.actuator.default_input == DefaultInput::Zero {
            return self.around.input(tick, age, &SVector::zeros());
        }
        let held = self.around.last_input(&before.modes, tick, before.modes.known()?)?;
        self.around.input(tick, age, &held)
    }

    /// All ages in one estimate. Returns whether there is any.
    #[inline(never)]
    fn step_in_one(
        &mut self,
        before: &Belief<'_, T, NX, NU>,
        estimate: &Estimate<T, NX>,
        (tick, known, output): Heard<'_, T, NY>,
        room: &mut Room<'_, T, NX, NU>,
    ) -> bool {
        room.ages.fill(T::zero());
        *room.held = SVector::zeros();
        let mut total = T::zero();
        let mut mean = SVector::zeros();
        let mut spread: Option<SMatrix<T, NU, NU>> = None;
        self.around.for_each_age(&before.modes, tick, known, |age, probability, input, _| {
            room.set(age, probability);
            if age == Age::Empty {
                *room.held = input;
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
        if total <= T::zero() {
            return false;
        }
        if self.around.has_rates() {
            *room.held = mean;
        }
        room.put_ages();
        if let Some(posterior) = room.single() {
            self.filtered(estimate, (&mean, spread.as_ref()), output, posterior);
        }
        true
    }

    /// One estimate for each age. Returns whether there is any.
    #[inline(never)]
    fn step_apart(
        &mut self,
        before: &Belief<'_, T, NX, NU>,
        (tick, known, output): Heard<'_, T, NY>,
        room: &mut Room<'_, T, NX, NU>,
    ) -> bool {
        // Logarithms, for now.
        let impossible = -T::nearest(f64::INFINITY);
        room.ages.fill(impossible);
        *room.held = SVector::zeros();
        let mut largest: Option<T> = None;
        let mut count = 0;
        let around = self.around;
        around.for_each_age(&before.modes, tick, known, |age, _, input, leads| {
            if age == Age::Empty {
                *room.held = input;
            }
            let mut merged = Merged::none();
            for (from, probability, estimate) in before.iter() {
                let weight = probability * leads(from);
                if weight <= T::zero() {
                    continue;
                }
                if around.merging == Merging::Gpb2 {
                    // What is held is not the same after every age.
                    let empty =
                        if age == Age::Empty { around.last_input(&before.modes, tick, from) } else { None };
                    let own = empty.and_then(|last| around.input(tick, age, &last)).unwrap_or(input);
                    let mut posterior = Estimate::EMPTY;
                    let log_likelihood = self.weighed(estimate, &own, output, &mut posterior);
                    merged.absorb(weight.logarithm() + log_likelihood, &posterior);
                } else {
                    merged.absorb(weight.logarithm(), estimate);
                }
            }
            let mut log_weight = merged.log_weight();
            let Some(estimate) = merged.into_estimate() else { return };
            // Where fewer are kept than there are ages, the oldest are forgotten.
            let Some(place) = room.estimates.get_mut(count) else { return };
            if around.merging == Merging::Gpb2 {
                *place = estimate;
            } else {
                log_weight += self.weighed(&estimate, &input, output, place);
            }
            room.set(age, log_weight);
            count += 1;
            largest = Some(largest.map_or(log_weight, |largest| largest.max(log_weight)));
        });
        let Some(largest) = largest else { return false };
        room.weigh(largest);
        true
    }

    /// Writes into `posterior` the `estimate` one cycle on, with the measurement in it. Returns how well that fits: the logarithm
    /// of its likelihood. What cannot be used fits all alike.
    fn weighed(
        &mut self,
        estimate: &Estimate<T, NX>,
        input: &SVector<T, NU>,
        output: Option<&SVector<T, NY>>,
        posterior: &mut Estimate<T, NX>,
    ) -> T {
        let innovation = self.filtered(estimate, (input, None), output, posterior);
        innovation.map_or_else(T::zero, |innovation| innovation.log_likelihood(self.gate()))
    }

    /// Writes into `posterior` the `estimate` one cycle on, in which an input is applied that is known with a covariance or for
    /// certain, with the measurement in it. Returns the measurement's innovation.
    fn filtered(
        &mut self,
        estimate: &Estimate<T, NX>,
        input: (&SVector<T, NU>, Option<&SMatrix<T, NU, NU>>),
        output: Option<&SVector<T, NY>>,
        posterior: &mut Estimate<T, NX>,
    ) -> Option<Innovation<T, NY>> {
        let (model, prepared) = (self.around.model, self.prepared);
        self.corrected(|prior| prior.predict(estimate, model, prepared, input), output, posterior)
    }

    /// Writes into `posterior` the estimate that `prior` writes, with the measurement in it; one that cannot be used changes
    /// nothing. An estimate that is of no use begins anew before.
    fn corrected(
        &mut self,
        prior: impl Fn(&mut Estimate<T, NX>),
        output: Option<&SVector<T, NY>>,
        posterior: &mut Estimate<T, NX>,
    ) -> Option<Innovation<T, NY>> {
        let (prepared, gate) = (self.prepared, self.gate());
        prior(posterior);
        if let Some(output) = output {
            let mut said = Innovation::NOTHING;
            let mut update = posterior.update(prepared, output, gate, &mut said);
            // What it was before the measurement, once more: rare enough that no copy is worth keeping.
            while update == Update::Rejects {
                prior(posterior);
                update = posterior.update(prepared, output, gate, &mut said);
            }
            if update == Update::Taken && prepared.bears(said.variances()) {
                return Some(self.heard(said, output, posterior));
            }
            prior(posterior);
        }
        self.corrected_if_of_use(output, posterior)
    }

    /// Takes the measurement into `posterior` if it can be used; an estimate that is of no use begins anew before.
    #[inline(never)]
    fn corrected_if_of_use(
        &mut self,
        output: Option<&SVector<T, NY>>,
        posterior: &mut Estimate<T, NX>,
    ) -> Option<Innovation<T, NY>> {
        let mut gate = self.gate();
        if !self.prepared.is_of_use(posterior) {
            *posterior = self.anew();
            // Of an estimate that knows nothing nothing has to be expected.
            gate = ungated();
        }
        let output = output?;
        let prior = posterior.clone();
        let said = posterior.updated(&prior, self.prepared, output, gate)?;
        Some(self.heard(said, output, posterior))
    }

    /// Takes note of what has become of the measurement that `posterior` has taken in, and draws the conclusions.
    fn heard(
        &mut self,
        said: Innovation<T, NY>,
        output: &SVector<T, NY>,
        posterior: &mut Estimate<T, NX>,
    ) -> Innovation<T, NY> {
        self.measured.with(&said.heard);
        if said.heard.rejects_none() { said } else { self.doubted(said, output, posterior) }
    }

    /// After a measurement of which something was not believed the estimate is wider, or, where nothing was for too long, anew.
    #[cold]
    #[inline(never)]
    fn doubted(
        &mut self,
        said: Innovation<T, NY>,
        output: &SVector<T, NY>,
        posterior: &mut Estimate<T, NX>,
    ) -> Innovation<T, NY> {
        let doubt_after = self.around.plausibility.doubt_after;
        if said.heard.believes_none() && self.standing.doubts(&said.heard, doubt_after) {
            let mut anew = Estimate::EMPTY;
            let told = anew.updated(self.prepared.joining(), self.prepared, output, absurd());
            if let Some(told) = told.filter(|told| !told.heard.believes_none()) {
                *posterior = anew;
                self.begins_anew = true;
                self.measured.with(&told.heard);
                return told;
            }
        }
        if said.widening > T::zero() {
            posterior.widen(said.widening);
        }
        said
    }

    /// Squared innovations up to this many times their variance are believed.
    fn gate(&self) -> T {
        self.around.plausibility.gate.unwrap_or_else(ungated)
    }

    fn anew(&mut self) -> Estimate<T, NX> {
        self.begins_anew = true;
        self.prepared.joining().clone()
    }
}

/// Everything is believed.
fn ungated<T: Scalar>() -> T {
    T::nearest(f64::INFINITY)
}
