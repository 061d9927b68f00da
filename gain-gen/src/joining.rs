//! What a controller holds of the state when it joins a loop that runs: after a restart, or when it was added later.
//!
//! The design's initial state is that of cycle 0. Later the state may be anywhere, and an estimator that is sure of the initial
//! one would take long to unlearn it.

use crate::design::Plant;
use nalgebra::{DMatrix, DVector};

/// Outputs may be this many standard deviations of the measurement noise away from zero.
const RANGE: f64 = 100.0;
/// Where measurements say nothing of a state, its standard deviation is this many times the largest it is known to have.
const UNKNOWN: f64 = 1e3;

/// Covariance of the state about zero for an estimator that begins in the middle: as after `measurements` measurements
/// without any knowledge before them, 100 times as uncertain.
///
/// ```text
/// P = (I / 100^2 + D)^-1,    I = sum_{k < measurements} (C A^k)^T V^-1 (C A^k)
/// ```
///
/// So it is wide in units of what the sensors can tell, and no wider than single precision can bear. `D` is small, and there
/// for states that no sensor sees.
pub fn joining_covariance(plant: &Plant, measurements: usize) -> DMatrix<f64> {
    let states = plant.states();
    // A sensor without noise would tell everything at once.
    let noise = plant
        .measurement_noise
        .clone()
        .pseudo_inverse(0.0)
        .unwrap_or_else(|_| DMatrix::identity(plant.outputs(), plant.outputs()));
    let mut information = DMatrix::zeros(states, states);
    let mut observed = plant.c.clone();
    for _ in 0..measurements.max(states) {
        information += observed.transpose() * &noise * &observed;
        observed *= &plant.a;
    }
    let spread = DVector::from_fn(states, |state, _| {
        let known = plant.initial_covariance[(state, state)]
            + plant.initial_mean[state].powi(2)
            + plant.process_noise[(state, state)];
        if known > 0.0 { known } else { 1.0 }
    });
    let least = spread.map(|known| 1.0 / (UNKNOWN.powi(2) * known));
    let precision = information / RANGE.powi(2) + DMatrix::from_diagonal(&least);
    let covariance =
        precision.cholesky().map_or_else(|| DMatrix::from_diagonal(&spread), |factor| factor.inverse());
    (&covariance + covariance.transpose()) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::Design;

    fn plant(a: &str, c: &str) -> Plant {
        let text = format!(
            "name = 'cart'
            [plant]
            sample_time = 0.1
            discrete = {{ a = {a}, b = [[0], [0.1]] }}
            c = [{c}]
            process_noise = [[0.01, 0], [0, 0.01]]
            measurement_noise = [[0.04]]
            initial_mean = [0, 0]
            initial_covariance = [[0, 0], [0, 0]]
            [cost]
            q = [[1, 0], [0, 1]]
            r = [[1]]
            [network]
            controller_to_actuator.delays = [1]
            sensor_to_controller.delays = [1]
            [controller]
            sequence_length = 1"
        );
        Design::parse(&text, "cart.toml").unwrap().plant
    }

    const INTEGRATOR: &str = "[[1, 0.1], [0, 1]]";

    #[test]
    fn what_the_sensor_sees_is_as_wide_as_a_hundred_times_its_noise() {
        let covariance = joining_covariance(&plant(INTEGRATOR, "[1, 0]"), 2);
        // The second measurement tells of the position again, as far as the velocity is known.
        let position = covariance[(0, 0)].sqrt() / (100.0 * 0.2);
        assert!((0.7..1.0).contains(&position), "{covariance}");
        assert!(covariance[(1, 1)].sqrt() > 50.0, "the velocity is hardly known: {covariance}");
        let more = joining_covariance(&plant(INTEGRATOR, "[1, 0]"), 11);
        assert!(more[(1, 1)] < 0.1 * covariance[(1, 1)], "more measurements tell more of it: {more}");
    }

    #[test]
    fn a_state_that_no_sensor_sees_stays_unknown_and_finite() {
        let covariance = joining_covariance(&plant("[[0.9, 0.1], [0, 0.9]]", "[0, 1]"), 11);
        assert!((covariance[(0, 0)].sqrt() / (1e3 * 0.1) - 1.0).abs() < 0.05, "{covariance}");
        assert!(covariance.iter().all(|value| value.is_finite()));
    }
}
