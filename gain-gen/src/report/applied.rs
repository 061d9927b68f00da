//! How large the inputs are that the actuator applies, and how many times that their limits are away.
//!
//! The estimate moves by `A` and `B` like the state, and by what measurements tell, which nothing before foretells: noise of
//! covariance `W + A S A' - S` in the mean, with `S` the error's covariance in steady state, that does not depend on what the
//! actuator's link does. So the mean square of input `i` is `tr(P_i (W + A S A' - S))`, with `P_i` its cost-to-go, where the state
//! known costs `tr(P_i W)`. Bounds on `S` give bounds on it.

use crate::design::{Acknowledgement, Design};
use crate::estimation::Estimation;
use nalgebra::{DMatrix, SymmetricEigen};

/// One input with limits, in steady state, its limits not met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AppliedInput {
    /// Root mean square with the state known.
    pub rms: f64,
    /// How many of those the nearer limit is away.
    pub limit_distance: f64,
    /// Bounds on the root mean square with the state estimated, one number where they agree; `None` if none are known.
    pub rms_estimated: Option<(f64, f64)>,
    /// How many times the upper one the nearer limit is away.
    pub limit_distance_estimated: Option<f64>,
}

impl AppliedInput {
    /// All inputs of a design with limits; `costs`: what the square of each costs, `P_i`.
    pub(super) fn all(design: &Design, estimation: &Estimation, costs: &[DMatrix<f64>]) -> Vec<Self> {
        let limits = design.controller.input_limits.iter().flatten();
        let of_input = |(&(least, greatest), cost): (&(f64, f64), &DMatrix<f64>)| {
            let nearer = greatest.min(-least);
            let rms = cost.component_mul(&design.plant.process_noise).sum().max(0.0).sqrt();
            let estimated = mean_square(design, estimation, cost);
            let rms_estimated =
                estimated.map(|(lower, upper)| (lower.max(0.0).sqrt(), upper.max(0.0).sqrt()));
            Self {
                rms,
                limit_distance: nearer / rms,
                rms_estimated,
                limit_distance_estimated: rms_estimated.map(|(_, upper)| nearer / upper),
            }
        };
        limits.zip(costs).map(of_input).collect()
    }
}

/// Bounds on the mean square of the input whose square costs `cost`.
fn mean_square(design: &Design, estimation: &Estimation, cost: &DMatrix<f64>) -> Option<(f64, f64)> {
    if design.network.acknowledgement != Acknowledgement::Instant {
        return None;
    }
    let covariance = &estimation.covariance;
    let (lower, upper) = (covariance.lower.as_ref()?, covariance.upper.as_ref()?);
    let plant = &design.plant;
    let told = &plant.a * lower * plant.a.transpose() - lower;
    let least = cost.component_mul(&(&plant.process_noise + told)).sum();
    // What a larger error adds, or takes away: from `lower` up to `upper` along any direction.
    let weight = plant.a.tr_mul(&(cost * &plant.a)) - cost;
    let root = root(&(upper - lower));
    let more = SymmetricEigen::new(root.tr_mul(&(weight * &root))).eigenvalues;
    let sum = |keep: fn(&f64) -> bool| more.iter().copied().filter(keep).sum::<f64>();
    Some((least + sum(|&value| value < 0.0), least + sum(|&value| value > 0.0)))
}

/// `F` with `F F'` a covariance that is semidefinite but for rounding; each state in its own unit.
fn root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let unit = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
    let scaled = covariance.map_with_location(|i, j, entry| {
        let size = unit[i] * unit[j];
        if size > 0.0 { (entry / size).clamp(-1.0, 1.0) } else { 0.0 }
    });
    let parts = SymmetricEigen::new((&scaled + scaled.transpose()) * 0.5);
    let lengths = DMatrix::from_diagonal(&parts.eigenvalues.map(|value| value.max(0.0).sqrt()));
    DMatrix::from_diagonal(&unit) * parts.eigenvectors * lengths
}
