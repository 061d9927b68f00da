//! Conditions for stability that need no gains: thesis Theorem 3.4 and the lengths of Corollary 3.1.
//!
//! Whether given gains stabilise is decided by their mean-square rate, in [`crate::solve`].

use crate::design::{DelayDistribution, Plant, modes};
use crate::problem::LoopProblem;
use nalgebra::DMatrix;

/// What a plant does that is left alone, by the largest modulus of its eigenvalues.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Growth {
    /// Below 1: every state fades.
    Decays,
    /// 1 within rounding: an integrator, or an oscillation without damping.
    OnTheLimit,
    /// Above 1: some state grows without bound.
    Grows,
}

/// What the plant does that is left alone. Everything that asks whether a plant is stable asks here.
pub fn growth(plant: &Plant) -> Growth {
    match open_loop_modulus(&plant.a) {
        modulus if modulus < 1.0 => Growth::Decays,
        modulus if modulus > 1.0 => Growth::Grows,
        // Rounded to 1 where it cannot be told from it.
        _ => Growth::OnTheLimit,
    }
}

/// Largest modulus of the eigenvalues of `A`; exactly 1 where rounding cannot tell it from 1.
pub fn open_loop_modulus(a: &DMatrix<f64>) -> f64 {
    // A design whose eigenvalues cannot be computed is refused when it is read; for others, the safe side.
    modes::modes(a).map_or(f64::INFINITY, |modes| modes.iter().map(modes::Mode::modulus).fold(0.0, f64::max))
}

/// Probability that the buffer of an actuator that has run dry stays dry for another cycle: `p(N, N) = 1 - Q(N-1)`.
pub fn dry_probability(link: &DelayDistribution, length: usize) -> f64 {
    (1.0 - link.arrival(length - 1)).max(0.0)
}

/// Theorem 3.4 b): whether the buffer runs dry so often that no controller can stabilise the plant.
pub fn runs_dry(problem: &LoopProblem) -> bool {
    dry_growth(problem, problem.length) > 1.0
}

/// `p(N, N) |lambda_max(A)|^2`: growth of the squared state while the buffer is dry. Theorem 3.4 b).
pub fn dry_growth(problem: &LoopProblem, length: usize) -> f64 {
    dry_probability(&problem.link, length) * open_loop_modulus(&problem.a).powi(2)
}

/// The same for the problem's length, where the modulus is known.
pub(crate) fn dry_growth_of(problem: &LoopProblem, open_loop_modulus: f64) -> f64 {
    dry_probability(&problem.link, problem.length) * open_loop_modulus.powi(2)
}

/// Shortest length that Theorem 3.4 b) does not rule out, `N_min` of (3.39); `None` if it rules out all.
pub fn shortest_admissible_length(problem: &LoopProblem) -> Option<usize> {
    // Beyond the largest delay a longer sequence does not arrive any more often.
    let longest = problem.link.probabilities().len().max(1);
    let squared = open_loop_modulus(&problem.a).powi(2);
    (1..=longest).find(|&length| dry_probability(&problem.link, length) * squared <= 1.0)
}

/// Theorem 3.4 a): whether so few measurements arrive within the buffer that no filter can follow the plant.
pub fn loses_sight(plant: &Plant, link: &DelayDistribution, measurement_buffer: usize) -> bool {
    let loss = (1.0 - link.arrival(measurement_buffer)).max(0.0);
    match growth(plant) {
        Growth::Decays => false,
        // All of them lost, but for rounding in the modulus.
        Growth::OnTheLimit => loss >= 1.0,
        Growth::Grows => sight_growth(plant, link, measurement_buffer) >= 1.0,
    }
}

/// `(1 - q_arr) |lambda_max(A)|^2`: growth of the error covariance between measurements. Theorem 3.4 a).
pub fn sight_growth(plant: &Plant, link: &DelayDistribution, measurement_buffer: usize) -> f64 {
    (1.0 - link.arrival(measurement_buffer)).max(0.0) * open_loop_modulus(&plant.a).powi(2)
}
