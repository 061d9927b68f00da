//! What a run costs: thesis (3.16), and (4.2) where a reference is followed. In `f64`, whatever the device computes in.
//!
//! Sending has its price beside this one; it is added up in [`crate::monte_carlo`].

use crate::plant::padded;
use gain_gen::{design::Design, solve::Tracked};
use nalgebra::{DVector, SMatrix, SVector};

/// Weights of a run, of the size class.
#[derive(Debug, Clone)]
pub struct Objective<const NX: usize, const NU: usize> {
    q: SMatrix<f64, NX, NX>,
    terminal: SMatrix<f64, NX, NX>,
    r: SMatrix<f64, NU, NU>,
    tracked: Option<Following<NX, NU>>,
}

/// A reference and what follows it. Tracked outputs are padded to the states.
#[derive(Debug, Clone)]
struct Following<const NX: usize, const NU: usize> {
    /// `Z`.
    z: SMatrix<f64, NX, NX>,
    /// The input that is free of cost, per tracked output.
    input: SMatrix<f64, NU, NX>,
    /// From cycle 0 on.
    reference: Vec<SVector<f64, NX>>,
}

impl<const NX: usize, const NU: usize> Objective<NX, NU> {
    /// Of a design whose reference is `reference` from cycle 0 on; there is none where it tracks nothing.
    pub fn new(design: &Design, reference: &[DVector<f64>]) -> Self {
        let r = padded(&design.cost.r);
        let Some(Tracked { z, weight, terminal_weight, input }) = Tracked::of(design) else {
            let (q, terminal) = (padded(&design.cost.q), padded(&design.cost.terminal));
            return Self { q, terminal, r, tracked: None };
        };
        let reference = reference
            .iter()
            .map(|value| SVector::from_fn(|row, _| value.get(row).copied().unwrap_or(0.0)))
            .collect();
        let tracked = Some(Following { z: padded(&z), input: padded(&input), reference });
        Self { q: padded(&weight), terminal: padded(&terminal_weight), r, tracked }
    }

    /// `(z, z^Ref)` in `cycle`: tracked outputs of `state` and what they are to be; `None` where nothing is tracked.
    pub fn tracked(&self, cycle: usize, state: &SVector<f64, NX>) -> Option<[SVector<f64, NX>; 2]> {
        self.tracked.as_ref().map(|following| [following.z * state, following.reference[cycle]])
    }

    /// Cost of `state` and the applied `input` in `cycle`.
    pub fn stage(&self, cycle: usize, state: &SVector<f64, NX>, input: &SVector<f64, NU>) -> f64 {
        let input = match &self.tracked {
            None => *input,
            Some(following) => input - following.input * following.reference[cycle],
        };
        let error = self.error(cycle, state);
        error.dot(&(self.q * error)) + input.dot(&(self.r * input))
    }

    /// Cost of the state that a run of `cycle` cycles ends with.
    pub fn terminal(&self, cycle: usize, state: &SVector<f64, NX>) -> f64 {
        let error = self.error(cycle, state);
        error.dot(&(self.terminal * error))
    }

    fn error(&self, cycle: usize, state: &SVector<f64, NX>) -> SVector<f64, NX> {
        self.tracked(cycle, state).map_or(*state, |[z, reference]| z - reference)
    }
}
