//! Bounds on the covariance of the estimation error in steady state.
//!
//! At cycle `k` the filter holds the measurements that have arrived by then. The one sampled `a` cycles ago has with
//! probability `p_a = Q(min(a, N^B))`, independently of all others since packets are delayed independently. Late ones
//! are put in their place and the filter runs again from there, so the error covariance at `k` is what the filter
//! makes of measurements that come at once, each with its own probability `p_a`: for ages above the buffer the constant
//! `q_arr = Q(N^B)`, then `p_(N^B), .., p_1, p_0`. With `h(X) = A X A' + W` and the correction
//! `u(X) = X - X C' (C X C' + V)^-1 C X`, the posterior covariances at ages `a+1` and `a` satisfy
//!
//! ```text
//! E[S_a] = (1 - p_a) h(E[S_(a+1)]) + p_a E[u(h(S_(a+1)))]
//! ```
//!
//! - **Upper bound:** `u` is concave, so `E[u(h(S))] <= u(h(E[S]))`: the modified Riccati equation for `q_arr` in steady
//!   state, then one of its steps for each age within the buffer, with that age's own probability.
//! - **Lower bound:** no filter knows more than the Kalman filter to which all measurements come at once, and `u(h(.))`
//!   is monotone, so `u(h(S)) >= S_K`, that filter's steady-state covariance: the linear recursion with `p_a S_K` in place
//!   of the last term.
//!
//! Where each `p_a` is 0 or 1, a link without loss and with one delay, both are exact. An ordinary Riccati equation, or one
//! in which a measurement counts only once it can no longer come, would bound it too, but more loosely.

use super::limit::arrival_limit;
use super::riccati::{corrected, kalman_covariance, modified_riccati, predicted};
use super::{EstimationVerdict, verdict};
use crate::design::{DelayDistribution, Plant};
use crate::stability::{Growth, growth, loses_sight};
use nalgebra::DMatrix;

/// Squarings after which a sum of powers below 1 has converged: 2^64 terms.
const SQUARINGS: usize = 64;

/// Bounds, in the order of symmetric matrices, on `E[e e']`, nx x nx; `e` is the error after the measurements of the cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct CovarianceBounds {
    /// From below; `None` if the covariance grows without bound.
    pub lower: Option<DMatrix<f64>>,
    /// From above; `None` if no bound is known.
    pub upper: Option<DMatrix<f64>>,
}

/// Bounds for measurements over `link` that count until they are `measurement_buffer` cycles late.
///
/// The inputs applied are taken as known, as with instant acknowledgements; where they are not, the lower bound holds.
pub fn covariance_bounds(
    plant: &Plant,
    link: &DelayDistribution,
    measurement_buffer: usize,
) -> CovarianceBounds {
    let limit = arrival_limit(plant);
    bounds(plant, link, measurement_buffer, verdict(limit.as_ref(), link.arrival(measurement_buffer)))
}

/// The same where the `verdict` is known.
pub(super) fn bounds(
    plant: &Plant,
    link: &DelayDistribution,
    measurement_buffer: usize,
    verdict: EstimationVerdict,
) -> CovarianceBounds {
    if verdict == EstimationVerdict::Unstable {
        return CovarianceBounds { lower: None, upper: None };
    }
    let arrival = link.arrival(measurement_buffer);
    let best = kalman_covariance(plant);
    let is_decaying = growth(plant) == Growth::Decays;
    let is_blind = if arrival == 0.0 { !is_decaying } else { loses_sight(plant, link, measurement_buffer) };
    let linear = |older: &DMatrix<f64>, q: f64| predicted(plant, older) * (1.0 - q) + &best * q;
    let modified = |older: &DMatrix<f64>, q: f64| corrected(plant, &predicted(plant, older), q);

    let lower = (!is_blind).then(|| stationary(plant, &best, arrival));
    let upper = if arrival == 0.0 {
        lower.clone()
    } else {
        modified_riccati(plant, arrival).map(|prior| corrected(plant, &prior, arrival))
    };
    // From the oldest that may still come to the newest. Beyond the largest delay nothing changes any more.
    let recent = measurement_buffer.min(link.largest_delay());
    let along = |start: DMatrix<f64>, step: &dyn Fn(&DMatrix<f64>, f64) -> DMatrix<f64>| {
        (0..recent).rev().fold(start, |older, age| step(&older, link.arrival(age)))
    };
    CovarianceBounds {
        lower: lower.map(|start| along(start, &linear)),
        upper: upper.map(|start| along(start, &modified)),
    }
}

/// Fixed point of `X = (1-q) (A X A' + W) + q S_K`, by doubling the number of terms of its series.
fn stationary(plant: &Plant, best: &DMatrix<f64>, q: f64) -> DMatrix<f64> {
    let mut factor = &plant.a * (1.0 - q).sqrt();
    let mut sum = &plant.process_noise * (1.0 - q) + best * q;
    for _ in 0..SQUARINGS {
        let more = &factor * &sum * factor.transpose();
        sum += &more;
        // Each state by itself, as they have different units.
        if more.diagonal().iter().zip(sum.diagonal().iter()).all(|(more, sum)| *more <= f64::EPSILON * sum) {
            break;
        }
        factor = &factor * &factor;
    }
    sum
}
