//! All that may have happened on a link in a few cycles, and what is then known of state and ages: exactly.

use crate::dice::Dice;
use crate::driven::{Link, ages, settings};
use crate::lent;
use crate::plain::Plain;
use slqg::actuator::Applied;
use slqg::estimator::Model;
use slqg::nalgebra::{SMatrix, SVector};
use slqg::{Age, DefaultInput, Scalar, Tick, sequence::ControlSequence};
use std::collections::BTreeMap;

/// Inputs per sequence.
pub(crate) const LENGTH: usize = 3;
pub(crate) const BOTH: [DefaultInput; 2] = [DefaultInput::Zero, DefaultInput::Hold];

pub(crate) type Inputs<T> = [SVector<T, 1>; LENGTH];

/// A random plant on a random link for a few cycles.
#[allow(dead_code)]
pub(crate) struct Scenario<T: Scalar> {
    pub(crate) link: Link<T, 2, 1, 1, LENGTH>,
    delays: Vec<f64>,
    /// What is sent in each cycle.
    pub(crate) sent: Vec<Option<Inputs<T>>>,
    /// What is then applied.
    pub(crate) applied: Vec<Applied<T, 1>>,
    /// What is measured in each cycle, one more than those above.
    pub(crate) outputs: Vec<SVector<T, 1>>,
    /// The state in each of these.
    pub(crate) states: Vec<SVector<T, 2>>,
}

#[allow(dead_code)]
impl<T: Scalar> Scenario<T> {
    pub(crate) fn new(dice: &mut Dice, default_input: DefaultInput, cycles: usize) -> Self {
        let mut number = |size: f64| T::nearest((dice.roll() - 0.5) * 2.0 * size);
        let a = SMatrix::from_fn(|_, _| number(1.2));
        let root = SMatrix::<T, 2, 2>::from_fn(|_, _| number(1.0));
        let model = Model {
            a,
            b: SMatrix::from_fn(|_, _| number(1.0)),
            c: SMatrix::from_fn(|_, _| number(1.0)),
            process_noise: (root * root.transpose() + SMatrix::identity()) * T::nearest(0.1),
            measurement_noise: SMatrix::from_element(T::nearest(0.2)),
            initial_mean: SVector::from_fn(|_, _| number(1.0)),
            initial_covariance: SMatrix::identity(),
        };
        let sent = (0..cycles).map(|_| [(); LENGTH].map(|()| SVector::from([number(4.0)])));
        let sent: Vec<_> = sent.collect::<Vec<_>>();
        let sent = sent.into_iter().map(|inputs| (dice.roll() < 0.85).then_some(inputs)).collect();
        // Some delays never occur.
        let weights = [(); LENGTH + 1].map(|()| (dice.roll() - 0.2).max(0.0) + 1e-3 * dice.roll());
        let total: f64 = weights.iter().sum::<f64>() + dice.roll();
        let delays: Vec<f64> = weights.iter().map(|weight| weight / total).collect();
        let limit = (dice.roll() < 0.3).then_some(2.0);
        let link = Link::new(model, &delays, settings(default_input, limit));
        let mut scenario = Self { link, delays, sent, applied: vec![], outputs: vec![], states: vec![] };
        scenario.happen(dice);
        scenario
    }

    /// The same sequences over another link, to another plant.
    pub(crate) fn on(&mut self, link: Link<T, 2, 1, 1, LENGTH>, delays: &[f64], dice: &mut Dice) {
        self.link = link;
        self.delays = delays.to_vec();
        self.happen(dice);
    }

    fn happen(&mut self, dice: &mut Dice) {
        let came: Vec<_> = self.sent.iter().map(|_| dice.delay(&self.delays)).collect();
        self.applied = self.play(&came);
        self.measure(dice);
    }

    /// What is applied if the sequences are late by `delays`.
    fn play(&self, delays: &[Option<usize>]) -> Vec<Applied<T, 1>> {
        let mut actuator = lent::actuator(self.link.settings, Tick(0), LENGTH);
        let play = |cycle: usize| {
            // Those before have run out.
            let oldest = cycle.saturating_sub(LENGTH);
            for (made, delay) in delays.iter().enumerate().take(cycle + 1).skip(oldest) {
                let inputs = self.sent[made].as_ref().filter(|_| *delay == Some(cycle - made));
                if let Some(inputs) = inputs {
                    // Past ones and those run out are the actuator's to refuse.
                    let _ = actuator.offer(&ControlSequence { tick: Tick(made as u32), inputs });
                }
            }
            actuator.step()
        };
        (0..self.sent.len()).map(play).collect()
    }

    fn measure(&mut self, dice: &mut Dice) {
        let model = &self.link.model;
        // Uniform, of the covariances' diagonal.
        let mut noise = |variance: T| T::nearest((dice.roll() - 0.5) * (12.0 * variance.widen()).sqrt());
        let mut state = model.initial_mean;
        (self.states, self.outputs) = (vec![], vec![]);
        for cycle in 0..=self.applied.len() {
            if let Some(last) = cycle.checked_sub(1) {
                let disturbance = model.process_noise.diagonal().map(&mut noise);
                state = model.a * state + model.b * self.applied[last].input + disturbance;
            }
            self.states.push(state);
            self.outputs.push(model.c * state + model.measurement_noise.diagonal().map(&mut noise));
        }
    }

    /// Every way to play that is possible, with its probability.
    pub(crate) fn ways(&self) -> Vec<(f64, Vec<Applied<T, 1>>)> {
        let lost = 1.0 - self.delays[..LENGTH].iter().sum::<f64>();
        let one: Vec<_> = (0..LENGTH).map(|d| (self.delays[d], Some(d))).chain([(lost, None)]).collect();
        let mut all = vec![(1.0, vec![])];
        for sent in &self.sent {
            let ways = if sent.is_some() { one.as_slice() } else { &[(1.0, None)] };
            let longer = |(before, delays): (f64, Vec<Option<usize>>)| {
                let more = move |(probability, delay): &(f64, Option<usize>)| {
                    (before * probability, [&delays[..], &[*delay]].concat())
                };
                ways.iter().map(more).collect::<Vec<_>>()
            };
            all = all.into_iter().flat_map(longer).filter(|(probability, _)| *probability > 0.0).collect();
        }
        let mut different = BTreeMap::new();
        for (probability, delays) in all {
            let applied = self.play(&delays);
            let key: Vec<u8> = applied.iter().map(|one| one.age.steps().map_or(255, |a| a as u8)).collect();
            different.entry(key).or_insert((0.0, applied)).0 += probability;
        }
        different.into_values().collect()
    }
}

/// What is known after some cycles.
#[allow(dead_code)]
pub(crate) struct Known {
    /// Mean and covariance of the state.
    pub(crate) numbers: Vec<f64>,
    /// Of each age in the last cycle.
    pub(crate) probabilities: Vec<f64>,
    /// Mean of what was applied in it.
    pub(crate) input: f64,
}

#[allow(dead_code)]
impl Scenario<f64> {
    /// What is known in cycle `now >= 1`, given whether the ages before were acknowledged and outputs measured.
    pub(crate) fn known(
        &self,
        ways: &[(f64, Vec<Applied<f64, 1>>)],
        now: usize,
        is_acknowledged: impl Fn(usize) -> bool,
        is_measured: impl Fn(usize) -> bool,
    ) -> Known {
        let agrees = |played: &[Applied<f64, 1>]| {
            (0..now).all(|at| !is_acknowledged(at) || played[at].age == self.applied[at].age)
        };
        let model = &self.link.model;
        let filtered = ways.iter().filter(|(_, played)| agrees(played)).map(|(probability, played)| {
            let mut filter = Plain::new(model);
            let mut log_weight = probability.ln();
            for at in 0..=now {
                if at > 0 {
                    filter.predict(model, played[at - 1].input);
                }
                if is_measured(at) {
                    log_weight += filter.update(model, self.outputs[at]);
                }
            }
            (log_weight, filter, played[now - 1])
        });
        let filtered: Vec<_> = filtered.collect();
        let largest = filtered.iter().map(|(weight, ..)| *weight).fold(f64::NEG_INFINITY, f64::max);
        let weights = filtered.iter().map(|(weight, ..)| (weight - largest).exp());
        let total: f64 = weights.clone().sum();
        let weighed = || weights.clone().map(|weight| weight / total).zip(&filtered);
        let mean = weighed().fold(SVector::zeros(), |sum, (weight, (_, one, _))| sum + one.mean * weight);
        let covariance = weighed().fold(SMatrix::<f64, 2, 2>::zeros(), |sum, (weight, (_, one, _))| {
            let between = one.mean - mean;
            sum + (one.covariance + between * between.transpose()) * weight
        });
        let of = |age: Age| weighed().filter(move |(_, (_, _, last))| last.age == age);
        Known {
            numbers: mean.iter().chain(covariance.iter()).copied().collect(),
            probabilities: ages::<LENGTH>().map(|age| of(age).map(|(weight, _)| weight).sum()).collect(),
            input: weighed().map(|(weight, (_, _, last))| weight * last.input[0]).sum(),
        }
    }
}
