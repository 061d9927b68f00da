//! Arnoldi's process: an orthonormal basis of the space that repeated application of a linear map spans, and the map
//! projected onto it. What is read off it, eigenvalues or solutions, is in `spectral` and `evaluation`.

use nalgebra::DMatrix;

/// A new direction shorter than this, relative to the map's image, is rounding: the space is invariant.
const BREAKDOWN: f64 = 1e-14;

/// A new direction shorter than this, relative to the map's image, has lost digits by cancellation.
const CANCELLED: f64 = 1e-4;

/// The space spanned so far.
pub(super) struct Krylov {
    basis: Vec<Vec<f64>>,
    /// Columns of the projected map, each with the entry below the diagonal: upper Hessenberg.
    projected: Vec<Vec<f64>>,
    most: usize,
    invariant: bool,
}

impl Krylov {
    /// The space of `start` alone, with room for `most` applications; `None` if `start` is zero.
    pub(super) fn new(start: &[f64], most: usize) -> Option<Self> {
        let length = norm(start);
        (length > 0.0).then(|| Self {
            basis: vec![start.iter().map(|value| value / length).collect()],
            projected: Vec::with_capacity(most),
            most,
            invariant: false,
        })
    }

    /// Applications so far.
    pub(super) fn dimension(&self) -> usize {
        self.projected.len()
    }

    /// Whether another application is possible: there is room, and it would lead out of the space.
    pub(super) fn can_grow(&self) -> bool {
        !self.invariant && self.dimension() < self.most
    }

    /// Applies the map once more.
    pub(super) fn grow(&mut self, mut apply: impl FnMut(&mut [f64])) {
        let mut image = self.basis[self.dimension()].clone();
        apply(&mut image);
        let reached = norm(&image);
        let mut column = vec![0.0; self.basis.len()];
        let mut rest = self.take_off(&mut column, &mut image);
        if rest <= CANCELLED * reached {
            // Twice is enough: the second pass removes what cancellation left of the first.
            rest = self.take_off(&mut column, &mut image);
        }
        self.invariant = rest <= BREAKDOWN * reached;
        column.push(if self.invariant { 0.0 } else { rest });
        self.projected.push(column);
        if !self.invariant {
            image.iter_mut().for_each(|value| *value /= rest);
            self.basis.push(image);
        }
    }

    /// Takes from `image` what lies in the space, into a column of the projected map; returns the length of what is left.
    fn take_off(&self, column: &mut [f64], image: &mut [f64]) -> f64 {
        for (entry, direction) in column.iter_mut().zip(&self.basis) {
            let along = dot(direction, image);
            *entry += along;
            image.iter_mut().zip(direction).for_each(|(value, part)| *value -= along * part);
        }
        norm(image)
    }

    /// The map within the space, square.
    pub(super) fn projected(&self) -> DMatrix<f64> {
        self.projected_to(self.dimension())
    }

    /// The map from the space into the space with one application more.
    pub(super) fn projected_with_rest(&self) -> DMatrix<f64> {
        self.projected_to(self.dimension() + 1)
    }

    /// What leads out of the space, from its last direction.
    pub(super) fn rest(&self) -> f64 {
        self.projected.last().and_then(|column| column.last()).copied().unwrap_or(0.0)
    }

    fn projected_to(&self, rows: usize) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(rows, self.dimension());
        for (mut column, entries) in matrix.column_iter_mut().zip(&self.projected) {
            column.iter_mut().zip(entries).for_each(|(entry, value)| *entry = *value);
        }
        matrix
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
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
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
