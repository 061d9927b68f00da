//! How an actuator behaves; constant data.

use crate::{
    Scalar,
    integrity::{Part, checksum_of},
    played::DefaultInput,
};
use nalgebra::SVector;

/// Bounds of each input, in input units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<T, const NU: usize> {
    /// Smallest value of each input.
    pub min: SVector<T, NU>,
    /// Largest value of each input; not below `min`.
    pub max: SVector<T, NU>,
    /// Most that each input changes from one cycle to the next, not negative; `None`: any.
    pub rate: Option<SVector<T, NU>>,
}

impl<T: Scalar, const NU: usize> Limits<T, NU> {
    /// The nearest input within the limits.
    pub fn saturate(&self, input: &SVector<T, NU>) -> SVector<T, NU> {
        // Not `clamp`, which panics on limits in the wrong order.
        input.zip_zip_map(&self.min, &self.max, |value, min, max| value.max(min).min(max))
    }
}

/// How an actuator behaves; does not change while it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<T, const NU: usize> {
    /// What is applied when the buffer has run out.
    pub default_input: DefaultInput,
    /// Saturation, if any.
    pub limits: Option<Limits<T, NU>>,
    /// What is applied once the buffer has been empty for too long, if anything but the default input.
    pub safe: Option<Safe<T, NU>>,
}

/// What brings the plant to where it does no harm, as far as an input can.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Safe<T, const NU: usize> {
    /// Cycles in a row with an empty buffer before it is applied.
    pub after: u16,
    /// The input, in input units; within the limits, or else what they make of it.
    pub input: SVector<T, NU>,
}

impl<T: Scalar, const NU: usize> Settings<T, NU> {
    /// `input` as it leaves the actuator. Controller and actuator both call this, so that the controller
    /// knows what an acknowledged input really was.
    pub fn saturate(&self, input: &SVector<T, NU>) -> SVector<T, NU> {
        self.limits.as_ref().map_or(*input, |limits| limits.saturate(input))
    }

    /// The same after `before` in the cycle before: what becomes of `input`, where inputs may change so much in a cycle only.
    pub fn leaves_after(&self, before: &SVector<T, NU>, input: &SVector<T, NU>) -> SVector<T, NU> {
        let within = self.saturate(input);
        let Some(rate) = self.rate() else { return within };
        within.zip_zip_map(before, &rate, |value, before, rate| value.max(before - rate).min(before + rate))
    }

    /// Most that each input changes from one cycle to the next, if that is limited.
    pub fn rate(&self) -> Option<SVector<T, NU>> {
        self.limits.as_ref().and_then(|limits| limits.rate)
    }
}

impl<T, const NU: usize> Settings<T, NU> {
    /// What a checksum is taken of.
    pub(crate) const fn part(&self, place: usize) -> Part<'_, T> {
        let Self { default_input, limits, safe } = self;
        match (place, limits, safe) {
            (0, _, _) => {
                let after = match safe {
                    Some(safe) => safe.after as u32,
                    None => 0,
                };
                let hold = matches!(default_input, DefaultInput::Hold) as u32;
                Part::Word(
                    after | hold << 16 | (limits.is_some() as u32) << 17 | (safe.is_some() as u32) << 18,
                )
            }
            (1, Some(limits), _) => Part::Numbers(limits.min.data.0.as_flattened()),
            (2, Some(limits), _) => Part::Numbers(limits.max.data.0.as_flattened()),
            (3, Some(Limits { rate: Some(rate), .. }), _) => Part::Numbers(rate.data.0.as_flattened()),
            (4, _, Some(safe)) => Part::Numbers(safe.input.data.0.as_flattened()),
            (1..Self::PARTS, _, _) => Part::Numbers(&[]),
            _ => Part::End,
        }
    }

    /// How many parts there are.
    pub(crate) const PARTS: usize = 5;
}

macro_rules! constants {
    ($scalar:ty) => {
        impl<const NU: usize> Settings<$scalar, NU> {
            /// Of constants, as [`super::Actuator::check_memory`] expects it: CRC-32/ISCSI of all that is in them.
            pub const fn checksum(&self) -> u32 {
                checksum_of!(place => self.part(place))
            }
        }
    };
}
constants!(f32);
constants!(f64);
