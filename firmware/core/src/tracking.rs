//! Following a reference: feedforward from the samples that are known ahead. THEORY 6, thesis Theorem 4.1.
//!
//! The law becomes `U = Lx xhat + M vbar + Uff`. In steady state `Uff` is a sum over the reference samples to come with
//! constant gains, [`Preview`]; in a task of finite length it is computed beforehand. Either way it is a
//! [`Feedforward`]. Where the gains come from is [`crate::synthesis::LinearCost`].

use crate::{Scalar, checked::Finite, gains::add_dot, played::DefaultInput, sequence::all_finite};
use nalgebra::SVector;

/// Constant preview gains: `Uff = sum_t Gamma_t z_{k+t}` over `t = 1..T`, the last one taking the place of all that follow.
///
/// What follows the last sample known is held to be equal to it, so a reference that stands still needs one sample.
///
/// ```
/// use slqg::DefaultInput;
/// use slqg::nalgebra::Vector1;
/// use slqg::tracking::{Preview, Tables};
///
/// // One input a sequence, one tracked output, two samples of it.
/// let tables = Tables::check(&[1.0, 0.5], &[]).expect("finite");
/// let preview = Preview::<f64, 1>::check(1, DefaultInput::Zero, 1, 2, tables).expect("tables that fit");
/// let mut inputs = [Vector1::zeros(); 1];
/// let feedforward = preview.fill_feedforward(&[Vector1::new(2.0), Vector1::new(4.0)], &mut inputs, &mut []);
/// assert_eq!(feedforward.expect("of the tracked output").inputs, [Vector1::new(4.0)]);
/// // A set point is one sample, which stands for those after it.
/// let feedforward = preview.fill_feedforward(&[Vector1::new(2.0)], &mut inputs, &mut []);
/// assert_eq!(feedforward.expect("of the tracked output").inputs, [Vector1::new(3.0)]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preview<'a, T, const NU: usize> {
    length: usize,
    default_input: DefaultInput,
    outputs: usize,
    samples: usize,
    tables: Tables<'a, T>,
}

/// Why tables are not preview gains.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

impl InvalidPreview {
    const fn message(self) -> &'static str {
        match self {
            Self::Empty => "there must be a tracked output and a sample of it",
            Self::SequenceLength => "sequence must have length x inputs x samples x outputs entries",
            Self::DisplacedLength => {
                "displaced must have in-flight inputs x samples x outputs entries, or none"
            }
            Self::NotFinite => "a gain is not finite",
        }
    }
}

impl core::fmt::Display for InvalidPreview {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.message())
    }
}

impl core::error::Error for InvalidPreview {}

/// The tables of preview gains, by rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tables<'a, T> {
    /// `[Gamma_1 .. Gamma_T]`, `(N nu) x (T nz)`.
    pub sequence: Finite<'a, T>,
    /// `(n_v nu) x (T nz)`: what the inputs in flight are worth towards the reference. Only an event trigger needs it, and
    /// without one it may be empty.
    pub displaced: Finite<'a, T>,
}

impl<'a, T: Scalar> Tables<'a, T> {
    /// Tables of these numbers, by rows.
    ///
    /// # Errors
    /// If one is not finite. How many there must be, [`Preview::check`] knows.
    pub fn check(sequence: &'a [T], displaced: &'a [T]) -> Result<Self, InvalidPreview> {
        let both = Finite::check(sequence).zip(Finite::check(displaced));
        let (sequence, displaced) = both.ok_or(InvalidPreview::NotFinite)?;
        Ok(Self { sequence, displaced })
    }
}

impl<'a, T: Copy, const NU: usize> Preview<'a, T, NU> {
    /// Gains over `samples` samples of `outputs` tracked outputs, for sequences of `length` inputs.
    ///
    /// # Errors
    /// Says what about the tables is wrong.
    pub const fn check(
        length: usize,
        default_input: DefaultInput,
        outputs: usize,
        samples: usize,
        tables: Tables<'a, T>,
    ) -> Result<Self, InvalidPreview> {
        // Dimensions that were read from somewhere may be absurd; tables are never that long.
        let columns = outputs.saturating_mul(samples).saturating_mul(NU);
        if columns == 0 {
            return Err(InvalidPreview::Empty);
        }
        if tables.sequence.len() != columns.saturating_mul(length) {
            return Err(InvalidPreview::SequenceLength);
        }
        let expected = columns.saturating_mul(default_input.in_flight(length));
        if !tables.displaced.is_empty() && tables.displaced.len() != expected {
            return Err(InvalidPreview::DisplacedLength);
        }
        Ok(Self { length, default_input, outputs, samples, tables })
    }

    /// Gains from constant tables; arguments as those of [`Preview::check`].
    ///
    /// # Panics
    /// On tables that it refuses. Meant for constants, where that is a compile error.
    pub const fn new(
        length: usize,
        default_input: DefaultInput,
        outputs: usize,
        samples: usize,
        tables: Tables<'a, T>,
    ) -> Self {
        match Self::check(length, default_input, outputs, samples, tables) {
            Ok(preview) => preview,
            Err(error) => panic!("{}", error.message()),
        }
    }
}

/// Why a reference is not followed; the one before stays in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
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

impl core::fmt::Display for RejectedReference {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NoPreview => "the design has no preview gains to follow a reference with",
            Self::Dimension => "samples of another dimension than the tracked output",
            Self::NoSamples => "a reference needs one sample at least",
            Self::NotFinite => "a sample, or the feedforward that comes of it, is not finite",
        })
    }
}

impl core::error::Error for RejectedReference {}

/// What a reference adds to one cycle's sequence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Feedforward<'f, T: Scalar, const NU: usize> {
    /// `Uff`, up to `N` inputs, in input units.
    pub inputs: &'f [SVector<T, NU>],
    /// What the `n_v` expected inputs in flight are worth towards the reference, for an event trigger; see
    /// [`crate::synthesis::LinearCost::displaced`].
    pub displaced: &'f [SVector<T, NU>],
}

impl<T: Scalar, const NU: usize> Feedforward<'_, T, NU> {
    /// The reference is zero.
    pub const NONE: Self = Self { inputs: &[], displaced: &[] };

    /// Whether every number in it is finite.
    pub fn is_finite(&self) -> bool {
        all_finite(self.inputs) && all_finite(self.displaced)
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

    /// What it is made of.
    pub(crate) const fn tables(&self) -> &Tables<'_, T> {
        &self.tables
    }

    /// Whether it tells what an event trigger must know.
    pub const fn serves_trigger(&self) -> bool {
        !self.tables.displaced.is_empty() || self.default_input.in_flight(self.length) == 0
    }

    /// Writes the feedforward for the samples `z_{k+1}, z_{k+2}, ..` to the beginning of `inputs` and `displaced`, and returns
    /// it: as much as there is room for. Samples beyond the `T`-th change nothing, and of fewer the last one stands for the
    /// missing.
    ///
    /// # Errors
    /// Says why these are no samples of the tracked output. What was written then means nothing.
    pub fn fill_feedforward<'f, const NZ: usize>(
        &self,
        reference: &[SVector<T, NZ>],
        inputs: &'f mut [SVector<T, NU>],
        displaced: &'f mut [SVector<T, NU>],
    ) -> Result<Feedforward<'f, T, NU>, RejectedReference> {
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
        let fill = |table: &[T], room: &'f mut [SVector<T, NU>]| {
            let columns = (self.samples * self.outputs).max(1);
            let mut rows = table.chunks_exact(columns);
            let written = (table.len() / (columns * NU).max(1)).min(room.len());
            let (begun, _) = room.split_at_mut(written);
            for input in begun.iter_mut() {
                *input = SVector::from_fn(|_, _| rows.next().map_or_else(T::zero, row_times_samples));
            }
            &*begun
        };
        let feedforward = Feedforward {
            inputs: fill(self.tables.sequence.numbers(), inputs),
            displaced: fill(self.tables.displaced.numbers(), displaced),
        };
        if feedforward.is_finite() { Ok(feedforward) } else { Err(RejectedReference::NotFinite) }
    }
}
