//! The modified Riccati equation of filtering with intermittent measurements (Sinopoli et al. 2004).
//!
//! ```text
//! X = A X A' + W - q A X C' (C X C' + V)^-1 C X A'          X: nx x nx, covariance before the measurement (prior)
//! ```
//!
//! Transposed, it is the control problem over a link that delivers each packet at once with probability `q` or never,
//! with sequences of one input: `A'` for `A`, `C'` for `B`, `W` for `Q`, `V` for `R`. So the gains' own solver solves
//! it, with its checks: the residual at rounding level, and a closed loop that is mean-square stable.

use crate::design::{DelayDistribution, Plant};
use crate::solve::{LoopProblem, Method, settled_cost, solve};
use nalgebra::{DMatrix, SymmetricEigen};
use slqg::DefaultInput;

/// Stabilising solution `X` for the measurement probability `q`, nx x nx.
///
/// `None` if there is none: `q` is not above the critical probability, not positive, or no noise drives an unstable mode.
pub fn modified_riccati(plant: &Plant, q: f64) -> Option<DMatrix<f64>> {
    let solution = solve(&mirrored(plant, q)?, Method::InFlight);
    solution.is_stabilising().then_some(solution.cost_to_go)
}

/// Covariance of the steady-state Kalman filter to which every measurement comes at once, after the measurement
/// (posterior), nx x nx. Without noise on an unstable mode, that of a filter that has always known the mode.
pub fn kalman_covariance(plant: &Plant) -> DMatrix<f64> {
    // A plant whose modes all show in measurements has a bounded solution, approached from below.
    let prior = settled_cost(&mirrored(plant, 1.0).expect("1 is a probability"));
    corrected(plant, &prior, 1.0)
}

/// The control problem that the filter's is, transposed; `None` if `q` is no probability.
fn mirrored(plant: &Plant, q: f64) -> Option<LoopProblem> {
    Some(LoopProblem {
        a: plant.a.transpose(),
        b: plant.c.transpose(),
        q: plant.process_noise.clone(),
        r: plant.measurement_noise.clone(),
        link: DelayDistribution::new(vec![q]).ok()?,
        length: 1,
        default_input: DefaultInput::Zero,
    })
}

/// One step ahead: `A X A' + W`.
pub(super) fn predicted(plant: &Plant, posterior: &DMatrix<f64>) -> DMatrix<f64> {
    symmetric(&plant.a * posterior * plant.a.transpose() + &plant.process_noise)
}

/// `X - q X C' (C X C' + V)^-1 C X`: what a measurement that comes with probability `q` leaves, by its mean.
pub(super) fn corrected(plant: &Plant, prior: &DMatrix<f64>, q: f64) -> DMatrix<f64> {
    let mut seen = &plant.c * prior;
    let innovation = symmetric(&seen * plant.c.transpose() + &plant.measurement_noise);
    // In units in which each innovation has variance 1: outputs of other units must not drown in each other's rounding.
    let deviation = innovation.diagonal().map(|variance| if variance > 0.0 { variance.sqrt() } else { 1.0 });
    for (mut row, deviation) in seen.row_iter_mut().zip(deviation.iter()) {
        row /= *deviation;
    }
    let scaled = innovation.map_with_location(|i, j, entry| entry / (deviation[i] * deviation[j]));
    let parts = SymmetricEigen::new(scaled);
    let mut corrected = prior.clone();
    for (variance, direction) in parts.eigenvalues.iter().zip(parts.eigenvectors.column_iter()) {
        // A variance lost in rounding is left out, which keeps the covariance on the large side.
        if *variance > 0.0 {
            let gain = seen.tr_mul(&direction);
            corrected -= &gain * gain.transpose() * (q / variance);
        }
    }
    symmetric(corrected)
}

fn symmetric(matrix: DMatrix<f64>) -> DMatrix<f64> {
    (&matrix + matrix.transpose()) * 0.5
}
