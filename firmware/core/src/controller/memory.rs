//! What a controller is lent to remember in.

use crate::{
    Scalar,
    estimator::{Cycle, Estimate, estimates_len},
};
use nalgebra::SVector;

/// How much memory a controller is lent, in entries of the slices of [`Memory`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sizes {
    /// In [`Memory::cycles`].
    pub cycles: usize,
    /// In [`Memory::estimates`].
    pub estimates: usize,
    /// In [`Memory::ages`].
    pub ages: usize,
    /// In [`Memory::sent`].
    pub sent: usize,
    /// In [`Memory::inputs`].
    pub inputs: usize,
}

impl core::fmt::Display for Sizes {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { cycles, estimates, ages, sent, inputs } = self;
        write!(
            f,
            "{cycles} cycles, {estimates} estimates, {ages} ages, {sent} marks of what was sent, {inputs} inputs"
        )
    }
}

impl Sizes {
    /// For sequences of `length` inputs and an estimator that remembers `history` cycles, the current one included and at
    /// least 2, and keeps `estimates` at once. Saturates: nobody has so much memory.
    pub const fn of(length: usize, history: usize, estimates: usize) -> Self {
        let history = if history < 2 { 2 } else { history };
        // One more than is remembered: the cycle that the oldest one follows.
        let cycles = history.saturating_add(1);
        // What was sent may be applied for as long as a sequence lasts, and told of as late as is remembered; and one that may
        // be sent next.
        let sent = length.saturating_add(cycles);
        Self {
            cycles,
            estimates: estimates_len(cycles, estimates),
            ages: cycles.saturating_mul(length.saturating_add(1)),
            sent,
            inputs: sent.saturating_add(SCRATCH).saturating_mul(length),
        }
    }

    /// The same for an estimator that is told the mean of what may be applied, [`crate::estimator::Merging::Linear`]: it needs
    /// neither ages nor what was sent.
    pub const fn linear(length: usize, history: usize) -> Self {
        let Self { cycles, .. } = Self::of(length, history, 1);
        // One sequence that may be sent, the place of the one before, and behind them the expected inputs, which are carried on.
        let inputs = length.saturating_mul(SENT_LINEAR + 1 + SCRATCH);
        Self { cycles, estimates: cycles, ages: 0, sent: SENT_LINEAR, inputs }
    }

    /// The same with so many numbers to work in: [`crate::event::Trigger::numbers_len`].
    #[must_use]
    pub const fn with_numbers(self, numbers: usize) -> Self {
        Self { ages: self.ages.saturating_add(numbers), ..self }
    }

    /// Of the inputs, those in flight of sequences of `length`; [`SCRATCH`] sequences follow.
    pub(super) const fn in_flight(&self, length: usize) -> usize {
        self.inputs.saturating_sub(SCRATCH.saturating_mul(length))
    }

    /// Whether `other` fits into it.
    pub(super) const fn holds(&self, other: &Self) -> bool {
        self.cycles >= other.cycles
            && self.estimates >= other.estimates
            && self.ages >= other.ages
            && self.sent >= other.sent
            && self.inputs >= other.inputs
    }
}

/// Places of what was sent where it is not remembered.
const SENT_LINEAR: usize = 2;
/// Sequences beside those sent: expected inputs, feedforward, what is displaced, and room to work in.
pub(super) const SCRATCH: usize = 4;

/// Memory that a controller is lent; [`crate::controller_memory`] declares some, and [`Sizes`] says how much it takes. What it
/// holds before does not matter.
#[derive(Debug)]
pub struct Memory<'m, T: Scalar, const NX: usize, const NU: usize, const NY: usize> {
    /// What the estimator remembers of each cycle.
    pub cycles: &'m mut [Cycle<T, NU, NY>],
    /// Its estimates.
    pub estimates: &'m mut [Estimate<T, NX>],
    /// Probabilities of the ages in each cycle, and numbers to work in.
    pub ages: &'m mut [T],
    /// In which cycles a sequence was sent.
    pub sent: &'m mut [bool],
    /// The inputs of these sequences, and room for more.
    pub inputs: &'m mut [SVector<T, NU>],
}

impl<T: Scalar, const NX: usize, const NU: usize, const NY: usize> Memory<'_, T, NX, NU, NY> {
    /// How much it is.
    pub fn sizes(&self) -> Sizes {
        Sizes {
            cycles: self.cycles.len(),
            estimates: self.estimates.len(),
            ages: self.ages.len(),
            sent: self.sent.len(),
            inputs: self.inputs.len(),
        }
    }
}

/// Declares a type that owns the memory of one controller: `new()` makes it, in a constant if need be, and `lend()` lends it.
///
/// Arguments: visibility and name; scalar, states, inputs, outputs; [`Sizes`].
///
/// ```
/// use slqg::controller::Sizes;
/// slqg::controller_memory!(struct Memory: f32, 2, 1, 1; Sizes::of(4, 6, 1));
/// let mut memory = Memory::new();
/// assert_eq!(memory.lend().sizes(), Sizes::of(4, 6, 1));
/// ```
#[macro_export]
macro_rules! controller_memory {
    ($(#[$attribute:meta])* $visible:vis struct $name:ident: $scalar:ty, $nx:expr, $nu:expr, $ny:expr; $sizes:expr) => {
        $(#[$attribute])*
        #[derive(Debug)]
        $visible struct $name {
            cycles: [$crate::estimator::Cycle<$scalar, { $nu }, { $ny }>; { $sizes }.cycles],
            estimates: [$crate::estimator::Estimate<$scalar, { $nx }>; { $sizes }.estimates],
            ages: [$scalar; { $sizes }.ages],
            sent: [bool; { $sizes }.sent],
            inputs: [$crate::nalgebra::SVector<$scalar, { $nu }>; { $sizes }.inputs],
        }

        impl $name {
            /// Memory that holds nothing.
            $visible const fn new() -> Self {
                const ZERO: $scalar = 0.0;
                Self {
                    cycles: [const { $crate::estimator::Cycle::EMPTY }; { $sizes }.cycles],
                    estimates: [const { $crate::estimator::Estimate::EMPTY }; { $sizes }.estimates],
                    ages: [ZERO; { $sizes }.ages],
                    sent: [false; { $sizes }.sent],
                    inputs: [const {
                        $crate::nalgebra::SVector::from_array_storage($crate::nalgebra::ArrayStorage([[ZERO; { $nu }]]))
                    }; { $sizes }.inputs],
                }
            }

            /// Lends it.
            $visible fn lend(&mut self) -> $crate::controller::Memory<'_, $scalar, { $nx }, { $nu }, { $ny }> {
                let Self { cycles, estimates, ages, sent, inputs } = self;
                $crate::controller::Memory { cycles, estimates, ages, sent, inputs }
            }
        }
    };
}
