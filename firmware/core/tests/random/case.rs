//! Random plants, costs and links, the same on every machine.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use slqg::synthesis::{Dimensions, Problem, Synthesis};
use slqg::{DefaultInput, arrival};

/// A plant, a cost and a link; matrices row-major.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) dimensions: Dimensions,
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
    pub(crate) q: Vec<f64>,
    pub(crate) r: Vec<f64>,
    pub(crate) survival: Vec<f64>,
}

impl Case {
    pub(crate) fn problem(&self) -> Problem<'_, f64> {
        let Self { dimensions, a, b, q, r, survival } = self;
        Problem { dimensions: *dimensions, a, b, q, r, survival }
    }

    /// The recursion started anew from zero and run to its fixed point; `None` if it does not settle.
    pub(crate) fn solve<'p, 'w>(&'p self, workspace: &'w mut [f64]) -> Option<Synthesis<'p, 'w, f64>> {
        let mut synthesis = Synthesis::new(self.problem(), workspace).expect("slices of the right shape");
        (0..4000).any(|_| synthesis.optimal_step() < 1e-13).then_some(synthesis)
    }
}

/// `root root^T + floor I`.
fn covariance(root: &[f64], size: usize, floor: f64) -> Vec<f64> {
    let entry = |row: usize, column: usize| {
        let product: f64 = (0..size).map(|k| root[row * size + k] * root[column * size + k]).sum();
        product + if row == column { floor } else { 0.0 }
    };
    (0..size * size).map(|index| entry(index / size, index % size)).collect()
}

fn cases() -> impl Strategy<Value = Case> {
    let numbers = |count| proptest::collection::vec(-1.0..1.0, count);
    let weight = || prop_oneof![1 => Just(0u32), 3 => 1u32..100];
    let link = (proptest::collection::vec(weight(), 1..7), 1u32..50);
    let sizes = (1usize..=4, 1usize..=2, 1usize..=5, any::<bool>());
    (sizes, numbers(16), numbers(8), numbers(16), numbers(4), link).prop_map(
        |((states, inputs, length, hold), a, b, q, r, (weights, loss))| {
            let default_input = if hold { DefaultInput::Hold } else { DefaultInput::Zero };
            let mut survival = vec![0.0; length];
            let delays: Vec<f64> = weights.iter().map(|weight| f64::from(*weight)).collect();
            arrival::survival(&delays, f64::from(loss), &mut survival);
            Case {
                dimensions: Dimensions { states, inputs, length, default_input },
                a: a[..states * states].to_vec(),
                b: b[..states * inputs].to_vec(),
                q: covariance(&q[..states * states], states, 0.1),
                r: covariance(&r[..inputs * inputs], inputs, 0.2),
                survival,
            }
        },
    )
}

/// The same random cases in every run.
pub(crate) fn some_cases(count: usize) -> Vec<Case> {
    let mut runner = TestRunner::deterministic();
    (0..count).map(|_| cases().new_tree(&mut runner).expect("nothing is filtered").current()).collect()
}
