//! The true plant: linear, in `f64`, driven by Gaussian noise. Thesis (3.1)-(3.3).
//!
//! Dimensions are those of a size class; states, inputs and outputs beyond the design's stay exactly zero.

use crate::random::{Purpose, stream};
use gain_gen::design;
use nalgebra::{DMatrix, SMatrix, SVector};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Constant data of the true plant.
#[derive(Debug, Clone)]
pub struct TruePlant<const NX: usize, const NU: usize, const NY: usize> {
    states: usize,
    outputs: usize,
    a: SMatrix<f64, NX, NX>,
    b: SMatrix<f64, NX, NU>,
    c: SMatrix<f64, NY, NX>,
    process_noise_root: SMatrix<f64, NX, NX>,
    measurement_noise_root: SMatrix<f64, NY, NY>,
    initial_mean: SVector<f64, NX>,
    initial_root: SMatrix<f64, NX, NX>,
}

/// `matrix` in the upper left corner of a larger one that is zero otherwise.
pub fn padded<const R: usize, const C: usize>(matrix: &DMatrix<f64>) -> SMatrix<f64, R, C> {
    SMatrix::from_fn(|row, column| matrix.get((row, column)).copied().unwrap_or(0.0))
}

/// Symmetric root of a positive semidefinite matrix.
fn root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = covariance.clone().symmetric_eigen();
    let roots = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
    &eigen.eigenvectors * roots * eigen.eigenvectors.transpose()
}

impl<const NX: usize, const NU: usize, const NY: usize> TruePlant<NX, NU, NY> {
    /// The design's plant, padded with zeros to the size class.
    pub fn new(plant: &design::Plant) -> Self {
        let mean = DMatrix::from_column_slice(plant.states(), 1, plant.initial_mean.as_slice());
        Self {
            states: plant.states(),
            outputs: plant.outputs(),
            a: padded(&plant.a),
            b: padded(&plant.b),
            c: padded(&plant.c),
            process_noise_root: padded(&root(&plant.process_noise)),
            measurement_noise_root: padded(&root(&plant.measurement_noise)),
            initial_mean: padded(&mean),
            initial_root: padded(&root(&plant.initial_covariance)),
        }
    }

    /// Scale of the state: the largest of its initial mean, initial deviation and deviation per cycle.
    pub fn scale(&self) -> f64 {
        self.initial_mean.norm().max(self.initial_root.norm()).max(self.process_noise_root.norm())
    }
}

/// The plant in one run.
#[derive(Debug, Clone)]
pub struct PlantRun<'p, const NX: usize, const NU: usize, const NY: usize> {
    plant: &'p TruePlant<NX, NU, NY>,
    state: SVector<f64, NX>,
    process_noise: ChaCha8Rng,
    measurement_noise: ChaCha8Rng,
}

impl<'p, const NX: usize, const NU: usize, const NY: usize> PlantRun<'p, NX, NU, NY> {
    /// The plant at the beginning of run number `run`, its state drawn from the initial distribution.
    pub fn new(plant: &'p TruePlant<NX, NU, NY>, seed: u64, run: u64) -> Self {
        let mut initial = stream(seed, run, Purpose::InitialState);
        Self {
            state: plant.initial_mean + plant.initial_root * normal(plant.states, &mut initial),
            plant,
            process_noise: stream(seed, run, Purpose::ProcessNoise),
            measurement_noise: stream(seed, run, Purpose::MeasurementNoise),
        }
    }

    /// The state.
    pub fn state(&self) -> &SVector<f64, NX> {
        &self.state
    }

    /// Measures the outputs: `y = C x + v`.
    pub fn measure(&mut self) -> SVector<f64, NY> {
        let noise = normal(self.plant.outputs, &mut self.measurement_noise);
        self.plant.c * self.state + self.plant.measurement_noise_root * noise
    }

    /// Moves on by one cycle: `x+ = A x + B u + w`.
    pub fn step(&mut self, input: &SVector<f64, NU>) {
        let noise = normal(self.plant.states, &mut self.process_noise);
        self.state = self.plant.a * self.state + self.plant.b * input + self.plant.process_noise_root * noise;
    }
}

/// Independent standard normal numbers in the first `count` entries: padding draws none, so that the size class does
/// not change what is simulated.
fn normal<const D: usize>(count: usize, random: &mut ChaCha8Rng) -> SVector<f64, D> {
    SVector::from_fn(|row, _| if row < count { random.sample(StandardNormal) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_of_a_singular_covariance_squares_to_it() {
        let covariance = DMatrix::from_row_slice(3, 3, &[4.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        let root = root(&covariance);
        assert!((&root * root.transpose() - covariance).amax() < 1e-12);
    }
}
