//! A proof of stability that can be checked without trusting how it was found: thesis Theorem 3.3 b), (3.36).
//!
//! Matrices `X(0..=N) > 0` with `X(j) > sum_i p(j,i) (A(i)+B(i)L(j))^T X(i) (A(i)+B(i)L(j))` for all `j`: a quadratic
//! function of the augmented state that falls in the mean at every step, whatever the age. [`certify`] finds them by
//! summing a cost over the closed loop's future; [`Certificate::verify`] knows nothing of that. It recomputes every
//! difference densely, takes off all that rounding can have added, and factors what is left.
//!
//! The proof is about the control loop with its state known, the condition that depends on the gains.

mod verification;

use crate::balance::{power_of_two, state_units};
use crate::figure::figure;
use crate::json::{line_per_field, rows};
use crate::solve::{
    ClosedLoop, LoopProblem, ModeChain, Solution, age_transitions, mean_square_rate, modes, solve_correction,
};
use nalgebra::DMatrix;
use serde::Serialize;
use verification::Differences;

/// Name of the file format.
const FORMAT: &str = "slqg-certificate";
/// Raised when a field changes its meaning or goes away; new fields may come at any time.
const FORMAT_VERSION: u32 = 1;
/// Terms of the cost summed one by one; the rest is then found in one piece.
const TERMS: usize = 400;
/// A rest of the stage cost small enough to be left out: what remains of the difference is three quarters of it.
const REST: f64 = 0.25;
/// Halvings of the interval in which the proved rate is looked for.
const BISECTIONS: usize = 40;
/// Smallest weight of a state in the stage cost, relative to the largest.
const LEAST_WEIGHT: f64 = 1e-6;

/// Verified matrices `X(j)`. There is no way to one but through [`Certificate::verify`].
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    x: Vec<DMatrix<f64>>,
    rate_bound: f64,
}

/// Why no certificate is given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotCertified {
    /// The closed loop is not mean-square stable: there is none.
    #[error("no certificate: the closed loop's mean-square rate is {} >= 1", figure(*rate))]
    Unstable {
        /// Mean-square rate, per step.
        rate: f64,
    },
    /// The law is one for a loop without acknowledgements, and what would prove its rate is not written yet.
    #[error(
        "no certificate: there are no acknowledgements, and of the law that is made for that there is none; the report has its rate, \
         and with controller.estimator = \"single\" the law for known ages has a certificate"
    )]
    Unacknowledged,
    /// The law is one for packets at fixed times or for a trigger that counts on them, and what would prove its rate is not written yet.
    #[error(
        "no certificate: the law is made for packets in every p-th cycle, and of that there is none; the report has its rate, and with \
         event.base = 1 the law for a packet in every cycle has a certificate"
    )]
    Scheduled,
    /// No matrices were found that pass the check; the loop is too close to the limit of stability.
    #[error("no certificate: with a mean-square rate of {} the matrices found fail the check: {reason}", figure(*rate))]
    OutOfReach {
        /// Mean-square rate, per step.
        rate: f64,
        /// What fails.
        reason: Rejected,
    },
}

/// Why matrices are no proof of stability.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Rejected {
    /// The number of matrices or gains is not `N + 1`, or one has the wrong dimensions.
    #[error("matrices or gains have the wrong number or dimensions")]
    Dimensions,
    /// A number is infinite or not a number.
    #[error("a number is not finite")]
    NotFinite,
    /// `X(mode)` differs from its transpose.
    #[error("X({mode}) is not symmetric")]
    NotSymmetric {
        /// Which.
        mode: usize,
    },
    /// `X(mode)` is not shown to be positive definite.
    #[error("X({mode}) is not positive definite")]
    NotPositive {
        /// Which.
        mode: usize,
    },
    /// The difference of mode `mode` is not shown to be positive definite.
    #[error("the difference of mode {mode} in (3.36) is not positive definite")]
    NotDecreasing {
        /// Which.
        mode: usize,
    },
}

/// A certificate for the gains of `solution`. The solution's own verdict is a hint, nothing is concluded from it.
///
/// # Errors
/// The loop is not mean-square stable, or so close to the limit that rounding hides it.
pub fn certify(problem: &LoopProblem, solution: &Solution) -> Result<Certificate, NotCertified> {
    certify_gains(problem, &solution.mode_gains(), solution.mean_square_rate)
}

/// A certificate for the gains `L(j)`, `j = 0..=N`, `(N nu) x n` each, found with their mean-square rate as a hint.
///
/// # Errors
/// As [`certify`].
///
/// # Panics
/// If the gains do not have the problem's dimensions.
pub fn certify_gains(
    problem: &LoopProblem,
    gains: &[DMatrix<f64>],
    rate: f64,
) -> Result<Certificate, NotCertified> {
    if rate.is_nan() || rate >= 1.0 {
        return Err(NotCertified::Unstable { rate });
    }
    // Costs that are let grow on their way back, half as much as they can be, prove half of the distance to the limit.
    let bound = 0.5 * (1.0 + rate);
    let found = future_cost(problem, gains, bound).ok_or(Rejected::NotFinite);
    found.and_then(|x| Certificate::verify(problem, gains, x)).map_err(|reason| {
        // The hint may have been wrong.
        match mean_square_rate(problem, gains) {
            rate if rate < 1.0 => NotCertified::OutOfReach { rate, reason },
            rate => NotCertified::Unstable { rate },
        }
    })
}

/// `X = C + T X / growth`: the cost of all future, discounted by less than the loop forgets, of a diagonal stage cost
/// `C`. `T` is [`ClosedLoop::apply`]. `None` if it is not finite.
fn future_cost(problem: &LoopProblem, gains: &[DMatrix<f64>], growth: f64) -> Option<Vec<DMatrix<f64>>> {
    let (modes, chain) = (modes(problem), ModeChain::independent(&problem.link, problem.length));
    let closed = ClosedLoop { modes: &modes, chain: &chain, gains };
    let size = closed.size();
    let weights = stage_weights(problem, size);
    // In units in which the stage cost is the identity.
    let rescaled = |values: &[f64], sign: i32, factor: f64| -> Vec<f64> {
        let at = |index: usize| weights[index % size].powi(sign) * weights[index / size % size].powi(sign);
        values.iter().enumerate().map(|(index, value)| value * factor * at(index)).collect()
    };
    let mut image = vec![0.0; size * size * modes.len()];
    let mut apply = |from: &[f64], to: &mut [f64]| {
        closed.apply(&rescaled(from, 1, 1.0), &mut image);
        to.copy_from_slice(&rescaled(&image, -1, growth.recip()));
    };
    let mut term = DMatrix::<f64>::identity(size, size).as_slice().repeat(modes.len());
    let mut sum = term.clone();
    let mut next = term.clone();
    let length = |term: &[f64]| term.iter().map(|value| value * value).sum::<f64>().sqrt();
    for _ in 0..TERMS {
        apply(&term, &mut next);
        std::mem::swap(&mut term, &mut next);
        sum.iter_mut().zip(&term).for_each(|(sum, term)| *sum += term);
        if length(&term) <= REST {
            break;
        }
    }
    if length(&term) > REST {
        apply(&term, &mut next);
        let rest = solve_correction(&next, 1.0, REST, &mut apply)?;
        sum.iter_mut().zip(rest).for_each(|(sum, rest)| *sum += rest);
    }
    let costs = rescaled(&sum, 1, 1.0);
    let matrices = costs.chunks_exact(size * size).map(|cost| DMatrix::from_column_slice(size, size, cost));
    costs.iter().all(|cost| cost.is_finite()).then(|| matrices.map(|x| (&x + x.transpose()) * 0.5).collect())
}

/// Square roots of a positive diagonal stage cost, rounded to powers of two so that changing units by them is exact:
/// those of `Q`, raised where it does not see a state, and of `R` for every input in flight. `n` values.
fn stage_weights(problem: &LoopProblem, size: usize) -> Vec<f64> {
    let (nx, nu) = problem.b.shape();
    let root = |value: f64| if value > 0.0 { power_of_two(value.sqrt()) } else { 1.0 };
    // Weights are compared in units that come from the plant: those of the design must not decide.
    let seen = problem.q.diagonal().map(|weight| weight.max(0.0).sqrt());
    let inflow = DMatrix::from_fn(nx, nu, |i, j| problem.b[(i, j)] / root(problem.r[(j, j)]));
    let units = state_units(&problem.a, &inflow, &DMatrix::from_diagonal(&seen));
    let largest = seen.iter().zip(&units).map(|(weight, unit)| (weight * unit).powi(2)).fold(0.0, f64::max);
    let of_state =
        |state: usize| root(problem.q[(state, state)].max(LEAST_WEIGHT * largest / units[state].powi(2)));
    let of_input = |input: usize| root(problem.r[(input, input)]);
    (0..size).map(|at| if at < nx { of_state(at) } else { of_input((at - nx) % nu) }).collect()
}

impl Certificate {
    /// The matrices as a certificate, if they are one: `X(j)`, `j = 0..=N`, each `n x n`, for the problem's plant, link
    /// and sequence length and the gains `L(j)`, `(N nu) x n` each.
    ///
    /// Nothing is taken over from how they were found. The differences are computed with products in their plain order;
    /// a bound of all rounding, in the products and in the factorisation, is taken off the diagonal before Cholesky's
    /// factorisation has to succeed.
    ///
    /// # Errors
    /// The matrices are no proof; says which and why.
    pub fn verify(
        problem: &LoopProblem,
        gains: &[DMatrix<f64>],
        x: Vec<DMatrix<f64>>,
    ) -> Result<Self, Rejected> {
        let differences = Differences::new(problem, gains, &x)?;
        for mode in 0..x.len() {
            if !differences.is_positive(mode) {
                return Err(Rejected::NotPositive { mode });
            }
            if !differences.is_decreasing(mode, 1.0) {
                return Err(Rejected::NotDecreasing { mode });
            }
        }
        let (mut fails, mut holds) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (fails + holds);
            let all = (0..x.len()).all(|mode| differences.is_decreasing(mode, middle));
            *(if all { &mut holds } else { &mut fails }) = middle;
        }
        Ok(Self { x, rate_bound: holds })
    }

    /// `X(0)` to `X(N)`, `n x n` each over `[x; rho]` (hold: and the default input).
    pub fn matrices(&self) -> &[DMatrix<f64>] {
        &self.x
    }

    /// Factor a step by which these matrices prove second moments to shrink at least: the smallest `s` with
    /// `s X(j)` above the right side of (3.36) for all `j`, rounding taken off. No smaller than the mean-square rate.
    pub fn rate_bound(&self) -> f64 {
        self.rate_bound
    }

    /// Everything needed to check the certificate without this project, as one JSON object.
    pub fn to_json(&self, name: &str, problem: &LoopProblem, gains: &[DMatrix<f64>]) -> String {
        let modes = modes(problem);
        line_per_field(&File {
            format: FORMAT,
            format_version: FORMAT_VERSION,
            name,
            sequence_length: problem.length,
            default_input: problem.default_input.name(),
            a: rows(&problem.a),
            b: rows(&problem.b),
            delays: problem.link.probabilities(),
            rate_bound: self.rate_bound,
            transition_matrix: rows(&age_transitions(&problem.link, problem.length)),
            a_hat: modes.iter().map(|mode| rows(&mode.a)).collect(),
            b_hat: modes.iter().map(|mode| rows(&mode.b)).collect(),
            gains: gains.iter().map(rows).collect(),
            x: self.x.iter().map(rows).collect(),
        })
    }
}

/// The file's fields in their order; matrices are lists of rows, lists of matrices go by mode `0..=N`.
#[derive(Serialize)]
struct File<'c> {
    format: &'static str,
    format_version: u32,
    name: &'c str,
    sequence_length: usize,
    default_input: &'static str,
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    delays: &'c [f64],
    rate_bound: f64,
    transition_matrix: Vec<Vec<f64>>,
    a_hat: Vec<Vec<Vec<f64>>>,
    b_hat: Vec<Vec<Vec<f64>>>,
    gains: Vec<Vec<Vec<f64>>>,
    x: Vec<Vec<Vec<f64>>>,
}
