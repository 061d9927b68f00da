//! The loop over one cycle: linear, with a random delay of the packet and measurements that are there or not. THEORY 14.
//!
//! State: `[x; e; e'; v; vbar]`. `e` is the error of the prediction of a filter to which all measurements come, `e'` that of the
//! controller's, which has not heard of the last ones; where it hears of all at once there is no `e'`. Each row depends on the
//! delay only through whether that is at most the row's own, so second moments need every row twice, not once for each delay:
//!
//! ```text
//! E[row_i X row_k'] = sum over (early, late)^2 of P(i so, k so) (row_i so) X (row_k so)'
//! ```

use super::{descent::inverse, loop_data::LoopData, sent::Sent};
use nalgebra::DMatrix;

/// What the controller may have heard in a cycle, and the loop then.
pub(super) struct Heard {
    pub(super) probability: f64,
    /// Rows where the packet is early and late enough, without the law, `n x n`.
    pub(super) early: DMatrix<f64>,
    pub(super) late: DMatrix<f64>,
    /// The same for the measurement's noise, `n x ny`; the packet's delay does not matter.
    pub(super) noise: DMatrix<f64>,
    /// What the law is made of: `[xf; vbar]`, `(nx + n_v nu) x n`, and its noise.
    pub(super) known: DMatrix<f64>,
    pub(super) known_noise: DMatrix<f64>,
}

/// The loop, for every law.
pub(super) struct Jump<'d> {
    pub(super) data: &'d LoopData,
    pub(super) sent: Sent,
    pub(super) heard: Vec<Heard>,
    /// What `U` adds to the rows, `n x N nu`.
    pub(super) early: DMatrix<f64>,
    pub(super) late: DMatrix<f64>,
    /// Probabilities that a row is early.
    pub(super) by_then: Vec<f64>,
    /// Probabilities that two rows are both early, the first late and the second early, and both late.
    both_early: DMatrix<f64>,
    late_early: DMatrix<f64>,
    both_late: DMatrix<f64>,
    /// Covariance of the process noise, `n x n`.
    pub(super) process_noise: DMatrix<f64>,
}

impl<'d> Jump<'d> {
    /// With a filter whose gain is `gain`, `nx x ny`.
    pub(super) fn new(data: &'d LoopData, gain: &DMatrix<f64>) -> Self {
        let sent = Sent::of(&data.problem);
        let (a, b) = (&data.problem.a, &data.problem.b);
        let states = a.nrows();
        let (outputs, flight) = (data.c.nrows(), sent.shift.nrows());
        let hears_all = data.hears >= 1.0;
        let errors = if hears_all { 1 } else { 2 };
        let size = (1 + errors) * states + 2 * flight;
        let unit = DMatrix::<f64>::identity(size, size);
        let rows = |first: usize, count: usize| unit.rows(first, count).into_owned();
        let (state, error, behind) = (rows(0, states), rows(states, states), rows(errors * states, states));
        let (flying, expected) =
            (rows((1 + errors) * states, flight), rows((1 + errors) * states + flight, flight));
        let missing = 1.0 - sent.at_once;
        let weights = sent.weights();
        let still = &sent.shift - &weights * &sent.shift;
        let (mean_next, next) = (&sent.next * &expected, &sent.next * &flying);

        let corrected = &error - gain * (&data.c * &error);
        let heard = [(data.hears, true), (1.0 - data.hears, false)];
        let heard =
            heard.into_iter().filter(|(probability, _)| *probability > 0.0).map(|(probability, all)| {
                let left = if all { corrected.clone() } else { behind.clone() };
                let left_noise = if all { -gain } else { DMatrix::zeros(states, outputs) };
                let mut early = DMatrix::zeros(size, size);
                let mut late = early.clone();
                let mut noise = DMatrix::zeros(size, outputs);
                early.rows_mut(0, states).copy_from(&(a * &state));
                late.rows_mut(0, states).copy_from(&(a * &state + b * &next));
                let unexpected = b * &mean_next * -missing;
                let surprising = b * &next + &unexpected;
                for (place, (rest, rest_noise)) in
                    [(&corrected, &-gain), (&left, &left_noise)].into_iter().take(errors).enumerate()
                {
                    let first = (1 + place) * states;
                    early.rows_mut(first, states).copy_from(&(a * rest + &unexpected));
                    late.rows_mut(first, states).copy_from(&(a * rest + &surprising));
                    noise.rows_mut(first, states).copy_from(&(a * rest_noise));
                }
                let first = (1 + errors) * states;
                late.rows_mut(first, flight).copy_from(&(&sent.shift * &flying));
                early.rows_mut(first + flight, flight).copy_from(&(&still * &expected));
                late.rows_mut(first + flight, flight).copy_from(&(&still * &expected));
                let mut known = DMatrix::zeros(states + flight, size);
                known.rows_mut(0, states).copy_from(&(&state - &left));
                known.rows_mut(states, flight).copy_from(&expected);
                let mut known_noise = DMatrix::zeros(states + flight, outputs);
                known_noise.rows_mut(0, states).copy_from(&-left_noise);
                Heard { probability, early, late, noise, known, known_noise }
            });
        let heard = heard.collect();

        let first_input = b * &sent.first;
        let mut early = DMatrix::zeros(size, sent.first.ncols());
        let mut late = early.clone();
        early.rows_mut(0, states).copy_from(&first_input);
        for place in 1..=errors {
            early.rows_mut(place * states, states).copy_from(&(&first_input * missing));
            late.rows_mut(place * states, states).copy_from(&(&first_input * -sent.at_once));
        }
        let first = (1 + errors) * states;
        early.rows_mut(first, flight).copy_from(&sent.left);
        for rows in [&mut early, &mut late] {
            rows.rows_mut(first + flight, flight).copy_from(&(&weights * &sent.left));
        }

        // Of `vbar` both rows are alike.
        let mut by_then = vec![sent.at_once; first];
        by_then.extend(&sent.arrived);
        by_then.resize(size, 1.0);
        let pair =
            |of: &dyn Fn(f64, f64) -> f64| DMatrix::from_fn(size, size, |i, k| of(by_then[i], by_then[k]));
        let mut process_noise = DMatrix::zeros(size, size);
        for (i, k) in (0..=errors).flat_map(|i| (0..=errors).map(move |k| (i, k))) {
            process_noise.view_mut((i * states, k * states), (states, states)).copy_from(&data.process_noise);
        }
        Self {
            data,
            heard,
            early,
            late,
            both_early: pair(&|i, k| i.min(k)),
            late_early: pair(&|i, k| (k - i).max(0.0)),
            both_late: pair(&|i, k| 1.0 - i.max(k)),
            by_then,
            process_noise,
            sent,
        }
    }

    /// The same loop with cycles each of which counts `factor` times as much as the one before.
    pub(super) fn discounted(mut self, factor: f64) -> Self {
        self.heard.iter_mut().for_each(|heard| heard.probability *= factor);
        self
    }

    /// States of the loop.
    pub(super) fn size(&self) -> usize {
        self.early.nrows()
    }

    /// States of the plant.
    pub(super) fn states(&self) -> usize {
        self.data.problem.a.nrows()
    }

    /// Inputs that are expected, `n_v nu`.
    pub(super) fn flight(&self) -> usize {
        self.sent.shift.nrows()
    }

    /// The law that is best before a cost-to-go `Y`, `n x n`, if the filter's error is independent of what it knows.
    pub(super) fn certain_law(&self, cost: &DMatrix<f64>) -> DMatrix<f64> {
        let (size, states, flight) = (self.size(), self.states(), self.flight());
        let mut knows = DMatrix::zeros(size, states + flight);
        knows.view_mut((0, 0), (states, states)).fill_with_identity();
        for first in [size - 2 * flight, size - flight] {
            knows.view_mut((first, states), (flight, flight)).fill_with_identity();
        }
        let input = (&self.early, &self.late);
        let mut worth = DMatrix::zeros(self.early.ncols(), states + flight);
        for heard in &self.heard {
            let rows = (&(&heard.early * &knows), &(&heard.late * &knows));
            worth += self.worth(input, cost, rows) * heard.probability;
        }
        -inverse(&self.price(cost), 0.0) * worth
    }

    /// What inputs cost, before a cost-to-go `Y`, `N nu` square.
    pub(super) fn price(&self, cost: &DMatrix<f64>) -> DMatrix<f64> {
        let input = (&self.early, &self.late);
        let first = &self.sent.first;
        self.worth(input, cost, input) + first.tr_mul(&(&self.data.problem.r * first)) * self.sent.at_once
    }

    /// The weights of states, `n x n`.
    pub(super) fn weights(&self) -> DMatrix<f64> {
        let (size, states) = (self.size(), self.states());
        let mut cost = DMatrix::zeros(size, size);
        cost.view_mut((0, 0), (states, states)).copy_from(&self.data.problem.q);
        cost
    }

    /// `sum over (early, late)^2` of the weights times `L X R'`.
    pub(super) fn mean(
        &self,
        (early, late): (&DMatrix<f64>, &DMatrix<f64>),
        moments: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let (of_early, of_late) = (early * moments, late * moments);
        let mixed = (&of_late * early.transpose()).component_mul(&self.late_early);
        let mut mean = (of_early * early.transpose()).component_mul(&self.both_early);
        mean += (of_late * late.transpose()).component_mul(&self.both_late);
        mean += mixed.transpose();
        mean + mixed
    }

    /// The adjoint of [`Jump::mean`]: `sum of L' (weights o Y) R`, for different left and right sides.
    pub(super) fn worth(
        &self,
        left: (&DMatrix<f64>, &DMatrix<f64>),
        cost: &DMatrix<f64>,
        right: (&DMatrix<f64>, &DMatrix<f64>),
    ) -> DMatrix<f64> {
        let late_early = cost.component_mul(&self.late_early);
        let of_early = cost.component_mul(&self.both_early) * right.0 + late_early.tr_mul(right.1);
        let of_late = cost.component_mul(&self.both_late) * right.1 + late_early * right.0;
        left.0.tr_mul(&of_early) + left.1.tr_mul(&of_late)
    }
}
