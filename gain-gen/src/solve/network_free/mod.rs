//! The control problem without its network: every packet arrives in the cycle it was sent in.
//!
//! It is the exact answer where the link is that good, and the start for every other link: what a lossy link costs more
//! is forgotten as fast as packets are, while a lightly damped plant forgets where it started only after many cycles.
//!
//! | file | what lives there |
//! |---|---|
//! | `doubling` | the Riccati equation by structure-preserving doubling |
//! | `refinement` | its solution to the last digit, and how far the gains were off |

mod doubling;
mod refinement;

use super::LoopProblem;
use super::radius::{radius, rough_radius};
use crate::extended::{Extended, rounded, widened};
use doubling::doubling;
use nalgebra::DMatrix;
use refinement::{Equation, Refined, SETTLED};

/// Error of the gains up to which a solution found in `f64` is good enough.
const GOOD: f64 = 1e-12;

/// Optimal gains without a network.
#[derive(Debug, Clone)]
pub(super) struct NetworkFree {
    /// `P`, `nx x nx`.
    pub(super) cost_to_go: DMatrix<f64>,
    /// `K`, `nu x nx`: `u = K x`.
    pub(super) gain: DMatrix<f64>,
    /// `A + B K`, `nx x nx`, in the coordinates it was found in.
    closed: DMatrix<Extended>,
    /// Its spectral radius, not to the last digits.
    pub(super) radius: f64,
    /// How far the gains may be off, relative to the largest of their row: what the last correction moved.
    pub(super) error: f64,
}

/// Solves the problem as if its link were perfect; `None` if no stabilising solution is found: the plant cannot be
/// stabilised, or its weights do not see a mode on or outside the unit circle.
///
/// The plant should come in balanced units.
pub(super) fn network_free(problem: &LoopProblem) -> Option<NetworkFree> {
    let equation = Equation::new(&problem.a, &problem.b, &problem.q, &problem.r);
    let spread = equation.spread()?;
    // What only is to be begun with needs fewer digits.
    let settled = if problem.is_network_free() { SETTLED } else { GOOD };
    let fast = doubling(&problem.a, &rounded(&spread), &problem.q)
        .and_then(|cost| equation.refine(widened(&cost), settled))
        .filter(|found| found.error <= GOOD);
    let found = match fast {
        Some(found) => found,
        None => {
            let (a, q) = equation.transition_and_weight();
            equation.refine(doubling(a, &spread, q)?, settled)?
        }
    };
    let Refined { cost, gain, closed, error } = found;
    // Where there is a network it is not the rate of the loop, only of what the recursion starts from.
    let radius = rough_radius(&rounded(&closed));
    (radius < 1.0).then(|| NetworkFree {
        cost_to_go: rounded(&cost),
        gain: rounded(&gain),
        closed,
        radius,
        error,
    })
}

impl NetworkFree {
    /// Spectral radius of `A + B K` to the last digit.
    pub(super) fn exact_radius(&self) -> f64 {
        radius(&self.closed)
    }

    /// The same in coordinates in which states and inputs have these units.
    pub(super) fn in_units(mut self, states: &[f64], inputs: &[f64]) -> Self {
        let size = states.len();
        self.cost_to_go =
            DMatrix::from_fn(size, size, |i, j| self.cost_to_go[(i, j)] * states[i] * states[j]);
        self.gain = DMatrix::from_fn(inputs.len(), size, |i, j| self.gain[(i, j)] * states[j] / inputs[i]);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::DelayDistribution;
    use slqg::DefaultInput;

    fn problem(a: DMatrix<f64>, b: DMatrix<f64>, q: f64) -> LoopProblem {
        let (states, inputs) = b.shape();
        LoopProblem {
            a,
            b,
            q: DMatrix::identity(states, states) * q,
            r: DMatrix::identity(inputs, inputs),
            link: DelayDistribution::new(vec![1.0]).expect("a distribution"),
            length: 1,
            default_input: DefaultInput::Zero,
        }
    }

    #[test]
    fn a_scalar_plant_has_the_solution_of_its_quadratic_equation() {
        let found = network_free(&problem(DMatrix::from_element(1, 1, 2.0), DMatrix::identity(1, 1), 1.0))
            .expect("a solution");
        // p = 1 + 4 p / (1 + p)
        let cost = 2.0 + 5.0_f64.sqrt();
        assert!((found.cost_to_go[0] - cost).abs() < 1e-15 * cost);
        assert!((found.gain[0] + 2.0 * cost / (1.0 + cost)).abs() < 1e-15);
        assert!((found.radius - (2.0 + found.gain[0]).abs()).abs() < 1e-14);
    }

    #[test]
    fn four_integrators_ten_thousand_times_a_second_keep_their_digits() {
        // x+ = exp(N T) x: the input moves the first state by T^4 / 24.
        let t: f64 = 1e-4;
        let factorial = [1.0, 1.0, 2.0, 6.0, 24.0];
        let a = DMatrix::from_fn(
            4,
            4,
            |i, j| if j < i { 0.0 } else { t.powi((j - i) as i32) / factorial[j - i] },
        );
        let b = DMatrix::from_fn(4, 1, |i, _| t.powi(4 - i as i32) / factorial[4 - i]);
        let found = network_free(&problem(a, b, 1.0)).expect("a solution");
        assert!(found.error < 1e-14, "{}", found.error);
        assert!(found.radius < 1.0);
    }

    #[test]
    fn a_plant_that_cannot_be_stabilised_has_no_solution() {
        let a = DMatrix::from_row_slice(2, 2, &[1.5, 0.0, 0.0, 0.5]);
        assert!(network_free(&problem(a, DMatrix::from_row_slice(2, 1, &[0.0, 1.0]), 1.0)).is_none());
    }
}
