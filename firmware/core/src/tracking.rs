//! Following a reference: feedforward from the samples that are known ahead. THEORY 6, thesis Theorem 4.1.
//!
//! The law becomes `U = Lx xhat + M vbar + Uff`. In steady state `Uff` is a sum over the reference samples to come with
//! constant gains, [`Preview`]; in a task of finite length it is computed beforehand. Either way it is a
//! [`Feedforward`]. Where the gains come from is [`crate::synthesis::LinearCost`].

use crate::scalar::{all_within_f32, all_within_f64};
use crate::{DefaultInput, Scalar, gains::add_dot};
use heapless::Vec;
use nalgebra::SVector;

/// Constant preview gains: `Uff = sum_t Gamma_t z_{k+t}` over `t = 1..T`, the last one taking the place of all that follow.
///
/// What follows the last sample known is held to be equal to it, so a reference that stands still needs one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preview<'a, T, const NU: usize> {
    length: usize,
    default_input: DefaultInput,
    outputs: usize,
    samples: usize,
    sequence: &'a [T],
    displaced: &'a [T],
}

/// Why tables are not preview gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InvalidPreview {
    /// No tracked output, or not a single sample.
    Empty,
    /// `sequence` does not have `N nu T nz` entries.
    SequenceLength,
    /// `displaced` has neither `n_v nu T nz` entries nor none.
    DisplacedLength,
    /// A gain is not finite.
    NotFinite,
}

impl core::fmt::Display for InvalidPreview {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Empty => "there must be a tracked output and a sample of it",
            Self::SequenceLength => "sequence must have length x inputs x samples x outputs entries",
            Self::DisplacedLength => {
                "displaced must have in-flight inputs x samples x outputs entries, or none"
            }
            Self::NotFinite => "a gain is not finite",
        })
    }
}

impl core::error::Error for InvalidPreview {}

/// The tables of preview gains, by rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tables<'a, T> {
    /// `[Gamma_1 .. Gamma_T]`, `(N nu) x (T nz)`.
    pub sequence: &'a [T],
    /// `(n_v nu) x (T nz)`: what the inputs in flight are worth towards the reference. Only an event trigger needs it, and
    /// without one it may be empty.
    pub displaced: &'a [T],
}

/// Constructors for one scalar type: floating-point comparisons in `const` need a concrete type.
macro_rules! checked_construction {
    ($scalar:ty, $all_within:path) => {
        impl<'a, const NU: usize> Preview<'a, $scalar, NU> {
            /// Gains over `samples` samples of `outputs` tracked outputs, for sequences of `length` inputs, or why the
            /// tables are none.
            pub const fn check(
                length: usize,
                default_input: DefaultInput,
                outputs: usize,
                samples: usize,
                tables: Tables<'a, $scalar>,
            ) -> Result<Self, InvalidPreview> {
                let Tables { sequence, displaced } = tables;
                // Dimensions that were read from somewhere may be absurd; tables are never that long.
                let columns = outputs.saturating_mul(samples).saturating_mul(NU);
                if columns == 0 {
                    return Err(InvalidPreview::Empty);
                }
                if sequence.len() != columns.saturating_mul(length) {
                    return Err(InvalidPreview::SequenceLength);
                }
                let expected = default_input.in_flight(length);
                if !displaced.is_empty() && displaced.len() != columns.saturating_mul(expected) {
                    return Err(InvalidPreview::DisplacedLength);
                }
                let (least, most) = (<$scalar>::MIN, <$scalar>::MAX);
                if !$all_within(sequence, least, most) || !$all_within(displaced, least, most) {
                    return Err(InvalidPreview::NotFinite);
                }
                Ok(Self { length, default_input, outputs, samples, sequence, displaced })
            }

            /// Gains from constant tables; arguments as those of `check`.
            ///
            /// # Panics
            /// On tables that `check` refuses. Meant for constants, where that is a compile error.
            pub const fn new(
                length: usize,
                default_input: DefaultInput,
                outputs: usize,
                samples: usize,
                tables: Tables<'a, $scalar>,
            ) -> Self {
                match Self::check(length, default_input, outputs, samples, tables) {
                    Ok(preview) => preview,
                    Err(InvalidPreview::Empty) => panic!("preview gains without an output or a sample"),
                    Err(InvalidPreview::SequenceLength) => {
                        panic!("sequence must have length * NU * samples * outputs entries")
                    }
                    Err(InvalidPreview::DisplacedLength) => {
                        panic!("displaced must have in_flight * NU * samples * outputs entries, or none")
                    }
                    Err(InvalidPreview::NotFinite) => panic!("a preview gain is not finite"),
                }
            }
        }
    };
}
checked_construction!(f32, all_within_f32);
checked_construction!(f64, all_within_f64);

/// Why a reference is not followed; the one before stays in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectedReference {
    /// The design has no preview gains.
    NoPreview,
    /// Samples of another dimension than the design's tracked output.
    Dimension,
    /// Not a single sample.
    NoSamples,
    /// A number is not finite, or the feedforward would not be.
    NotFinite,
}

/// What a reference adds to one cycle's sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct Feedforward<T: Scalar, const NU: usize, const N: usize> {
    /// `Uff`, `N` inputs, in input units.
    pub inputs: Vec<SVector<T, NU>, N>,
    /// What the `n_v` expected inputs in flight are worth towards the reference, for an event trigger; see
    /// [`crate::synthesis::LinearCost::displaced`].
    pub displaced: Vec<SVector<T, NU>, N>,
}

impl<T: Scalar, const NU: usize, const N: usize> Default for Feedforward<T, NU, N> {
    /// None: the reference is zero.
    fn default() -> Self {
        Self { inputs: Vec::new(), displaced: Vec::new() }
    }
}

impl<T: Scalar, const NU: usize, const N: usize> Feedforward<T, NU, N> {
    /// The feedforward whose inputs stand in `rows` one after the other, as tables have them. Rows that are no whole
    /// input, or beyond the `N`-th, do not count.
    pub fn from_rows(rows: &[T]) -> Self {
        let inputs = rows.chunks_exact(NU.max(1)).take(N).map(SVector::from_column_slice).collect();
        Self { inputs, displaced: Vec::new() }
    }

    /// Adds it to the sequence that the law makes of state and expected inputs.
    pub fn add_to(&self, sequence: &mut [SVector<T, NU>]) {
        for (input, feedforward) in sequence.iter_mut().zip(&self.inputs) {
            *input += feedforward;
        }
    }

    /// Whether every number in it is finite.
    pub fn is_finite(&self) -> bool {
        self.inputs.iter().chain(&self.displaced).all(|input| input.iter().all(|value| value.is_finite()))
    }
}

impl<T: Scalar, const NU: usize> Preview<'_, T, NU> {
    /// Inputs per sequence, `N`.
    pub const fn length(&self) -> usize {
        self.length
    }

    /// What the actuator does when its buffer has run out; the gains are for this choice only.
    pub const fn default_input(&self) -> DefaultInput {
        self.default_input
    }

    /// Reference samples that make a difference, `T`.
    pub const fn samples(&self) -> usize {
        self.samples
    }

    /// Tracked outputs, `nz`.
    pub const fn outputs(&self) -> usize {
        self.outputs
    }

    /// Whether it tells what an event trigger must know.
    pub const fn serves_trigger(&self) -> bool {
        !self.displaced.is_empty() || self.default_input.in_flight(self.length) == 0
    }

    /// The feedforward for the samples `z_{k+1}, z_{k+2}, ..`; those beyond the `T`-th change nothing, and of fewer the
    /// last one stands for the missing.
    ///
    /// # Errors
    /// Says why these are no samples of the tracked output.
    pub fn feedforward<const NZ: usize, const N: usize>(
        &self,
        reference: &[SVector<T, NZ>],
    ) -> Result<Feedforward<T, NU, N>, RejectedReference> {
        if NZ != self.outputs {
            return Err(RejectedReference::Dimension);
        }
        let last = reference.last().ok_or(RejectedReference::NoSamples)?;
        // Sample by sample, each sum in the order of the samples: this is most of a cycle's work.
        let row_times_samples = |row: &[T]| {
            let mut gains = row.chunks_exact(NZ);
            let known = reference.iter().zip(gains.by_ref());
            let sum = known.fold(T::zero(), |sum, (sample, gain)| add_dot(sum, gain, sample));
            gains.fold(sum, |sum, gain| add_dot(sum, gain, last))
        };
        let weighted = |table: &[T]| {
            let mut rows = table.chunks_exact(self.samples * self.outputs);
            let mut next = || rows.next().map_or_else(T::zero, row_times_samples);
            let inputs = table.len() / (self.samples * self.outputs * NU).max(1);
            (0..inputs.min(N)).map(|_| SVector::from_fn(|_, _| next())).collect()
        };
        let feedforward =
            Feedforward { inputs: weighted(self.sequence), displaced: weighted(self.displaced) };
        if feedforward.is_finite() { Ok(feedforward) } else { Err(RejectedReference::NotFinite) }
    }
}
