//! [`MarkovLink`]: a link whose quality comes and goes, so that what becomes of one packet tells of the next.
//!
//! A channel is in one of a few states and may change it from cycle to cycle; a packet's delay is drawn from the
//! distribution of the state in which it is sent. With two states this is the model of Gilbert (1960) and Elliott (1963)
//! for bursts of losses, here with delays too; with a fixed delay in each state it is a delay that itself is a Markov chain.

use crate::delay::{DelayDistribution, DistributionError};

/// A row of transition probabilities may miss 1 by this much: files carry rounded figures.
const EXCESS: f64 = 1e-9;
/// States a channel may have; the gains that know it grow with their number to the power of the sequence length.
pub const MOST_STATES: usize = 16;

/// A channel with finitely many states, each with a delay distribution of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkovLink {
    /// Row by row: from which state, to which.
    transitions: Vec<Vec<f64>>,
    /// By state; `None` where nothing sent arrives.
    delays: Vec<Option<DelayDistribution>>,
    /// Long-run share of each state.
    shares: Vec<f64>,
    average: DelayDistribution,
}

/// Why figures are no channel.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MarkovError {
    /// Not one row and one distribution for each state, or too many of them.
    #[error("found {rows} rows of transitions for {states} states")]
    Shape {
        /// Rows of the transition matrix.
        rows: usize,
        /// Delay distributions.
        states: usize,
    },
    /// A row of the transition matrix is no distribution.
    #[error("found transitions from state {state} that are no probabilities with a sum of 1 (it is {sum})")]
    Row {
        /// The state, counted from 0.
        state: usize,
        /// Sum of its row.
        sum: f64,
    },
    /// The delays of a state are no distribution.
    #[error("state {state}: {reason}")]
    Delays {
        /// The state, counted from 0.
        state: usize,
        /// What is wrong with them.
        reason: DistributionError,
    },
    /// The chain has states between which there is no way, so that its long-run shares depend on where it begins.
    #[error("found no way from state {state} to some other")]
    FallsApart {
        /// The state, counted from 0.
        state: usize,
    },
    /// No state lets packets arrive.
    #[error("found a link on which no packet ever arrives")]
    NothingArrives,
}

impl MarkovLink {
    /// A channel with the transition probabilities `transitions[from][to]` per cycle and, for each state, the
    /// probabilities of delay 0, 1, .. cycles; what is missing to 1 is loss, and an empty or all-zero list loses all.
    ///
    /// # Errors
    /// Figures that are no probabilities, or a chain that cannot get from every state to every other.
    pub fn new(transitions: Vec<Vec<f64>>, delays: Vec<Vec<f64>>) -> Result<Self, MarkovError> {
        let states = delays.len();
        let is_square = transitions.len() == states && transitions.iter().all(|row| row.len() == states);
        if !is_square || !(1..=MOST_STATES).contains(&states) {
            return Err(MarkovError::Shape { rows: transitions.len(), states });
        }
        for (state, row) in transitions.iter().enumerate() {
            let sum: f64 = row.iter().sum();
            if row.iter().any(|p| !(0.0..=1.0).contains(p)) || (sum - 1.0).abs() > EXCESS {
                return Err(MarkovError::Row { state, sum });
            }
        }
        let delays = delays
            .into_iter()
            .enumerate()
            .map(|(state, probabilities)| match DelayDistribution::new(probabilities) {
                Ok(delays) => Ok(Some(delays)),
                Err(DistributionError::NothingArrives) => Ok(None),
                Err(reason) => Err(MarkovError::Delays { state, reason }),
            })
            .collect::<Result<Vec<_>, _>>()?;
        let transitions: Vec<Vec<f64>> = transitions.iter().map(|row| normalised(row)).collect();
        if let Some(state) = (0..states).find(|&state| !reaches_all(&transitions, state)) {
            return Err(MarkovError::FallsApart { state });
        }
        let shares = long_run_shares(&transitions);
        let longest = delays.iter().flatten().map(|delays| delays.probabilities().len()).max().unwrap_or(0);
        let average = (0..longest).map(|delay| {
            let of_state = |(share, delays): (&f64, &Option<DelayDistribution>)| {
                share * delays.as_ref().map_or(0.0, |delays| delays.probability(delay))
            };
            shares.iter().zip(&delays).map(of_state).sum()
        });
        let average = DelayDistribution::new(average.collect()).map_err(|_| MarkovError::NothingArrives)?;
        Ok(Self { transitions, delays, shares, average })
    }

    /// Two states: `to_bad` and `to_good` are the probabilities of changing into the other per cycle.
    ///
    /// # Errors
    /// As [`MarkovLink::new`]; state 0 is the good one, state 1 the bad one.
    pub fn gilbert_elliott(
        to_bad: f64,
        to_good: f64,
        good: Vec<f64>,
        bad: Vec<f64>,
    ) -> Result<Self, MarkovError> {
        Self::new(vec![vec![1.0 - to_bad, to_bad], vec![to_good, 1.0 - to_good]], vec![good, bad])
    }

    /// Number of channel states.
    pub fn states(&self) -> usize {
        self.delays.len()
    }

    /// Probability per cycle of changing from state `from` to state `to`.
    pub fn transition(&self, from: usize, to: usize) -> f64 {
        self.transitions[from][to]
    }

    /// Probabilities per cycle of changing from state `from` to each state.
    pub(crate) fn transitions_from(&self, from: usize) -> &[f64] {
        &self.transitions[from]
    }

    /// Delays of packets sent in a state; `None` where all are lost.
    pub fn delays(&self, state: usize) -> Option<&DelayDistribution> {
        self.delays[state].as_ref()
    }

    /// Long-run share of each state.
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// Delay distribution of a packet sent at any time: what is left when the order is forgotten.
    pub fn average(&self) -> &DelayDistribution {
        &self.average
    }
}

fn normalised(row: &[f64]) -> Vec<f64> {
    let sum: f64 = row.iter().sum();
    row.iter().map(|probability| probability / sum).collect()
}

fn reaches_all(transitions: &[Vec<f64>], from: usize) -> bool {
    let mut reached = vec![false; transitions.len()];
    let mut open = vec![from];
    while let Some(state) = open.pop() {
        if !std::mem::replace(&mut reached[state], true) {
            open.extend((0..transitions.len()).filter(|&to| transitions[state][to] > 0.0));
        }
    }
    reached.iter().all(|&is| is)
}

/// Stationary distribution by state reduction (Grassmann, Taksar and Heyman 1985): without subtractions, so that rare
/// states come out as accurately as frequent ones.
fn long_run_shares(transitions: &[Vec<f64>]) -> Vec<f64> {
    let states = transitions.len();
    let mut reduced = transitions.to_vec();
    for last in (1..states).rev() {
        let leaving: f64 = reduced[last][..last].iter().sum();
        for from in 0..last {
            reduced[from][last] /= leaving;
            for to in 0..last {
                reduced[from][to] += reduced[from][last] * reduced[last][to];
            }
        }
    }
    let mut shares = vec![1.0; states];
    for state in 1..states {
        shares[state] = (0..state).map(|from| shares[from] * reduced[from][state]).sum();
    }
    normalised(&shares)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_rare_states_are_as_accurate_as_those_of_frequent_ones() {
        let link = MarkovLink::new(
            vec![vec![1.0 - 1e-12, 1e-12, 0.0], vec![0.0, 0.5, 0.5], vec![0.25, 0.0, 0.75]],
            vec![vec![1.0], vec![0.0, 1.0], vec![0.0, 0.0, 1.0]],
        )
        .expect("a channel");
        let shares = link.shares();
        assert!((shares[1] / shares[0] / 2e-12 - 1.0).abs() < 1e-12, "{shares:?}");
        assert!((shares[2] / shares[0] / 4e-12 - 1.0).abs() < 1e-12, "{shares:?}");
    }

    #[test]
    fn figures_that_are_no_channel_are_refused() {
        let channel = |transitions: &[[f64; 2]; 2], delays: [Vec<f64>; 2]| {
            MarkovLink::new(transitions.iter().map(|row| row.to_vec()).collect(), delays.to_vec())
                .unwrap_err()
        };
        let fine = [[0.5, 0.5], [0.5, 0.5]];
        assert_eq!(channel(&fine, [vec![], vec![0.0]]), MarkovError::NothingArrives);
        assert!(matches!(
            channel(&[[0.5, 0.4], [0.5, 0.5]], [vec![1.0], vec![]]),
            MarkovError::Row { state: 0, .. }
        ));
        assert!(matches!(channel(&fine, [vec![1.0], vec![1.5]]), MarkovError::Delays { state: 1, .. }));
        assert_eq!(
            channel(&[[0.5, 0.5], [0.0, 1.0]], [vec![1.0], vec![1.0]]),
            MarkovError::FallsApart { state: 1 }
        );
        assert!(matches!(
            MarkovLink::new(vec![vec![1.0]], vec![]),
            Err(MarkovError::Shape { rows: 1, states: 0 })
        ));
    }
}
