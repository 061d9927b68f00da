//! The mean-square rate of the loop as it runs around a plant that is not the design's.
//!
//! The actuator's link is the design's, so that the in-flight form holds for any plant and any linear law: the cost of
//! given gains is `(P, S, Y, N_t)` over the loop's state, and one step back is linear in it (THEORY 5).
//! There is one such cost for each state of the chain of measurement arrivals, and the one a step later is the mean over
//! the states that may follow, since which measurements arrive depends on nothing else in the loop.
//!
//! Where nothing is left to chance, packets that all meet one delay on either link, the loop is a single matrix (`certain`).

use super::arrivals::Arrivals;
use super::certain;
use super::change::{Change, Dynamics};
use super::filter::{Coordinates, Situation, state_known, with_filter};
use crate::design::Plant;
use crate::solve::{Law, row_major, spectral_radius};
use nalgebra::DMatrix;
use slqg::synthesis::{Dimensions, Problem, Synthesis};

/// Applications that the search for the rate takes as one, in each of its spaces.
const STRIDES: [usize; 3] = [1, 4, 4];
/// Steps back that the search for a rate takes, for each multiplication of matrices that one takes where nothing is left to chance.
const CERTAIN: usize = 8;
/// Entries beyond this are beyond all that a rate can be computed of.
const LARGEST: f64 = 1e60;

/// The controller as designed, in the loop's own coordinates.
#[derive(Debug, Clone)]
pub(super) struct LoopAsRun {
    design: Plant,
    dimensions: Dimensions,
    survival: Vec<f64>,
    coordinates: Coordinates,
    situations: Vec<Situation>,
    next: Vec<Vec<(usize, f64)>>,
}

impl LoopAsRun {
    /// The state is known. `design`, `law`: in any units; `survival`: of the link to the actuator.
    pub(super) fn state_known(design: &Plant, law: &Law, survival: &[f64]) -> Self {
        let next = vec![vec![(0, 1.0)]];
        Self::new(design, law, survival, Coordinates::State, state_known(law), next)
    }

    /// The state is estimated.
    pub(super) fn with_filter(design: &Plant, law: &Law, survival: &[f64], arrivals: &Arrivals) -> Self {
        let (coordinates, situations) = with_filter(design, law, arrivals);
        Self::new(design, law, survival, coordinates, situations, arrivals.next.clone())
    }

    fn new(
        design: &Plant,
        law: &Law,
        survival: &[f64],
        coordinates: Coordinates,
        situations: Vec<Situation>,
        next: Vec<Vec<(usize, f64)>>,
    ) -> Self {
        let dimensions = Dimensions {
            states: coordinates.size(design.states()),
            inputs: design.inputs(),
            length: law.length,
            default_input: law.default_input,
        };
        let (design, survival) = (design.clone(), survival.to_vec());
        Self { design, dimensions, survival, coordinates, situations, next }
    }

    /// Multiplications of one step back, in all situations.
    pub(super) fn work(&self) -> usize {
        if self.situations.len() == 1 && certain::is_certain(&self.survival) {
            // A rate costs a few such steps, where others take hundreds.
            return self.dimensions.gain_columns().pow(3) / CERTAIN;
        }
        self.situations.len() * self.dimensions.gain_columns().pow(3)
    }

    /// The rate around the plant with this change; infinite where that is out of the range of numbers.
    pub(super) fn rate(&self, change: Change, factor: f64) -> f64 {
        self.rate_around(change.plant(&self.design, factor).as_ref())
    }

    /// The design's plant, in the loop's units.
    pub(super) fn designed(&self) -> &Plant {
        &self.design
    }

    /// The rate around this plant; infinite around none, and where it is out of the range of numbers.
    pub(super) fn rate_around(&self, plant: Option<&Dynamics>) -> f64 {
        let in_range = |matrix: &DMatrix<f64>| matrix.iter().all(|entry| entry.abs() < LARGEST);
        match plant.filter(|(a, b)| in_range(a) && in_range(b)) {
            Some(plant) => self.rate_in_range(plant),
            None => f64::INFINITY,
        }
    }

    fn rate_in_range(&self, plant: &Dynamics) -> f64 {
        let dimensions = self.dimensions;
        let (step, drive) = self.coordinates.step(plant);
        if let ([situation], true) = (self.situations.as_slice(), certain::is_certain(&self.survival)) {
            let step = &step * &situation.settle;
            return certain::rate(&step, &drive, &situation.gains, &self.survival, dimensions.default_input);
        }
        let drive = row_major(&drive);
        let steps: Vec<_> =
            self.situations.iter().map(|situation| row_major(&(&step * &situation.settle))).collect();
        let (no_q, no_r) = (
            vec![0.0; dimensions.states * dimensions.states],
            vec![0.0; dimensions.inputs * dimensions.inputs],
        );
        let mut workspaces = vec![vec![0.0; dimensions.workspace_len()]; self.situations.len()];
        let mut syntheses: Vec<_> = steps
            .iter()
            .zip(&self.situations)
            .zip(&mut workspaces)
            .map(|((a, situation), workspace)| {
                let problem =
                    Problem { dimensions, a, b: &drive, q: &no_q, r: &no_r, survival: &self.survival };
                let mut synthesis = Synthesis::new(problem, workspace).expect("made to the dimensions");
                synthesis.set_gains(&row_major(&situation.gains));
                synthesis
            })
            .collect();
        // Inside the cone of costs: the square of the loop's state, in which all of it shows.
        let mut one = vec![0.0; dimensions.value_len()];
        let squares = dimensions.states * dimensions.states;
        one[..squares].iter_mut().step_by(dimensions.states + 1).for_each(|entry| *entry = 1.0);
        let size = one.len();
        let mut mean = vec![0.0; size];
        spectral_radius(&one.repeat(self.situations.len()), STRIDES, |from, to| {
            let parts = syntheses.iter_mut().zip(&self.next).zip(to.chunks_exact_mut(size));
            for ((synthesis, next), to) in parts {
                mean.fill(0.0);
                for &(state, probability) in next {
                    let after = &from[state * size..][..size];
                    mean.iter_mut().zip(after).for_each(|(sum, value)| *sum += probability * value);
                }
                synthesis.value_mut().copy_from_slice(&mean);
                synthesis.fixed_step();
                to.copy_from_slice(synthesis.value());
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::modes;
    use crate::design::{DelayDistribution, Design, Link};
    use crate::estimation::kalman_covariance;
    use crate::solve::{LoopProblem, Method, solve};

    const CRITICAL: &str = include_str!("../../../designs/critical.toml");

    fn critical(actuator: &[f64], sensor: &[f64], length: usize) -> (Design, LoopAsRun) {
        let link =
            |delays: &[f64]| Link::independent(DelayDistribution::new(delays.to_vec()).expect("a link"));
        let mut design = Design::parse(CRITICAL, "critical.toml").expect("a design");
        design.network.controller_to_actuator = link(actuator);
        design.network.sensor_to_controller = link(sensor);
        design.controller.sequence_length = length;
        // Noise that leaves something to estimate.
        design.plant.measurement_noise *= 1e6;
        let problem = LoopProblem::of(&design);
        let law = solve(&problem, Method::InFlight).law;
        let arrivals = Arrivals::new(&design.network.sensor_to_controller.delays, 11, 4);
        let found = LoopAsRun::with_filter(&design.plant, &law, &problem.survival(), &arrivals);
        (design, found)
    }

    #[test]
    fn with_a_late_sensor_the_rate_is_that_of_the_loop_written_down_cycle_by_cycle() {
        let (design, found) = critical(&[1.0], &[0.0, 1.0], 1);
        let plant = &design.plant;
        let law = solve(&LoopProblem::of(&design), Method::InFlight).law;
        let inverse = plant.measurement_noise.clone().try_inverse().expect("positive");
        let gain = kalman_covariance(plant) * plant.c.transpose() * inverse;
        for factor in [1.0, 0.6, 1.5, 2.5] {
            // x_k, x_(k-1), the prediction for k-1 and u_(k-1): the measurement of k-1 comes in k.
            let mut matrix = DMatrix::zeros(7, 7);
            let mut prediction = DMatrix::zeros(2, 7);
            prediction.view_mut((0, 2), (2, 2)).copy_from(&(&plant.a * &gain * &plant.c));
            prediction.view_mut((0, 4), (2, 2)).copy_from(&(&plant.a - &plant.a * &gain * &plant.c));
            prediction.view_mut((0, 6), (2, 1)).copy_from(&plant.b);
            let input = &law.lx * &prediction;
            let mut next = &plant.b * &input * factor;
            let mut own = next.columns_mut(0, 2);
            own += &plant.a;
            matrix.view_mut((0, 0), (2, 7)).copy_from(&next);
            matrix.view_mut((2, 0), (2, 2)).fill_with_identity();
            matrix.view_mut((4, 0), (2, 7)).copy_from(&prediction);
            matrix.view_mut((6, 0), (1, 7)).copy_from(&input);
            let values = modes::computed_eigenvalues(&matrix).expect("eigenvalues");
            let radius = values.iter().map(|value| value.norm()).fold(0.0, f64::max);
            let rate = found.rate(Change::InputGain, factor);
            assert!((rate - radius * radius).abs() < 1e-8 * rate, "{factor}: {rate}, {}", radius * radius);
        }
    }

    #[test]
    fn around_the_design_s_plant_the_rate_is_the_slower_of_law_and_filter() {
        let (design, found) = critical(&[0.25; 4], &[1.0], 4);
        let known = solve(&LoopProblem::of(&design), Method::InFlight).mean_square_rate;
        let rate = found.rate(Change::InputGain, 1.0);
        assert!((rate - known).abs() < 1e-8, "{rate}, {known}");
    }

    #[test]
    fn arrivals_told_apart_that_make_no_difference_change_nothing() {
        // A measurement that surely comes a cycle later after all tells what one that has come tells: a chain of one state.
        let certain = critical(&[0.5, 0.5], &[1.0], 3).1.rate(Change::InputGain, 1.2);
        let nearly = critical(&[0.5, 0.5], &[1.0 - 1e-7, 1e-7], 3).1.rate(Change::InputGain, 1.2);
        assert!((certain - nearly).abs() < 1e-5, "{certain}, {nearly}");
    }
}
