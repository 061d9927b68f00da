//! [`Errors`]: how bits are disturbed, alone or in bursts. What nodes make of it is `bus`.

use super::{
    length::Length,
    time::{Rates, SECOND, Time},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// How bits on the bus are disturbed. Every node sees the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Errors {
    /// Not at all.
    #[default]
    None,
    /// Each bit alone.
    Independent {
        /// Probability that a bit is disturbed, 0 to below 1.
        probability: f64,
    },
    /// In phases of exponentially distributed length that take turns (Gilbert 1960, Elliott 1963, in time).
    Bursts {
        /// Phase with few errors.
        good: Phase,
        /// Phase with many.
        bad: Phase,
    },
}

/// One of the two phases of a bursty bus.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Phase {
    /// Mean length, in seconds.
    pub mean: f64,
    /// Probability that a bit is disturbed, 0 to below 1.
    pub probability: f64,
}

/// A probability or a mean length that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ErrorsError {
    /// Not within 0 and 1.
    #[error("found {0} as probability of a bit error: it must be at least 0 and below 1")]
    Probability(f64),
    /// Not a positive number.
    #[error("found {0} s as mean length of a phase: it must be at least 1e-9 s and finite")]
    Mean(f64),
}

impl Errors {
    pub(super) fn check(self) -> Result<(), ErrorsError> {
        let phases = match self {
            Errors::None => return Ok(()),
            Errors::Independent { probability } => [Phase { mean: 1.0, probability }; 2],
            Errors::Bursts { good, bad } => [good, bad],
        };
        for Phase { mean, probability } in phases {
            if !(0.0..1.0).contains(&probability) {
                return Err(ErrorsError::Probability(probability));
            }
            if !(mean >= 1e-9 && mean.is_finite()) {
                return Err(ErrorsError::Mean(mean));
            }
        }
        Ok(())
    }
}

/// A phase as the process needs it: with the hazard `-ln(1 - p)` of a bit.
#[derive(Debug, Clone, Copy)]
struct Exposure {
    mean: f64,
    hazard: f64,
}

/// Draws the bits that are disturbed, one draw per disturbed bit.
///
/// A bit of error probability p takes `h = -ln(1 - p)` off a budget that is exponentially distributed with mean 1;
/// the bit at which the budget runs out is disturbed. With constant p this is the geometric law, and the law has no
/// memory: what is left of the budget goes on to the next frame and the next phase.
#[derive(Debug, Clone)]
pub(super) struct ErrorProcess {
    /// None on a bus without errors.
    phases: Option<[Exposure; 2]>,
    bad: bool,
    phase_end: Time,
    budget: f64,
    random: ChaCha8Rng,
}

impl ErrorProcess {
    /// In the phase that the long run makes likely.
    pub(super) fn new(errors: Errors, mut random: ChaCha8Rng) -> Self {
        let exposure = |phase: Phase| Exposure { mean: phase.mean, hazard: -libm::log1p(-phase.probability) };
        let (phases, bad, phase_end) = match errors {
            Errors::None => (None, false, Time::MAX),
            Errors::Independent { probability } => {
                let only = exposure(Phase { mean: f64::INFINITY, probability });
                (Some([only; 2]), false, Time::MAX)
            }
            Errors::Bursts { good, bad } => {
                let starts_bad = random.random::<f64>() < bad.mean / (good.mean + bad.mean);
                (Some([exposure(good), exposure(bad)]), starts_bad, 0)
            }
        };
        let budget = exponential(&mut random);
        let mut process = ErrorProcess { phases, bad, phase_end, budget, random };
        if phase_end == 0 {
            process.phase_end = process.draw_length();
        }
        process
    }

    /// Index of the first disturbed bit of a frame whose SOF begins at `start`.
    pub(super) fn first(&mut self, start: Time, length: Length, rates: Rates) -> Option<u32> {
        let phases = self.phases?;
        let mut bit = 0;
        loop {
            while self.phase_end <= start + length.offset(bit, rates) {
                self.bad = !self.bad;
                self.phase_end = self.phase_end.saturating_add(self.draw_length());
            }
            let phase_bits = length.begun_before(self.phase_end - start, rates);
            let hazard = phases[usize::from(self.bad)].hazard;
            let until_error = self.budget / hazard;
            if until_error < f64::from(phase_bits - bit) {
                self.budget = exponential(&mut self.random);
                return Some(bit + until_error as u32);
            }
            self.budget -= hazard * f64::from(phase_bits - bit);
            bit = phase_bits;
            if bit == length.bits() {
                return None;
            }
        }
    }

    /// Echo of an error flag by the nodes that notice it through the flag itself, 0 to 6 bits.
    pub(super) fn echo(&mut self) -> u32 {
        self.random.random_range(0..=6)
    }

    fn draw_length(&mut self) -> Time {
        let mean = self.phases.map_or(f64::INFINITY, |phases| phases[usize::from(self.bad)].mean);
        (exponential(&mut self.random) * mean * SECOND as f64).max(1.0) as Time
    }
}

/// Exponentially distributed with mean 1.
pub(super) fn exponential(random: &mut ChaCha8Rng) -> f64 {
    -libm::log1p(-random.random::<f64>())
}
