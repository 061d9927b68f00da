//! Arnoldi's process: an orthonormal basis of the space that repeated application of a linear map spans, and the map
//! projected onto it. What is read off it, eigenvalues or solutions, is in `spectral` and `evaluation`.

use nalgebra::{DMatrix, DMatrixView};

/// A new direction shorter than this, relative to the map's image, is rounding: the space is invariant.
const BREAKDOWN: f64 = 1e-14;

/// A new direction shorter than this, relative to the map's image, has lost digits by cancellation.
const CANCELLED: f64 = 1e-2;

/// The space spanned so far.
pub(super) struct Krylov {
    basis: Vec<Vec<f64>>,
    /// Upper Hessenberg, one more row than columns in use.
    projected: DMatrix<f64>,
    invariant: bool,
}

impl Krylov {
    /// The space of `start` alone, with room for `most` applications; `None` if `start` is zero.
    pub(super) fn new(start: &[f64], most: usize) -> Option<Self> {
        let length = norm(start);
        (length > 0.0).then(|| Self {
            basis: vec![start.iter().map(|value| value / length).collect()],
            projected: DMatrix::zeros(most + 1, most),
            invariant: false,
        })
    }

    /// Applications so far.
    pub(super) fn dimension(&self) -> usize {
        self.basis.len() - usize::from(!self.invariant)
    }

    /// Whether another application is possible: there is room, and it would lead out of the space.
    pub(super) fn can_grow(&self) -> bool {
        !self.invariant && self.dimension() < self.projected.ncols()
    }

    /// Applies the map once more.
    pub(super) fn grow(&mut self, mut apply: impl FnMut(&[f64], &mut [f64])) {
        let column = self.dimension();
        let mut image = vec![0.0; self.basis[column].len()];
        apply(&self.basis[column], &mut image);
        let reached = norm(&image);
        let mut rest = self.take_off(column, &mut image);
        if rest <= CANCELLED * reached {
            // Twice is enough: the second pass removes what cancellation left of the first.
            rest = self.take_off(column, &mut image);
        }
        if rest <= BREAKDOWN * reached {
            self.invariant = true;
        } else {
            self.projected[(column + 1, column)] = rest;
            image.iter_mut().for_each(|value| *value /= rest);
            self.basis.push(image);
        }
    }

    /// Takes from `image` what lies in the space, into a column of the projected map; returns the length of what is left.
    fn take_off(&mut self, column: usize, image: &mut [f64]) -> f64 {
        for (row, direction) in self.basis.iter().enumerate() {
            let along = dot(direction, image);
            self.projected[(row, column)] += along;
            image.iter_mut().zip(direction).for_each(|(value, part)| *value -= along * part);
        }
        norm(image)
    }

    /// The map within the space, square.
    pub(super) fn projected(&self) -> DMatrixView<'_, f64> {
        self.projected.view((0, 0), (self.dimension(), self.dimension()))
    }

    /// The map from the space into the space with one application more.
    pub(super) fn projected_with_rest(&self) -> DMatrixView<'_, f64> {
        self.projected.view((0, 0), (self.dimension() + 1, self.dimension()))
    }

    /// The vector with these coordinates.
    pub(super) fn combine(&self, coordinates: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.basis[0].len()];
        for (factor, direction) in coordinates.iter().zip(&self.basis) {
            sum.iter_mut().zip(direction).for_each(|(value, part)| *value += factor * part);
        }
        sum
    }
}

/// Sum of products in eight interleaved partial sums.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_eights, b_eights) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_eights.remainder().iter().zip(b_eights.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a_eights.zip(b_eights) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

pub(super) fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}
