//! [`ModeChain`]: what the controller may know of the network, as a Markov chain, and which age each of its modes has.
//!
//! Where packets are independent a mode is an age, thesis Lemma 3.1. Where a channel's quality comes and goes, a mode is
//! an age together with the channel's states in the cycles whose packets have not arrived yet; the controller learns both
//! one cycle late. Forgetting the states again lumps the modes of an age into one.

use super::age_transitions;
use crate::design::{DelayDistribution, MarkovLink};
use nalgebra::{DMatrix, DVector};
use std::collections::{BTreeMap, BTreeSet};

/// Modes that are still solved for; beyond, the recursion would take hours.
const MOST_MODES: usize = 2048;

/// A Markov chain over modes, each with an age `0..=N` (`N`: the buffer is empty).
#[derive(Debug, Clone, PartialEq)]
pub struct ModeChain {
    /// Age of each mode.
    pub ages: Vec<usize>,
    /// For each mode, states of the channel in the last cycles, the newest first: one at least, and one for each packet
    /// newer than the age. Empty where the chain knows no channel.
    pub channels: Vec<Vec<usize>>,
    /// From a row's mode to a column's, per cycle.
    pub transitions: DMatrix<f64>,
}

/// The chain of age and channel has more modes than can be solved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "a channel of {states} states and sequences of {length} inputs make more than {MOST_MODES} modes; shorten the \
     sequences or give the channel fewer states"
)]
pub struct TooManyModes {
    /// States of the channel.
    pub states: usize,
    /// Inputs per sequence.
    pub length: usize,
}

/// Age and channel states.
type Mode = (usize, Vec<usize>);

impl ModeChain {
    /// Modes are ages: packets are independent of each other.
    pub fn independent(link: &DelayDistribution, length: usize) -> Self {
        Self::of_ages(age_transitions(link, length))
    }

    /// Modes are ages with these transitions, `(N+1) x (N+1)`.
    pub fn of_ages(transitions: DMatrix<f64>) -> Self {
        let ages = transitions.nrows();
        Self { ages: (0..ages).collect(), channels: vec![Vec::new(); ages], transitions }
    }

    /// Modes are ages together with the channel's states, known one cycle late.
    ///
    /// # Errors
    /// There are too many of them.
    pub fn with_channel(link: &MarkovLink, length: usize) -> Result<Self, TooManyModes> {
        let too_many = TooManyModes { states: link.states(), length };
        // What was sent before the begin never arrives: after N cycles it no longer counts.
        let mut layer = BTreeSet::from([(length, vec![0; length])]);
        for _ in 0..=length {
            layer = layer.iter().flat_map(|mode| successors(link, length, mode).into_keys()).collect();
            if layer.len() > MOST_MODES {
                return Err(too_many);
            }
        }
        let mut rows: BTreeMap<Mode, BTreeMap<Mode, f64>> = BTreeMap::new();
        let mut open: Vec<Mode> = layer.into_iter().collect();
        while let Some(mode) = open.pop() {
            if rows.contains_key(&mode) {
                continue;
            }
            let row = successors(link, length, &mode);
            open.extend(row.keys().filter(|to| !rows.contains_key(*to)).cloned());
            rows.insert(mode, row);
            if rows.len() > MOST_MODES {
                return Err(too_many);
            }
        }
        let index: BTreeMap<&Mode, usize> = rows.keys().zip(0..).collect();
        let mut transitions = DMatrix::zeros(rows.len(), rows.len());
        for (from, row) in rows.values().enumerate() {
            for (to, probability) in row {
                transitions[(from, index[to])] += probability;
            }
        }
        let (ages, channels) = rows.into_keys().unzip();
        Ok(Self { ages, channels, transitions })
    }

    /// Long-run share of each mode.
    pub fn shares(&self) -> DVector<f64> {
        let modes = self.ages.len();
        // The balance equations, the last one replaced by the sum.
        let mut balance = self.transitions.transpose() - DMatrix::identity(modes, modes);
        balance.row_mut(modes - 1).fill(1.0);
        let mut right = DVector::zeros(modes);
        right[modes - 1] = 1.0;
        let shares = balance.lu().solve(&right).expect("a chain that comes back everywhere has shares");
        shares.map(|share| share.max(0.0))
    }

    /// The chain of ages alone, each with the transitions that its modes have on average.
    ///
    /// The age by itself is no Markov chain where packets depend on each other; this is the one closest to it.
    pub fn lumped(&self) -> Self {
        let length = self.ages.iter().copied().max().unwrap_or(0);
        let shares = self.shares();
        let mut transitions = DMatrix::zeros(length + 1, length + 1);
        let mut weight = vec![0.0; length + 1];
        for from in 0..self.ages.len() {
            weight[self.ages[from]] += shares[from];
            for to in 0..self.ages.len() {
                transitions[(self.ages[from], self.ages[to])] += shares[from] * self.transitions[(from, to)];
            }
        }
        for (age, weight) in weight.iter().enumerate() {
            match *weight > 0.0 {
                true => transitions.row_mut(age).unscale_mut(*weight),
                // An age that does not occur goes on to the next.
                false => transitions[(age, (age + 1).min(length))] = 1.0,
            }
        }
        Self::of_ages(transitions)
    }
}

/// Where a mode goes in one cycle, and with what probability.
fn successors(link: &MarkovLink, length: usize, (age, channel): &Mode) -> BTreeMap<Mode, f64> {
    let mut row = BTreeMap::new();
    for state in 0..link.states() {
        let mut left = link.transition(channel[0], state);
        if left == 0.0 {
            continue;
        }
        // States in which the packets of age 0, 1, .. were sent.
        let mut sent = vec![state];
        sent.extend(channel);
        let mut reach = |age: usize, probability: f64| {
            if probability > 0.0 {
                *row.entry((age, sent[..age.max(1)].to_vec())).or_insert(0.0) += probability;
            }
        };
        for packet in 0..=(*age).min(length - 1) {
            let arrives = arrives_now(link.delays(sent[packet]), packet);
            reach(packet, left * arrives);
            left *= 1.0 - arrives;
        }
        reach((age + 1).min(length), left);
    }
    row
}

/// Probability that a packet of this age arrives now, given that it had not before.
fn arrives_now(delays: Option<&DelayDistribution>, age: usize) -> f64 {
    let Some(delays) = delays else { return 0.0 };
    let before = if age == 0 { 0.0 } else { delays.arrival(age - 1) };
    let open = 1.0 - before;
    if open > 0.0 { (delays.probability(age) / open).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lossy() -> DelayDistribution {
        DelayDistribution::new(vec![0.1, 0.3, 0.0, 0.2]).expect("a distribution")
    }

    #[test]
    fn a_channel_with_one_state_is_the_chain_of_ages() {
        let link =
            MarkovLink::new(vec![vec![1.0]], vec![lossy().probabilities().to_vec()]).expect("a channel");
        for length in 1..6 {
            let chain = ModeChain::with_channel(&link, length).expect("few modes");
            assert_eq!(chain.ages, (0..=length).collect::<Vec<_>>());
            let difference = (&chain.transitions - age_transitions(&lossy(), length)).amax();
            assert!(difference < 1e-15, "N = {length}: {difference}");
        }
    }

    #[test]
    fn a_channel_whose_states_are_alike_lumps_to_the_chain_of_ages() {
        let delays = lossy().probabilities().to_vec();
        let link = MarkovLink::gilbert_elliott(0.1, 0.4, delays.clone(), delays).expect("a channel");
        let chain = ModeChain::with_channel(&link, 4).expect("few modes");
        assert!(chain.ages.len() > 5);
        assert!((chain.lumped().transitions - age_transitions(&lossy(), 4)).amax() < 1e-14);
    }

    #[test]
    fn every_row_is_a_distribution_and_shares_are_stationary() {
        let link =
            MarkovLink::gilbert_elliott(0.05, 0.3, vec![0.7, 0.2], vec![0.0, 0.1, 0.2, 0.3]).expect("one");
        let chain = ModeChain::with_channel(&link, 4).expect("few modes");
        assert!(chain.transitions.row_iter().all(|row| (row.sum() - 1.0).abs() < 1e-14));
        let shares = chain.shares();
        assert!((chain.transitions.tr_mul(&shares) - &shares).amax() < 1e-14);
        let bad: f64 =
            (0..chain.ages.len()).filter(|&mode| chain.channels[mode][0] == 1).map(|mode| shares[mode]).sum();
        assert!((bad - link.shares()[1]).abs() < 1e-13, "{bad}");
    }

    #[test]
    fn too_many_modes_are_refused() {
        let states = 8;
        let transitions = vec![vec![1.0 / 8.0; states]; states];
        let link = MarkovLink::new(transitions, vec![vec![0.5, 0.2, 0.1]; states]).expect("a channel");
        let refused = ModeChain::with_channel(&link, 6);
        assert_eq!(refused, Err(TooManyModes { states, length: 6 }));
    }
}
