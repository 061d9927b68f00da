//! Memory for the core's ends: as much as a design takes, allocated once and lent to run after run.

use crate::fitted::{Fitted, Unfit};
use nalgebra::SVector;
use slqg::{
    Scalar, actuator,
    controller::{Memory, Sizes},
    estimator::{Cycle, Estimate},
};

/// What a controller, an actuator and a tuner are lent.
#[derive(Debug, Clone)]
pub struct Lent<T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    cycles: Vec<Cycle<T, NU, NY>>,
    estimates: Vec<Estimate<T, NX>>,
    ages: Vec<T>,
    sent: Vec<bool>,
    inputs: Vec<SVector<T, NU>>,
    actuator: Vec<SVector<T, NU>>,
    tuner: Vec<T>,
}

/// Memory by who is lent it: controller, actuator, tuner.
pub type Parts<'m, T, const NX: usize, const NU: usize, const NY: usize> =
    (Memory<'m, T, NX, NU, NY>, &'m mut [SVector<T, NU>], &'m mut [T]);

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Lent<T, NX, NU, NY> {
    /// Memory for the ends of `fitted`.
    ///
    /// # Errors
    /// If the design does not fit the scalar.
    pub fn for_ends(fitted: &Fitted<T, NX, NU, NY>) -> Result<Self, Unfit> {
        let design = fitted.design()?;
        let Sizes { cycles, estimates, ages, sent, inputs } = design.sizes();
        Ok(Self {
            cycles: vec![Cycle::EMPTY; cycles],
            estimates: vec![Estimate::EMPTY; estimates],
            ages: vec![T::zero(); ages],
            sent: vec![false; sent],
            inputs: vec![SVector::zeros(); inputs],
            actuator: vec![SVector::zeros(); actuator::memory_len(design.gains.length())],
            tuner: vec![T::zero(); fitted.tuning_memory()],
        })
    }

    /// Lends it.
    pub fn lend(&mut self) -> Parts<'_, T, NX, NU, NY> {
        let Self { cycles, estimates, ages, sent, inputs, actuator, tuner } = self;
        (Memory { cycles, estimates, ages, sent, inputs }, actuator, tuner)
    }
}
