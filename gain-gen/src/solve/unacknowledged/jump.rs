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
struct Heard {
    probability: f64,
    /// Rows where the packet is early and late enough, without the law, `n x n`.
    early: DMatrix<f64>,
    late: DMatrix<f64>,
    /// The same for the measurement's noise, `n x ny`; the packet's delay does not matter.
    noise: DMatrix<f64>,
    /// What the law is made of: `[xf; vbar]`, `(nx + n_v nu) x n`, and its noise.
    known: DMatrix<f64>,
    known_noise: DMatrix<f64>,
}

/// The loop, for every law.
pub(super) struct Jump<'d> {
    data: &'d LoopData,
    sent: Sent,
    heard: Vec<Heard>,
    /// What `U` adds to the rows, `n x N nu`.
    early: DMatrix<f64>,
    late: DMatrix<f64>,
    /// Probabilities that a row is early.
    by_then: Vec<f64>,
    /// Probabilities that two rows are both early, the first late and the second early, and both late.
    both_early: DMatrix<f64>,
    late_early: DMatrix<f64>,
    both_late: DMatrix<f64>,
    /// Covariance of the process noise, `n x n`.
    process_noise: DMatrix<f64>,
}

/// The loop with one law.
pub(super) struct Closed<'j, 'd> {
    jump: &'j Jump<'d>,
    law: &'j DMatrix<f64>,
    rows: Vec<Rows>,
}

struct Rows {
    early: DMatrix<f64>,
    late: DMatrix<f64>,
    early_noise: DMatrix<f64>,
    late_noise: DMatrix<f64>,
}

/// First derivatives of the cost by the law, and its second ones but for what second moments change: a Kronecker product.
pub(super) struct Slope {
    /// `(N nu) x (nx + n_v nu)`.
    pub(super) gradient: DMatrix<f64>,
    /// `N nu` square.
    pub(super) price: DMatrix<f64>,
    /// `nx + n_v nu` square: second moments of what the law is made of.
    pub(super) known: DMatrix<f64>,
}

impl<'d> Jump<'d> {
    /// With a filter whose gain is `gain`, `nx x ny`.
    pub(super) fn new(data: &'d LoopData, gain: &DMatrix<f64>) -> Self {
        let sent = Sent::of(&data.problem);
        let (a, b) = (&data.problem.a, &data.problem.b);
        let (states, inputs) = b.shape();
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
        debug_assert_eq!(sent.first.nrows(), inputs);
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
    fn price(&self, cost: &DMatrix<f64>) -> DMatrix<f64> {
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

    /// The loop with the law `[Lx M]`, `(N nu) x (nx + n_v nu)`.
    pub(super) fn closed<'j>(&'j self, law: &'j DMatrix<f64>) -> Closed<'j, 'd> {
        let rows = self.heard.iter().map(|heard| {
            let (of_state, of_noise) = (law * &heard.known, law * &heard.known_noise);
            Rows {
                early: &heard.early + &self.early * &of_state,
                late: &heard.late + &self.late * &of_state,
                early_noise: &heard.noise + &self.early * &of_noise,
                late_noise: &heard.noise + &self.late * &of_noise,
            }
        });
        Closed { jump: self, law, rows: rows.collect() }
    }

    /// `sum over (early, late)^2` of the weights times `L X R'`.
    fn mean(&self, (early, late): (&DMatrix<f64>, &DMatrix<f64>), moments: &DMatrix<f64>) -> DMatrix<f64> {
        let (of_early, of_late) = (early * moments, late * moments);
        let mixed = (&of_late * early.transpose()).component_mul(&self.late_early);
        let mut mean = (of_early * early.transpose()).component_mul(&self.both_early);
        mean += (of_late * late.transpose()).component_mul(&self.both_late);
        mean += mixed.transpose();
        mean + mixed
    }

    /// The adjoint of [`Jump::mean`]: `sum of L' (weights o Y) R`, for different left and right sides.
    fn worth(
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

impl Closed<'_, '_> {
    /// `X+`, `n x n`, of the second moments `X`, without noise.
    pub(super) fn moments_after(&self, moments: &DMatrix<f64>) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(moments.nrows(), moments.ncols());
        for (heard, rows) in self.jump.heard.iter().zip(&self.rows) {
            sum += self.jump.mean((&rows.early, &rows.late), moments) * heard.probability;
        }
        symmetric(sum)
    }

    /// The cost-to-go before a cycle, `n x n`, of that after it, without the cost of the cycle.
    pub(super) fn cost_before(&self, cost: &DMatrix<f64>) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(cost.nrows(), cost.ncols());
        for (heard, rows) in self.jump.heard.iter().zip(&self.rows) {
            let rows = (&rows.early, &rows.late);
            sum += self.jump.worth(rows, cost, rows) * heard.probability;
        }
        symmetric(sum)
    }

    /// What a cycle does to the state in the mean, `n x n`.
    pub(super) fn mean(&self) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.jump.size(), self.jump.size());
        for (heard, rows) in self.jump.heard.iter().zip(&self.rows) {
            for (row, share) in self.jump.by_then.iter().enumerate() {
                let mean = rows.early.row(row) * *share + rows.late.row(row) * (1.0 - share);
                let mut place = sum.row_mut(row);
                place += mean * heard.probability;
            }
        }
        sum
    }

    /// What noise adds to second moments in a cycle, `n x n`.
    pub(super) fn noise(&self) -> DMatrix<f64> {
        let mut sum = self.jump.process_noise.clone();
        for (heard, rows) in self.jump.heard.iter().zip(&self.rows) {
            let rows = (&rows.early_noise, &rows.late_noise);
            sum += self.jump.mean(rows, &self.jump.data.measurement_noise) * heard.probability;
        }
        sum
    }

    /// The cost of a cycle as a quadratic form of the state, `n x n`, and what measurement noise adds.
    pub(super) fn stage(&self) -> (DMatrix<f64>, f64) {
        let Jump { data, sent, heard, .. } = self.jump;
        let (size, flight) = (self.jump.size(), sent.shift.nrows());
        let mut cost = self.jump.weights();
        let next = &sent.next.tr_mul(&(&data.problem.r * &sent.next)) * (1.0 - sent.at_once);
        cost.view_mut((size - 2 * flight, size - 2 * flight), (flight, flight)).copy_from(&next);
        let mut constant = 0.0;
        for heard in heard {
            let share = heard.probability * sent.at_once;
            let (input, noise) = self.first_input(heard);
            cost += input.tr_mul(&(&data.problem.r * &input)) * share;
            let spread = &noise * &data.measurement_noise * noise.transpose();
            constant += spread.component_mul(&data.problem.r).sum() * share;
        }
        (cost, constant)
    }

    /// `J U`, and its noise.
    fn first_input(&self, heard: &Heard) -> (DMatrix<f64>, DMatrix<f64>) {
        let first = &self.jump.sent.first * self.law;
        (&first * &heard.known, &first * &heard.known_noise)
    }

    /// Derivatives of the cost, for second moments `X` and costs-to-go `Y` in steady state.
    pub(super) fn slope(&self, moments: &DMatrix<f64>, cost: &DMatrix<f64>) -> Slope {
        let jump = self.jump;
        let Jump { data, sent, .. } = jump;
        let (input, noise) = ((&jump.early, &jump.late), &data.measurement_noise);
        let weighed = sent.first.tr_mul(&data.problem.r) * sent.at_once;
        let mut gradient = DMatrix::zeros(self.law.nrows(), self.law.ncols());
        let mut known = DMatrix::zeros(self.law.ncols(), self.law.ncols());
        for (heard, rows) in jump.heard.iter().zip(&self.rows) {
            let seen = moments * heard.known.transpose();
            let seen_noise = noise * heard.known_noise.transpose();
            let (first, first_noise) = self.first_input(heard);
            let of_state = jump.worth(input, cost, (&rows.early, &rows.late)) + &weighed * first;
            let of_noise =
                jump.worth(input, cost, (&rows.early_noise, &rows.late_noise)) + &weighed * first_noise;
            gradient += (of_state * &seen + of_noise * &seen_noise) * heard.probability;
            known += (&heard.known * seen + &heard.known_noise * seen_noise) * heard.probability;
        }
        Slope { gradient, price: jump.price(cost), known }
    }

    /// Covariance of the input about its mean over all ages, `nu x nu`, in steady state with second moments `X`.
    pub(super) fn input_covariance(&self, moments: &DMatrix<f64>) -> DMatrix<f64> {
        let Jump { data, sent, heard, .. } = self.jump;
        let (size, flight) = (self.jump.size(), sent.shift.nrows());
        let at = |first: usize| {
            let mut rows = DMatrix::zeros(sent.next.nrows(), size);
            rows.columns_mut(first, flight).copy_from(&sent.next);
            rows
        };
        let (next, mean_next) = (at(size - 2 * flight), at(size - flight) * (1.0 - sent.at_once));
        let mut sum = DMatrix::zeros(next.nrows(), next.nrows());
        for heard in heard {
            let (first, noise) = self.first_input(heard);
            let early = &first * (1.0 - sent.at_once) - &mean_next;
            let late = &next - &first * sent.at_once - &mean_next;
            let spread = &early * moments * early.transpose() * sent.at_once
                + &late * moments * late.transpose() * (1.0 - sent.at_once)
                + &noise
                    * &data.measurement_noise
                    * noise.transpose()
                    * (sent.at_once * (1.0 - sent.at_once));
            sum += spread * heard.probability;
        }
        sum
    }
}

/// Without what rounding leaves of an antisymmetric part: that grows as the plant does without control. THEORY 5.
pub(super) fn symmetric(matrix: DMatrix<f64>) -> DMatrix<f64> {
    (&matrix + matrix.transpose()) * 0.5
}
