//! [`ChannelLaw`]: the law over a channel that comes and goes, in the form the device computes.
//!
//! Given the states in which old packets were sent, what becomes of them is independent of what becomes of new ones, as it
//! is where packets are independent (THEORY 3). So the law again is `U = Lx xhat + M vbar`, with one `(Lx, M)` for each
//! state of the channel in the cycle before, and `vbar` from arrival probabilities that differ from packet to packet:
//! `O(S N^2)` numbers where the coupled recursion has a gain for each of `O(S^N)` modes.

use super::{
    LoopProblem, ModeChain,
    law::{Law, mode_weights},
};
use crate::design::MarkovLink;
use nalgebra::DMatrix;
use slqg::{DefaultInput, arrival};

/// Singular values below this part of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-12;

/// `U = Lx(s) xhat + M(s) vbar`, with `s` the state of the channel in the cycle before.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelLaw {
    length: usize,
    default_input: DefaultInput,
    /// `[Lx M]` by state of the channel, `(N nu) x (nx + n_v nu)`.
    gains: Vec<DMatrix<f64>>,
    states: usize,
    /// P(delay > d) for d = 0..N-1, by state of the channel.
    survival: Vec<Vec<f64>>,
}

impl ChannelLaw {
    /// The law that explains the gains of all modes of a chain of age and channel, by least squares; with the largest
    /// difference that it leaves, relative to the largest gain.
    pub fn explaining(
        problem: &LoopProblem,
        channel: &MarkovLink,
        chain: &ModeChain,
        gains: &[DMatrix<f64>],
    ) -> (Self, f64) {
        let (nx, nu) = (problem.a.nrows(), problem.b.ncols());
        let survival = (0..channel.states()).map(|state| {
            let mut survival = vec![1.0; problem.length];
            if let Some(delays) = channel.delays(state) {
                arrival::survival(delays.probabilities(), delays.loss(), &mut survival);
            }
            survival
        });
        let mut law = Self {
            length: problem.length,
            default_input: problem.default_input,
            gains: Vec::new(),
            states: nx,
            survival: survival.collect(),
        };
        let identity = DMatrix::<f64>::identity(nu, nu);
        let regressors: Vec<DMatrix<f64>> = chain
            .ages
            .iter()
            .zip(&chain.channels)
            .map(|(&age, channel)| {
                let table = law.arrival_table(channel);
                let weights = mode_weights(law.length, law.default_input, &table, age).kronecker(&identity);
                let mut whole = DMatrix::zeros(nx + weights.nrows(), nx + weights.ncols());
                whole.view_mut((0, 0), (nx, nx)).fill_with_identity();
                whole.view_mut((nx, nx), weights.shape()).copy_from(&weights);
                whole
            })
            .collect();
        let (mut difference, mut largest) = (0.0_f64, 0.0_f64);
        for state in 0..channel.states() {
            let of_state: Vec<_> =
                (0..gains.len()).filter(|&mode| chain.channels[mode][0] == state).collect();
            let beside = |part: &dyn Fn(usize) -> DMatrix<f64>| {
                let parts: Vec<_> = of_state.iter().map(|&mode| part(mode)).collect();
                let columns: Vec<_> = parts.iter().flat_map(|part| part.column_iter()).collect();
                DMatrix::from_columns(&columns)
            };
            let regressor = beside(&|mode| regressors[mode].clone());
            let explained = beside(&|mode| gains[mode].clone());
            let inverse =
                regressor.clone().pseudo_inverse(RANK_TOLERANCE).expect("the tolerance is not negative");
            let gain = &explained * inverse;
            difference = difference.max((&gain * regressor - &explained).amax());
            largest = largest.max(explained.amax());
            law.gains.push(gain);
        }
        (law, difference / largest)
    }

    /// Inputs per sequence, `N`.
    pub fn length(&self) -> usize {
        self.length
    }

    /// States of the channel.
    pub fn channel_states(&self) -> usize {
        self.gains.len()
    }

    /// The law of a cycle; `channel`: states of the channel in the cycles before, the newest first, at least one and as
    /// many as are known. What was sent in cycles before those has arrived or never will.
    pub fn at(&self, channel: &[usize]) -> Law {
        let gain = &self.gains[channel[0]];
        Law {
            length: self.length,
            default_input: self.default_input,
            lx: gain.columns(0, self.states).into_owned(),
            m: gain.columns(self.states, gain.ncols() - self.states).into_owned(),
            arrival: self.arrival_table(channel),
        }
    }

    /// The tables of `r(b, m)` for all states of the channel in the last `N-1` cycles, at least one: that of states
    /// `s_1, s_2, ..`, the newest first, stands at `s_1 + S s_2 + S^2 s_3 + ..`.
    pub fn arrival_tables(&self) -> Vec<Vec<f64>> {
        let (states, cycles) = (self.channel_states(), self.length.max(2) - 1);
        let channel = |place: usize| -> Vec<usize> {
            let digits = std::iter::successors(Some(place), |rest| Some(rest / states));
            digits.map(|rest| rest % states).take(cycles).collect()
        };
        (0..states.pow(cycles as u32)).map(|place| self.arrival_table(&channel(place))).collect()
    }

    /// `r(b, m)` in the core's order: row `b` is about the packet sent `b` cycles ago, in the state of that cycle.
    fn arrival_table(&self, channel: &[usize]) -> Vec<f64> {
        let mut table = vec![0.0; arrival::table_len(self.length)];
        for b in 1..self.length {
            // Beyond what is known it does not matter: those packets are no newer than the one that plays.
            let state = channel.get(b - 1).copied().unwrap_or(channel[0]);
            for m in 0..self.length - b {
                table[arrival::table_index(self.length, b, m)] =
                    arrival::conditional_arrival(&self.survival[state], b, m);
            }
        }
        table
    }
}
