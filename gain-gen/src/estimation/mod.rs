//! What the estimator can do over the sensor's link: thesis 3.4.1, Theorems 3.3 a) and 3.4 a) and the exact limit between
//! them, and the cost (3.33).
//!
//! | file | what lives there |
//! |---|---|
//! | `limit` | the arrival probability down to which the error stays bounded, exactly |
//! | `cycle` | modes that come round together, and how many losses hide one of them |
//! | `spectrum` | eigenvalues, their uncertainty and their eigenvectors |
//! | `coordinates` | states and outputs without units |
//! | `critical` | the critical probability `q_crit` of the modified Riccati equation |
//! | `channel` | the same over a link whose quality comes and goes |
//! | `riccati` | the modified Riccati equation, solved as the control problem it mirrors |
//! | `covariance` | bounds on the covariance of the estimation error |
//!
//! **The cost.** With the state estimated, `U = Lx xhat + M vbar` differs from the best input for the true state by
//! `Lx e`, where `e` is the estimation error. Completing the square in the Bellman equation (THEORY 4), that costs
//! `e' Lx' Rbar Lx e` a step, and since `Lx = -Rbar^# Gx`,
//!
//! ```text
//! Pi = Lx' Rbar Lx = -Gx' Lx = Q + A' P A - P        (nx x nx; the state block of P_k in (3.33), in every mode)
//! long-run cost per step = tr(P W) + tr(Pi E[e e'])
//! ```
//!
//! `e` depends on the sensor's link and on noise only, not on the actuator's mode, so its covariance can be averaged on
//! its own. `E[e e']` has no closed form; bounds on it give bounds on the cost. They coincide where it is certain by
//! when a measurement is there.

mod channel;
mod coordinates;
mod covariance;
mod critical;
mod cycle;
mod limit;
mod riccati;
mod spectrum;

use crate::channels;
use crate::design::{Acknowledgement, Behaviour, DelayDistribution, Design, Plant};
use crate::solve::{Outcome, Solution};
use covariance::bounds;
use nalgebra::DMatrix;

pub use channel::OnChannel;
pub use covariance::{CovarianceBounds, covariance_bounds};
pub use critical::critical_probability;
pub use limit::{ArrivalLimit, DecidingCycle, arrival_limit};
pub use riccati::{kalman_covariance, modified_riccati};

/// Whether the expected error covariance of the estimator stays bounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EstimationVerdict {
    /// It does: `q_arr` is above the limit, or the modified Riccati equation bounds it (Theorem 3.3 a).
    Stable,
    /// It does not: `q_arr` is below the limit.
    Unstable,
    /// `q_arr` is within rounding of the limit, or between the two that are possible where coincidences of eigenvalues are in doubt.
    Open,
}

impl EstimationVerdict {
    /// As in reports and JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Unstable => "unstable",
            Self::Open => "open",
        }
    }
}

/// Whether measurements come often enough. It depends on the sensor's side alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// `q_arr = Q_sc(N^B)`: probability that a measurement arrives while it still counts.
    pub arrival: f64,
    /// Above this probability the error stays bounded; 0 if it does without any measurement.
    pub limit: f64,
    /// Whether it does: on the channel if there is one.
    pub verdict: EstimationVerdict,
    /// What the channel of the sensor's link makes of it, where that has states.
    pub channel: Option<OnChannel>,
}

impl Sight {
    /// That of the design's sensor.
    pub fn of(design: &Design) -> Self {
        let (plant, link) = (&design.plant, &design.network.sensor_to_controller.delays);
        let buffer = design.controller.measurement_buffer;
        let (limit, _, average) = judged(plant, link, buffer);
        let channel = sight_on_channel(design, average);
        let verdict = channel.map_or(average, |channel| channel.verdict);
        let limit = limit.map_or(0.0, |limit| limit.upper);
        Self { arrival: link.arrival(buffer), limit, verdict, channel }
    }
}

/// What the channel of the sensor's link comes to; `average`: what independent packets with the link's delays do. `None` where
/// that decides: copies of measurements only add to what is known.
fn sight_on_channel(design: &Design, average: EstimationVerdict) -> Option<OnChannel> {
    let link = &design.network.sensor_to_controller;
    if link.behaviour == Behaviour::Independent && average == EstimationVerdict::Stable {
        return None;
    }
    let channel = channels::channel(link)?;
    Some(channel::on_channel(&design.plant, &channel, design.controller.measurement_buffer))
}

/// What is known about the estimator of a design, and what the loop costs with it.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimation {
    /// `q_arr = Q_sc(N^B)`: probability that a measurement arrives while it still counts.
    pub arrival: f64,
    /// `q_crit`: above it the modified Riccati equation has a solution.
    pub critical: f64,
    /// The least `q_arr` for which the error stays bounded; `None` if it does without any measurement.
    pub limit: Option<ArrivalLimit>,
    /// What follows of it, or of the channel of the sensor's link.
    pub verdict: EstimationVerdict,
    /// What the channel of the sensor's link makes of it, where that has states.
    pub channel: Option<OnChannel>,
    /// Bounds on `E[e e']` in steady state, where `e` is the error of the estimate that the controller acts on.
    pub covariance: CovarianceBounds,
    /// At least this is the long-run cost per step; infinite if it has no bound.
    pub cost_lower: f64,
    /// At most this is the long-run cost per step; infinite if no bound is known.
    pub cost_upper: f64,
    /// Of the plant, `nx`.
    states: usize,
}

impl Estimation {
    /// What the verdict rests on.
    pub fn sight(&self) -> Sight {
        let limit = self.limit.as_ref().map_or(0.0, |limit| limit.upper);
        Sight { arrival: self.arrival, limit, verdict: self.verdict, channel: self.channel }
    }

    /// Covariance of the error, `nx x nx`: its bound from above, or the one from below where there is none; zero where there is neither.
    pub fn error_covariance(&self) -> DMatrix<f64> {
        let CovarianceBounds { lower, upper } = &self.covariance;
        let known = upper.as_ref().or(lower.as_ref()).cloned();
        known.unwrap_or_else(|| DMatrix::zeros(self.states, self.states))
    }

    /// The same for a loop that sends at fixed times: `control` is its cost per cycle with the state known, and `weight` what a squared
    /// error of the estimate costs per cycle, `nx x nx`.
    pub(crate) fn of_schedule(self, control: f64, weight: &DMatrix<f64>) -> Self {
        let cost = |covariance: &Option<DMatrix<f64>>| {
            let of_error = |covariance: &DMatrix<f64>| weight.component_mul(covariance).sum().max(0.0);
            covariance.as_ref().map_or(f64::INFINITY, |covariance| control + of_error(covariance))
        };
        let (cost_lower, cost_upper) = (cost(&self.covariance.lower), cost(&self.covariance.upper));
        Self { cost_lower, cost_upper, ..self }
    }

    /// Judges the estimator of `design`, whose gains are `solution`.
    ///
    /// Bounds from above hold for instant acknowledgements only: without, the estimator does not know what was applied.
    /// The cost is that of gains without input limits.
    pub fn of(design: &Design, solution: &Solution) -> Self {
        let (plant, link) = (&design.plant, &design.network.sensor_to_controller.delays);
        let buffer = design.controller.measurement_buffer;
        let (limit, mut covariance, mut verdict) = judged(plant, link, buffer);
        let channel = sight_on_channel(design, verdict);
        if channels::channel(&design.network.sensor_to_controller).is_some() {
            // The bounds for independent packets do not hold there; no filter knows more than one that misses nothing.
            verdict = channel.map_or(verdict, |channel| channel.verdict);
            let is_unstable = verdict == EstimationVerdict::Unstable;
            let lower = (!is_unstable).then(|| kalman_covariance(plant));
            covariance = CovarianceBounds { lower, upper: None };
        }
        let arrival = link.arrival(buffer);
        let critical = critical_probability(plant);
        if design.network.acknowledgement != Acknowledgement::Instant {
            covariance.upper = None;
        }
        let cost = |covariance: &Option<DMatrix<f64>>| match (covariance, solution.outcome) {
            (Some(covariance), Outcome::Converged) => {
                let weight = error_weight(design, solution);
                solution.control_cost(&plant.process_noise) + weight.component_mul(covariance).sum().max(0.0)
            }
            _ => f64::INFINITY,
        };
        let (cost_lower, cost_upper) = (cost(&covariance.lower), cost(&covariance.upper));
        Self {
            arrival,
            critical,
            limit,
            verdict,
            channel,
            covariance,
            cost_lower,
            cost_upper,
            states: plant.states(),
        }
    }
}

/// The limit of arrivals, bounds on the error's covariance, and whether it stays bounded.
fn judged(
    plant: &Plant,
    link: &DelayDistribution,
    buffer: usize,
) -> (Option<ArrivalLimit>, CovarianceBounds, EstimationVerdict) {
    let limit = arrival_limit(plant);
    let mut verdict = verdict(limit.as_ref(), link.arrival(buffer));
    let covariance = bounds(plant, link, buffer, verdict);
    if verdict == EstimationVerdict::Open && covariance.upper.is_some() {
        verdict = EstimationVerdict::Stable;
    }
    (limit, covariance, verdict)
}

/// What follows for measurements that arrive with probability `arrival` from the limit for it.
fn verdict(limit: Option<&ArrivalLimit>, arrival: f64) -> EstimationVerdict {
    match limit {
        Some(limit) if arrival < limit.lower => EstimationVerdict::Unstable,
        Some(limit) if arrival <= limit.upper => EstimationVerdict::Open,
        _ => EstimationVerdict::Stable,
    }
}

/// `Pi = Q + A' P A - P`, nx x nx: what a squared estimation error costs, per step.
fn error_weight(design: &Design, solution: &Solution) -> DMatrix<f64> {
    let (a, p) = (&design.plant.a, &solution.cost_to_go);
    &design.cost.q + a.transpose() * p * a - p
}
