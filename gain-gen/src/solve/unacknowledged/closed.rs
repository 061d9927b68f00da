//! The loop with one law: its second moments, its costs, and how these change with the law. THEORY 14.

use super::jump::{Heard, Jump};
use nalgebra::DMatrix;

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
