//! Anderson's acceleration of a fixed-point iteration (J. ACM 12, 1965): steps from where a combination of the last ones, linear
//! as the iteration nearly is close to its fixed point, would have changed least.
//!
//! Value iteration forgets by one factor in every step, that of its slowest mode; few modes are as slow, and each step kept
//! takes care of one. What is reached is a fixed point all the same: the residual of a step is that of the equation. That it is
//! the one that stabilises is for the rate of its gains to show, since a combination need not lie where costs do.

use super::iterate::value_steps_to_come;
use super::krylov::dot;
use slqg::synthesis::{SemidefiniteFactor, semidefinite_workspace_len};
use std::collections::VecDeque;

/// Steps combined, at most.
const KEPT: usize = 6;
/// Relative change of a step from which on steps are combined: those before are too far from linear.
const NEARLY_LINEAR: f64 = 0.1;
/// Part of the change before that one above [`NEAR`] is then at most; else it is slow because it is still far away.
const HALVED: f64 = 0.5;
/// Relative change that is surely near the fixed point.
const NEAR: f64 = 0.01;
/// Factor by which a combination may change more than the step before: another begins after that.
const SETBACK: f64 = 10.0;

/// The last steps of an iteration.
#[derive(Default)]
pub(super) struct Acceleration {
    /// Numbers, from the first on, whose changes count. What follows them in one step need not.
    counted: usize,
    /// Plain steps that do as well as a combination and what is left to do after it.
    worth: f64,
    /// Those from which the step goes that is being taken.
    before: Vec<f64>,
    /// Relative change of the last step.
    residual: f64,
    /// Where the last step led, and what it changed.
    last: Option<(Vec<f64>, Vec<f64>)>,
    /// How each of these differs from the step before, the oldest first.
    differences: VecDeque<(Vec<f64>, Vec<f64>)>,
    /// Products of the differences of the changes.
    products: VecDeque<VecDeque<f64>>,
    /// Products of these differences with the last change.
    with_last: VecDeque<f64>,
}

impl Acceleration {
    /// Of an iteration of which the first `counted` numbers count. Steps are combined where more than `worth` plain ones are to
    /// come.
    pub(super) fn new(counted: usize, worth: f64) -> Self {
        Self { counted, worth, residual: f64::INFINITY, ..Self::default() }
    }

    /// Forgets all steps.
    pub(super) fn clear(&mut self) {
        *self = Self::new(self.counted, self.worth);
    }

    /// Whether a combination has been stepped from.
    pub(super) fn is_under_way(&self) -> bool {
        !self.differences.is_empty()
    }

    /// Moves on from where the last step led. A step is to follow.
    pub(super) fn improve(&mut self, value: &mut [f64]) {
        let size = self.differences.len();
        if size > 0 {
            let products: Vec<f64> = self.products.iter().flatten().copied().collect();
            let mut shares: Vec<f64> = self.with_last.iter().copied().collect();
            let mut workspace = vec![0.0; semidefinite_workspace_len(size)];
            SemidefiniteFactor::new(&products, size, &mut workspace).solve(&mut shares, 1);
            for (share, (difference, _)) in shares.iter().zip(&self.differences) {
                value.iter_mut().zip(difference).for_each(|(value, difference)| *value -= share * difference);
            }
        }
        self.before.clear();
        self.before.extend_from_slice(&value[..self.counted]);
    }

    /// Takes the step that led to `after`, with this relative change.
    pub(super) fn take(&mut self, after: &[f64], residual: f64) {
        let falls = residual <= if residual > NEAR { HALVED } else { SETBACK } * self.residual;
        let is_worth_while =
            self.last.is_some() || value_steps_to_come(residual, self.residual, 1) > self.worth;
        self.residual = residual;
        if !falls || residual > NEARLY_LINEAR || !is_worth_while {
            self.last = None;
            self.differences.clear();
            self.products.clear();
            self.with_last.clear();
            return;
        }
        let change: Vec<f64> = after.iter().zip(&self.before).map(|(after, before)| after - before).collect();
        if let Some((earlier, earlier_change)) = self.last.take() {
            let of_change = difference(&change, earlier_change);
            self.keep(difference(after, earlier), of_change, &change);
        }
        self.last = Some((after.to_vec(), change));
    }

    fn keep(&mut self, of_value: Vec<f64>, of_change: Vec<f64>, change: &[f64]) {
        if self.differences.len() == KEPT {
            self.differences.pop_front();
            self.with_last.pop_front();
            self.products.pop_front();
            for row in &mut self.products {
                row.pop_front();
            }
        }
        let row: VecDeque<f64> = self.differences.iter().map(|(_, other)| dot(&of_change, other)).collect();
        // The change is the one before and this difference.
        self.with_last.iter_mut().zip(&row).for_each(|(product, more)| *product += more);
        self.with_last.push_back(dot(&of_change, change));
        self.products.iter_mut().zip(&row).for_each(|(products, product)| products.push_back(*product));
        let own = dot(&of_change, &of_change);
        self.products.push_back(row.into_iter().chain([own]).collect());
        self.differences.push_back((of_value, of_change));
    }
}

/// `new - old`, in place of the old.
fn difference(new: &[f64], mut old: Vec<f64>) -> Vec<f64> {
    old.iter_mut().zip(new).for_each(|(old, new)| *old = new - *old);
    old
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_iteration_with_four_modes_ends_after_as_many_steps_and_two() {
        // x+ = F x + 1, F with the eigenvalues of its diagonal.
        let modes = [0.99, 0.95, -0.9, 0.5];
        let step = |x: &[f64]| -> Vec<f64> {
            (0..4).map(|i| modes[i] * x[i] + 0.3 * x.iter().skip(i + 1).sum::<f64>() + 1.0).collect()
        };
        let mut acceleration = Acceleration::new(4, 0.0);
        let mut value = vec![0.0; 4];
        for taken in 1.. {
            acceleration.improve(&mut value);
            let after = step(&value);
            let change: f64 = after.iter().zip(&value).map(|(after, before)| (after - before).abs()).sum();
            if change < 1e-9 {
                assert!(taken <= 7, "{taken}");
                break;
            }
            // As if near the fixed point.
            acceleration.take(&after, NEAR);
            value = after;
        }
    }

    #[test]
    fn a_step_that_changes_much_more_than_the_one_before_begins_anew() {
        let mut acceleration = Acceleration::new(1, 0.0);
        for (value, residual) in [(1.0, 1e-3), (1.1, 1e-4), (1.11, 1e-5)] {
            acceleration.improve(&mut [value]);
            acceleration.take(&[value + residual], residual);
        }
        assert!(acceleration.is_under_way());
        acceleration.improve(&mut [1.2]);
        acceleration.take(&[2.0], 1e-3);
        assert!(!acceleration.is_under_way());
    }
}
