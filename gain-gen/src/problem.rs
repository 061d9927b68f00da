//! The loop as the recursions know it: plant, weights, link and sequences.

use crate::design::{DelayDistribution, Design};
use nalgebra::DMatrix;
use slqg::{DefaultInput, arrival};

/// What is to be solved: thesis Problem 3.1 in steady state.
#[derive(Debug, Clone)]
pub struct LoopProblem {
    /// State transition, `nx x nx`.
    pub a: DMatrix<f64>,
    /// Input, `nx x nu`.
    pub b: DMatrix<f64>,
    /// State weight, `nx x nx`, positive semidefinite.
    pub q: DMatrix<f64>,
    /// Input weight, `nu x nu`, positive definite.
    pub r: DMatrix<f64>,
    /// Delay of the link from controller to actuator.
    pub link: DelayDistribution,
    /// Inputs per sequence, `N`.
    pub length: usize,
    /// What the actuator applies when its buffer has run out.
    pub default_input: DefaultInput,
}

impl LoopProblem {
    /// The problem of a design.
    pub fn of(design: &Design) -> Self {
        Self {
            a: design.plant.a.clone(),
            b: design.plant.b.clone(),
            q: design.cost.q.clone(),
            r: design.cost.r.clone(),
            link: design.network.controller_to_actuator.delays.clone(),
            length: design.controller.sequence_length,
            default_input: design.controller.default_input,
        }
    }

    /// The same problem with sequences of `length` inputs.
    pub fn with_length(&self, length: usize) -> Self {
        Self { length, ..self.clone() }
    }

    /// Survival function of the link, `N` values.
    pub fn survival(&self) -> Vec<f64> {
        let mut survival = vec![0.0; self.length];
        arrival::survival(self.link.probabilities(), self.link.loss(), &mut survival);
        survival
    }

    /// Probability that a packet arrives in the cycle it was sent in, `1 - g(0)`.
    pub fn arrives_at_once(&self) -> f64 {
        1.0 - self.survival()[0]
    }

    /// Conditional arrival probabilities `r(b, m)` in the core's table order.
    pub fn arrival_table(&self) -> Vec<f64> {
        let mut table = vec![0.0; arrival::table_len(self.length)];
        arrival::fill_table(&self.survival(), &mut table);
        table
    }

    /// Whether every packet arrives in the cycle it was sent in.
    pub(crate) fn is_network_free(&self) -> bool {
        self.survival()[0] == 0.0
    }
}
