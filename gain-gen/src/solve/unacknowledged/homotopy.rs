//! A law that stabilises, where the Riccati equation has none: through loops whose second moments are discounted. THEORY 14.
//!
//! A loop whose second moments grow by the factor `g` has a finite cost if every cycle counts less than the one before, by a factor
//! below `1/g`. The law of least cost in that loop makes them grow more slowly, which lets the factor come closer to 1.

use super::{LoopData, descend, filter_gain, jump::Jump};
use nalgebra::DMatrix;

/// Growth, times the factor, that the discounted loop is given; the next one where the one before brings nothing.
const DISCOUNTED: [f64; 3] = [0.9, 0.97, 0.99];
/// Times that the factor is raised, at most.
const STAGES: usize = 30;
/// Decrease of the logarithm of the discounted cost, per step, that counts as none.
const SETTLED: f64 = 1e-4;
/// Part of the growth by which it must fall.
const PROGRESS: f64 = 1e-4;

/// A law `[Lx M]` near which second moments do not grow, and the covariance that its filter is told; `None` if the way from `law` ends
/// before.
pub(super) fn stabilising(data: &LoopData, law: DMatrix<f64>) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
    let inputs = data.problem.b.ncols();
    let mut covariance = DMatrix::zeros(inputs, inputs);
    let mut law = law;
    let mut growth = Jump::new(data, &filter_gain(data, &covariance)).rate(&law);
    for _ in 0..STAGES {
        if growth < 1.0 {
            return Some((law, covariance));
        }
        let next = DISCOUNTED.iter().find_map(|product| {
            let discounted = Jump::new(data, &filter_gain(data, &covariance)).discounted(product / growth);
            let found = descend(&discounted, &law, None, SETTLED)?;
            let told = discounted.closed(&found.law).input_covariance(&found.steady.moments);
            let slower = Jump::new(data, &filter_gain(data, &told)).rate(&found.law);
            (slower < growth * (1.0 - PROGRESS)).then_some((found.law, told, slower))
        });
        (law, covariance, growth) = next?;
    }
    None
}
