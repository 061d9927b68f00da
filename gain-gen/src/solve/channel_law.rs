//! [`ChannelLaw`]: the law over a channel that comes and goes, in the form the device computes.
//!
//! `U = Lx(s) xhat + M(s) vbar` with `s` the state of the channel in the cycle before, and `vbar` from arrival probabilities
//! that differ from packet to packet: each has those of the state it was sent in.

use super::{
    LoopProblem, ModeChain,
    law::{Law, mode_weights},
};
use nalgebra::DMatrix;
use slqg::{DefaultInput, arrival};

/// One pair of tables for each state of a channel, `O(S N^2)` numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelLaw {
    length: usize,
    default_input: DefaultInput,
    states: usize,
    /// `[Lx M]` by state of the channel, `(N nu) x (nx + n_v nu)`.
    gains: Vec<DMatrix<f64>>,
    /// P(delay > d) for d = 0..N-1, by state of the channel.
    survival: Vec<Vec<f64>>,
}

impl ChannelLaw {
    /// `gains`: `[Lx M]` by state of the channel; `survival`: P(delay > d) for d = 0..N-1 of packets sent in each.
    pub(super) fn new(problem: &LoopProblem, gains: Vec<DMatrix<f64>>, survival: Vec<Vec<f64>>) -> Self {
        Self {
            length: problem.length,
            default_input: problem.default_input,
            states: problem.a.nrows(),
            gains,
            survival,
        }
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

    /// `L(j)` over `[x; rho]` (hold: and the default input) for every mode of a chain of age and channel: what the coupled
    /// recursion finds, spelled out.
    pub fn mode_gains(&self, chain: &ModeChain) -> Vec<DMatrix<f64>> {
        let spelled = |(&age, channel): (&usize, &Vec<usize>)| {
            let law = self.at(channel);
            let weights = mode_weights(law.length, law.default_input, &law.arrival, age);
            let inputs = law.inputs();
            let sent = &law.m * weights.kronecker(&DMatrix::<f64>::identity(inputs, inputs));
            let mut gain = DMatrix::zeros(law.lx.nrows(), self.states + sent.ncols());
            gain.columns_mut(0, self.states).copy_from(&law.lx);
            gain.columns_mut(self.states, sent.ncols()).copy_from(&sent);
            gain
        };
        chain.ages.iter().zip(&chain.channels).map(spelled).collect()
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
