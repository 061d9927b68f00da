//! Gains that the device solves for itself when its link has changed.

use super::Laws;
use crate::design::{self, DESIGN, INPUTS, STATES, Scalar, TUNING, TUNING_MEMORY};
use crate::dimensions::SLICES;
use slqg::{
    controller::Law,
    tuning::Parameters,
    wire::{self, GainsAnswer, GainsPart, Verdict},
};

/// The core's tuner.
pub struct Tuned<'m> {
    tuner: design::Tuner<'m>,
}

impl<'m> Tuned<'m> {
    /// A tuner for the node's design; `None` if there can be none, which the simulator tells beforehand.
    pub fn new(memory: &'m mut [Scalar; TUNING_MEMORY]) -> Option<Self> {
        let tuner = design::Tuner::new(&DESIGN, TUNING, Parameters::DEFAULT, memory).ok()?;
        Some(Self { tuner })
    }
}

#[cfg(target_os = "none")]
impl Tuned<'static> {
    /// The program's only tuner.
    ///
    /// # Panics
    /// If there is one already, or the design cannot be tuned.
    pub fn only() -> Self {
        const MEMORY: [Scalar; TUNING_MEMORY] = [0.0; TUNING_MEMORY];
        let memory = cortex_m::singleton!(: [Scalar; TUNING_MEMORY] = MEMORY);
        let Some(tuned) = memory.and_then(|memory| Self::new(memory)) else {
            panic!("this design cannot be tuned")
        };
        tuned
    }
}

impl Laws for Tuned<'_> {
    fn law(&self) -> Option<Law<'_, Scalar, STATES, INPUTS>> {
        self.tuner.law()
    }

    fn check_memory(&mut self, numbers: usize) -> bool {
        self.tuner.check_memory(numbers)
    }

    /// It solves for its gains itself, and takes none.
    fn take(&mut self, _part: &GainsPart<'_>) -> GainsAnswer {
        GainsAnswer { received: 0, verdict: Verdict::Dimensions }
    }

    fn observe(&mut self, controller: &design::Controller<'_>) {
        self.tuner.observe(controller);
    }

    /// As many slices as the build says there is time for, always: the simulator does as many, and time it has not.
    fn work(&mut self) -> Option<wire::Tuned> {
        (0..SLICES).find_map(|_| self.tuner.slice()).map(wire::Tuned::from)
    }
}
