//! The algebraic Riccati equation by structure-preserving doubling.
//!
//! ```text
//! X = Q + A' X (I + G X)^-1 A          G = B R^-1 B'
//! A+ = A (I + G H)^-1 A     G+ = G + A (I + G H)^-1 G A'     H+ = H + A' H (I + G H)^-1 A      from A, G, Q: H -> X
//! ```
//!
//! A step does the work of as many steps of value iteration as all steps before it together (Chu, Fan, Lin and Wang,
//! International Journal of Control 77, 2004): where the closed loop's radius is 1 - 1e-6, two dozen steps do.

use crate::extended::{Lu, Real, product, symmetric, transposed_product};
use nalgebra::DMatrix;

/// Steps allowed: 2^64 cycles.
const MOST: usize = 64;

/// `X`, `nx x nx`, for `a`, `g` and `q`, `nx x nx` each; `None` if there is no stabilising solution to be found: the
/// iterates do not settle, or leave the range of numbers.
pub(super) fn doubling<T: Real>(a: &DMatrix<T>, g: &DMatrix<T>, q: &DMatrix<T>) -> Option<DMatrix<T>> {
    let (mut a, mut g, mut h) = (a.clone(), g.clone(), q.clone());
    let size = a.nrows();
    let one = DMatrix::from_fn(size, size, |i, j| T::from(if i == j { 1.0 } else { 0.0 }));
    for _ in 0..MOST {
        let lu = Lu::new(add(&one, &product(&g, &h)))?;
        let through = lu.solve(&a);
        let spread = lu.solve(&g);
        let more = symmetric(&transposed_product(&a, &product(&h, &through)));
        g = symmetric(&add(&g, &product(&product(&a, &spread), &a.transpose())));
        a = product(&a, &through);
        let settled = is_negligible(&more, &h);
        h = add(&h, &more);
        if !h.iter().chain(a.iter()).all(|entry| entry.narrow().is_finite()) {
            return None;
        }
        if settled {
            return Some(h);
        }
    }
    None
}

/// Whether each entry of `more` is rounding beside the diagonal of `sum`: an entry of a cost is judged by the costs of
/// its row and column, so that units do not matter.
fn is_negligible<T: Real>(more: &DMatrix<T>, sum: &DMatrix<T>) -> bool {
    let size = |i: usize| sum[(i, i)].narrow().max(0.0).sqrt();
    let roots: Vec<f64> = (0..sum.nrows()).map(size).collect();
    (0..sum.nrows())
        .all(|j| (0..sum.nrows()).all(|i| more[(i, j)].narrow().abs() <= T::PRECISION * roots[i] * roots[j]))
}

fn add<T: Real>(a: &DMatrix<T>, b: &DMatrix<T>) -> DMatrix<T> {
    a.zip_map(b, |a, b| a + b)
}
