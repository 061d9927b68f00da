//! What an actuator plays: the age of a sequence, or the default input; and how likely each is where it is not known.
//!
//! A ground room: everything that speaks of ages stands on it, and it stands on nothing but numbers and the clock.

mod modes;

use crate::{Scalar, Tick};
use nalgebra::SVector;

pub use modes::{Ages, Modes};

/// What the actuator applies when its buffer has run out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DefaultInput {
    /// Zero input, thesis (3.9).
    Zero,
    /// The input applied last, thesis 3.6.1.
    Hold,
}

impl DefaultInput {
    /// In-flight inputs the control law for sequences of `length` inputs takes, `n_v`. THEORY 3.
    #[inline]
    pub const fn in_flight(self, length: usize) -> usize {
        match self {
            Self::Zero => length.saturating_sub(1),
            Self::Hold => length,
        }
    }

    /// As in design files, on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zero => "zero",
            Self::Hold => "hold",
        }
    }
}

/// What the actuator played in one cycle: theta of thesis (3.11).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Age {
    /// The entry of a sequence made this many cycles before.
    Steps(u8),
    /// The default input: the buffer was empty or had run out (theta = N in the thesis).
    Empty,
}

impl Age {
    /// Cycles since the played sequence was made; `None` for the default input.
    #[inline]
    pub const fn steps(self) -> Option<usize> {
        match self {
            Self::Steps(steps) => Some(steps as usize),
            Self::Empty => None,
        }
    }

    /// The age at place `place` among those of sequences of `length` inputs, newest first and the empty buffer last.
    #[inline(always)]
    pub(crate) const fn at(place: usize, length: usize) -> Self {
        if place < length && place <= u8::MAX as usize { Self::Steps(place as u8) } else { Self::Empty }
    }
}

/// What left the actuator in one cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Applied<T, const NU: usize> {
    /// The cycle.
    pub tick: Tick,
    /// The input after saturation, in input units; always finite.
    pub input: SVector<T, NU>,
    /// Where it came from.
    pub age: Age,
}

/// What the actuator played in one cycle, as far as is known.
#[derive(Debug, Clone, Copy)]
pub enum Played<'m, T, const NU: usize> {
    /// That age for certain, and the input it made the actuator apply.
    Known(Age, SVector<T, NU>),
    /// One of several. `oldest` is what was applied if that was a sequence's last input.
    Believed {
        /// How likely each age is.
        modes: Modes<'m, T, NU>,
        /// In input units.
        oldest: SVector<T, NU>,
    },
}

impl<T: Scalar, const NU: usize> Played<'_, T, NU> {
    /// What an actuator plays to which nothing was ever sent.
    pub fn nothing() -> Self {
        Self::Known(Age::Empty, SVector::zeros())
    }
}
