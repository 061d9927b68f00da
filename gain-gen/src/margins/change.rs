//! What may be another plant than the design says: one number of it, by a factor.

use super::logarithm;
use crate::design::Plant;
use crate::discretise::zero_order_hold;
use nalgebra::DMatrix;

/// Which matrix of the design file an entry is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Matrix {
    /// `a`.
    A,
    /// `b`.
    B,
}

/// What of the true plant is not as designed. Each is a factor, 1 as designed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Change {
    /// All of `B`.
    InputGain,
    /// One entry of `a` or `b` as the design file gives them: of the continuous plant where it gives that one.
    Entry {
        /// Of which matrix.
        matrix: Matrix,
        /// Its row, from 0.
        row: usize,
        /// Its column, from 0.
        column: usize,
    },
    /// Length of a cycle, of which all nodes have the same idea. Delays stay the same number of cycles.
    SampleTime,
}

/// `A` and `B` over one cycle.
pub(super) type Dynamics = (DMatrix<f64>, DMatrix<f64>);

impl Change {
    /// The true plant over one cycle; `None`: out of the range of numbers.
    ///
    /// # Panics
    /// If the sample time changes of a plant that is no sampled one, see `continuous_plant`.
    pub fn plant(self, plant: &Plant, factor: f64) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        match self {
            Self::InputGain => Some((plant.a.clone(), &plant.b * factor)),
            Self::Entry { matrix, row, column } => {
                let (mut a, mut b) = as_given(plant);
                let changed = match matrix {
                    Matrix::A => &mut a,
                    Matrix::B => &mut b,
                };
                changed[(row, column)] *= factor;
                if plant.continuous.is_some() {
                    zero_order_hold(&a, &b, plant.sample_time)
                } else {
                    Some((a, b))
                }
            }
            Self::SampleTime => {
                let (a, b) = continuous_plant(plant).expect("asked for sampled plants only");
                zero_order_hold(&a, &b, plant.sample_time * factor)
            }
        }
    }
}

/// The continuous plant: the design's, or the one that its discrete plant samples, if there is a real one.
pub(super) fn continuous_plant(plant: &Plant) -> Option<Dynamics> {
    match &plant.continuous {
        Some((a, b)) => Some((a.clone(), b.clone())),
        None => logarithm::continuous(&plant.a, &plant.b, plant.sample_time),
    }
}

/// `a` and `b` as the design file gives them.
pub(super) fn as_given(plant: &Plant) -> Dynamics {
    plant.continuous.clone().unwrap_or_else(|| (plant.a.clone(), plant.b.clone()))
}

/// Entries that are not zero, of `a` and then of `b`, row by row.
pub(super) fn entries(plant: &Plant) -> Vec<Change> {
    let (a, b) = as_given(plant);
    let of = |matrix: Matrix, values: &DMatrix<f64>| {
        let all = (0..values.nrows()).flat_map(|row| (0..values.ncols()).map(move |column| (row, column)));
        let found = all.filter(|&at| values[at] != 0.0);
        found.map(|(row, column)| Change::Entry { matrix, row, column }).collect::<Vec<_>>()
    };
    [of(Matrix::A, &a), of(Matrix::B, &b)].concat()
}
