//! The estimator as flashed, within the loop around a plant that is not the one it was designed for.
//!
//! The filter's model, its covariances and so its gains are the design's. They depend on which measurements have arrived
//! and not on what was measured. With every age acknowledged in time the filter knows the input `u` that was applied.
//! Let `d_j` be the state in cycle `j` less what the model predicts for it from the oldest estimate that no measurement can
//! change any more. With the true plant `A', B'`
//!
//! ```text
//! d_(j+1) = A d_j + (A' - A) x_j + (B' - B) u_j          y_j = C d_j: what a measurement of cycle j tells the filter
//! ```
//!
//! and the error of the estimate is `d_k` less what the filter makes of those `y_j` that have arrived. The loop's state
//! is therefore `[x_k; d_k; y_(k-w); ..; y_(k-1)]`, `2 nx + w ny` numbers, where measurements up to `w` cycles old may
//! still come: linear given the arrivals, and with the same law as for the state. When the measurement of cycle `k-w` has
//! come or can no longer come, it moves the estimate that all `d_j` count from:
//!
//! ```text
//! d_j <- d_j - A^(j-k+w) K y_(k-w)
//! ```

use super::arrivals::Arrivals;
use super::change::Dynamics;
use crate::design::Plant;
use crate::estimation::{kalman_covariance, modified_riccati};
use crate::solve::Law;
use nalgebra::{Cholesky, DMatrix};

/// What the loop's state is made of.
#[derive(Debug, Clone)]
pub(super) enum Coordinates {
    /// `x`: the state is known.
    State,
    /// The above, with the model that the filter has.
    Filter {
        /// The design's plant.
        model: Box<Plant>,
        /// `w`.
        window: usize,
    },
}

/// The loop while some of the measurements have arrived.
#[derive(Debug, Clone)]
pub(super) struct Situation {
    /// What the oldest measurement does to the loop's state, square.
    pub(super) settle: DMatrix<f64>,
    /// `[L M]` over the loop's state and `vbar`, `(N nu) x (size + n_v nu)`.
    pub(super) gains: DMatrix<f64>,
}

impl Coordinates {
    /// Numbers in the loop's state.
    pub(super) fn size(&self, states: usize) -> usize {
        match self {
            Self::State => states,
            Self::Filter { model, window } => 2 * states + window * model.outputs(),
        }
    }

    /// The loop's state a cycle later, by itself and by the input applied: `size x size` and `size x nu`.
    pub(super) fn step(&self, (a, b): &Dynamics) -> Dynamics {
        let Self::Filter { model, window } = self else { return (a.clone(), b.clone()) };
        let (nx, nu, ny) = (model.states(), model.inputs(), model.outputs());
        let size = self.size(nx);
        let (mut step, mut drive) = (DMatrix::zeros(size, size), DMatrix::zeros(size, nu));
        step.view_mut((0, 0), (nx, nx)).copy_from(a);
        step.view_mut((nx, 0), (nx, nx)).copy_from(&(a - &model.a));
        step.view_mut((nx, nx), (nx, nx)).copy_from(&model.a);
        drive.view_mut((0, 0), (nx, nu)).copy_from(b);
        drive.view_mut((nx, 0), (nx, nu)).copy_from(&(b - &model.b));
        for age in 1..=*window {
            let (row, identity) = (self.outputs_at(age), DMatrix::<f64>::identity(ny, ny));
            if age == 1 {
                step.view_mut((row, nx), (ny, nx)).copy_from(&model.c);
            } else {
                step.view_mut((row, self.outputs_at(age - 1)), (ny, ny)).copy_from(&identity);
            }
        }
        (step, drive)
    }

    /// Where `y` of this age, 1 to `w`, stands in the loop's state.
    fn outputs_at(&self, age: usize) -> usize {
        let Self::Filter { model, window } = self else { unreachable!("the state has no outputs") };
        2 * model.states() + (window - age) * model.outputs()
    }
}

/// The loop with the state known: one situation.
pub(super) fn state_known(law: &Law) -> Vec<Situation> {
    let states = law.lx.ncols();
    let gains = beside(&law.lx, &law.m);
    vec![Situation { settle: DMatrix::identity(states, states), gains }]
}

/// The loop with the filter, for every state of the chain of arrivals.
pub(super) fn with_filter(model: &Plant, law: &Law, arrivals: &Arrivals) -> (Coordinates, Vec<Situation>) {
    let coordinates = Coordinates::Filter { model: Box::new(model.clone()), window: arrivals.window };
    let usual = modified_riccati(model, arrivals.in_the_end)
        .unwrap_or_else(|| predicted(model, &kalman_covariance(model)));
    let situations = arrivals
        .patterns
        .iter()
        .map(|pattern| situation(&coordinates, model, law, pattern, &usual))
        .collect();
    (coordinates, situations)
}

fn situation(
    coordinates: &Coordinates,
    model: &Plant,
    law: &Law,
    pattern: &[bool],
    usual: &DMatrix<f64>,
) -> Situation {
    let Coordinates::Filter { window, .. } = coordinates else { unreachable!("there is a filter") };
    let (nx, ny, window) = (model.states(), model.outputs(), *window);
    let size = coordinates.size(nx);
    // y of an age as a function of the loop's state.
    let seen = |age: usize| {
        let mut row = DMatrix::zeros(ny, size);
        if age == 0 {
            row.view_mut((0, nx), (ny, nx)).copy_from(&model.c);
        } else {
            row.view_mut((0, coordinates.outputs_at(age)), (ny, ny)).fill_with_identity();
        }
        row
    };
    let mut covariance = usual.clone();
    for &arrived in pattern[window + 1..].iter().rev() {
        covariance = predicted(model, &corrected(model, covariance, arrived).1);
    }
    // What the filter makes of the measurements, forward from the oldest.
    let mut told = DMatrix::zeros(nx, size);
    let mut settle = DMatrix::identity(size, size);
    for age in (0..=window).rev() {
        let (gain, posterior) = corrected(model, covariance, pattern[age]);
        if let Some(gain) = gain {
            let correction = &gain * (seen(age) - &model.c * &told);
            told += &correction;
            if age == window {
                settle = settled(coordinates, model, &correction);
            }
        }
        if age > 0 {
            told = &model.a * told;
        }
        covariance = if age > 0 { predicted(model, &posterior) } else { posterior };
    }
    // The estimate is x less its error: d_k less what the filter makes of it.
    let mut estimate = told;
    for state in 0..nx {
        estimate[(state, state)] += 1.0;
        estimate[(state, nx + state)] -= 1.0;
    }
    Situation { settle, gains: beside(&(&law.lx * estimate), &law.m) }
}

/// The loop's state once every `d_j` counts from an estimate to which the oldest measurement has brought `correction`,
/// `nx x size`.
fn settled(coordinates: &Coordinates, model: &Plant, correction: &DMatrix<f64>) -> DMatrix<f64> {
    let Coordinates::Filter { window, .. } = coordinates else { unreachable!("there is a filter") };
    let (nx, ny, size) = (model.states(), model.outputs(), correction.ncols());
    let mut settle = DMatrix::identity(size, size);
    let mut moved = correction.clone();
    for age in (0..*window).rev() {
        moved = &model.a * moved;
        if age > 0 {
            let mut rows = settle.rows_mut(coordinates.outputs_at(age), ny);
            rows -= &model.c * &moved;
        }
    }
    let mut rows = settle.rows_mut(nx, nx);
    rows -= moved;
    settle
}

/// `A X A' + W`.
fn predicted(model: &Plant, posterior: &DMatrix<f64>) -> DMatrix<f64> {
    let sum = &model.a * posterior * model.a.transpose() + &model.process_noise;
    (&sum + sum.transpose()) * 0.5
}

/// The filter's gain if the measurement has arrived, and the covariance with it, in Joseph's form.
fn corrected(model: &Plant, prior: DMatrix<f64>, arrived: bool) -> (Option<DMatrix<f64>>, DMatrix<f64>) {
    let seen = &model.c * &prior;
    let innovation = &seen * model.c.transpose() + &model.measurement_noise;
    match Cholesky::new(innovation) {
        Some(factor) if arrived => {
            let gain = factor.solve(&seen).transpose();
            let rest = DMatrix::identity(model.states(), model.states()) - &gain * &model.c;
            let sum = &rest * prior * rest.transpose() + &gain * &model.measurement_noise * gain.transpose();
            (Some(gain), (&sum + sum.transpose()) * 0.5)
        }
        _ => (None, prior),
    }
}

fn beside(left: &DMatrix<f64>, right: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = left.clone().resize_horizontally(left.ncols() + right.ncols(), 0.0);
    both.columns_mut(left.ncols(), right.ncols()).copy_from(right);
    both
}
