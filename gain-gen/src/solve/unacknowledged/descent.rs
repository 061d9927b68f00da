//! The law of least exact cost: a quasi-Newton method on the logarithm of the cost. THEORY 14.
//!
//! The cost is bilinear in the law and what the law makes of second moments, so where these stood still, one step would do:
//! `L - price^-1 gradient known^-1`, as for a loop without a network. That is the metric of a limited-memory BFGS method. In the
//! optimum what the law is made of depends on itself (a plan that is kept if nothing is heard), so `known` is close to singular
//! there, and is damped.

use super::{closed::Slope, jump::Jump, steady::Steady};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Steps remembered.
const REMEMBERED: usize = 30;
/// Steps at most.
const MOST_STEPS: usize = 60;
/// Damping, relative to correlations: at first, least, most, and factors by which it changes.
const DAMPING: f64 = 1e-6;
const LEAST_DAMPING: f64 = 1e-12;
const MOST_DAMPING: f64 = 1e6;
/// Damping beyond which nothing is remembered.
const MOST_REMEMBERING: f64 = 1.0;
const HARDER: f64 = 10.0;
const SOFTER: f64 = 0.1;
/// Part of the largest that an eigenvalue of correlations must be to count.
const NOTHING: f64 = 1e-13;
/// Share of the decrease that the gradient promises which a step must bring.
const SUFFICIENT: f64 = 1e-4;

/// Where the descent has come to.
#[derive(Clone)]
pub(super) struct Descended {
    pub(super) law: DMatrix<f64>,
    pub(super) steady: Steady,
    /// Decrease of the logarithm of the cost that the gradient still promises.
    pub(super) promised: f64,
}

/// Goes down from `law`; `None` if the loop with it is not stable.
pub(super) fn descend(
    jump: &Jump<'_>,
    law: &DMatrix<f64>,
    near: Option<&Steady>,
    settled: f64,
) -> Option<Descended> {
    let mut law = law.clone();
    let mut steady = jump.steady(&law, near)?;
    let mut slope = jump.slope(&law, &steady);
    let mut memory: Vec<(DMatrix<f64>, DMatrix<f64>)> = Vec::new();
    let mut damping = DAMPING;
    let mut promised = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let gradient = &slope.gradient * (2.0 / steady.cost);
        let next = loop {
            let metric = Metric::of(&slope, damping, steady.cost);
            let step = quasi_newton(&gradient, &memory, |direction| metric.apply(direction));
            promised = gradient.dot(&step);
            if promised.is_nan() || promised <= 0.0 {
                // What is remembered does not fit here.
                if memory.is_empty() {
                    break None;
                }
                memory.clear();
                continue;
            }
            let candidate = &law - &step;
            let found = jump.steady(&candidate, Some(&steady));
            let is_lower = |found: &Steady| found.cost.ln() < steady.cost.ln() - SUFFICIENT * promised;
            if let Some(found) = found.filter(is_lower) {
                break Some((candidate, found, step));
            }
            if promised <= settled || damping >= MOST_DAMPING {
                break None;
            }
            damping = (damping * HARDER).max(DAMPING);
            if damping > MOST_REMEMBERING && !memory.is_empty() {
                // What is remembered leads too far, whatever the damping.
                memory.clear();
                damping = DAMPING;
            }
        };
        let Some((candidate, found, step)) = next else {
            return Some(Descended { law, steady, promised });
        };
        (law, steady) = (candidate, found);
        slope = jump.slope(&law, &steady);
        let change = &slope.gradient * (2.0 / steady.cost) - &gradient;
        if -step.dot(&change) > 0.0 {
            if memory.len() == REMEMBERED {
                memory.remove(0);
            }
            memory.push((-step, change));
        }
        damping = (damping * SOFTER).max(LEAST_DAMPING);
        if promised <= settled {
            return Some(Descended { law, steady, promised });
        }
    }
    Some(Descended { law, steady, promised })
}

/// The inverse of the second derivatives, damped.
struct Metric {
    price: DMatrix<f64>,
    known: DMatrix<f64>,
}

impl Metric {
    fn of(slope: &Slope, damping: f64, cost: f64) -> Self {
        Self { price: inverse(&slope.price, damping) * (0.5 * cost), known: inverse(&slope.known, damping) }
    }

    fn apply(&self, direction: &DMatrix<f64>) -> DMatrix<f64> {
        &self.price * direction * &self.known
    }
}

/// The inverse of a semidefinite matrix to whose correlations `damping` is added; zero where it has nothing.
pub(super) fn inverse(matrix: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    let scale: DVector<f64> =
        matrix.diagonal().map(|entry| if entry > 0.0 { entry.sqrt().recip() } else { 0.0 });
    let correlation = matrix.map_with_location(|i, k, entry| entry * scale[i] * scale[k]);
    let parts = SymmetricEigen::new((&correlation + correlation.transpose()) * 0.5);
    let least = NOTHING * parts.eigenvalues.max();
    let inverted = parts.eigenvalues.map(|value| {
        let value = value.max(0.0) + damping;
        if value > least { value.recip() } else { 0.0 }
    });
    let vectors = &parts.eigenvectors;
    let inverse = vectors * DMatrix::from_diagonal(&inverted) * vectors.transpose();
    inverse.map_with_location(|i, k, entry| entry * scale[i] * scale[k])
}

/// The step of a limited-memory BFGS method, by its two loops.
fn quasi_newton(
    gradient: &DMatrix<f64>,
    memory: &[(DMatrix<f64>, DMatrix<f64>)],
    metric: impl Fn(&DMatrix<f64>) -> DMatrix<f64>,
) -> DMatrix<f64> {
    let mut direction = gradient.clone();
    let mut shares = Vec::with_capacity(memory.len());
    for (step, change) in memory.iter().rev() {
        let share = step.dot(&direction) / step.dot(change);
        direction -= change * share;
        shares.push(share);
    }
    let mut direction = metric(&direction);
    for ((step, change), share) in memory.iter().zip(shares.iter().rev()) {
        let excess = share - change.dot(&direction) / step.dot(change);
        direction += step * excess;
    }
    direction
}
