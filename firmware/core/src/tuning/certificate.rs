//! Proof that a cost-to-go decreases under given gains: what makes a law that the device has found safe to use.
//!
//! A cost-to-go `(P, S, Y, N_t)` stands for a function of the state and of what is in flight (THEORY 3)
//!
//! ```text
//! V = x^T P x + 2 x^T S vbar_0 + <Y, E[v v^T]> - sum_t <N_t, E[vbar_t vbar_t^T]>
//! ```
//!
//! `vbar_t` is what is expected of `v` once the actuator has told of `t` more cycles. Who is told more expects with less
//! error: `E[vbar_t vbar_t^T] - E[vbar_{t-1} vbar_{t-1}^T] = D_t` is positive semidefinite, and so is what is left of
//! `E[v v^T]` at the end, `D_{n_v}`. By cycle `k+t-1` the inputs before it have been applied and are known, so only rows
//! and columns of `D_t` from `t-1` on are not zero. Sorted by what is told when,
//!
//! ```text
//! V = [x; vbar_0]^T [ P  S ; S^T  Y - sum_{t>=0} N_t ] [x; vbar_0]  +  sum_{t=1..n_v} < Y - sum_{s>=t} N_s, D_t >
//! ```
//!
//! So `V >= 0`, whatever is in flight, if `n_v + 1` small matrices are positive semidefinite: [`is_positive`] for each.
//! That is what two inequalities between cost-to-go need. With `T` one step under the gains without stage cost, which is
//! linear ([`crate::synthesis::Synthesis::fixed_step`]), `V > 0` and `V / 2 - T^m V >= 0` say that the mean of `V` halves
//! within `m` cycles from wherever the loop is: it is mean-square stable with a rate of `2^(-1/m)` at most.
//!
//! This is an inequality, not an estimate of an eigenvalue: it cannot be fooled by a start that does not see an unstable
//! mode, nor by complex pairs. What it does not bound is rounding, in the `m` steps and in the factorisation. Pivots must
//! therefore exceed a margin, relative to `V`, that is far above what rounding was seen to do.

use crate::{
    Scalar,
    synthesis::{Dimensions, Layout},
};

/// Matrices whose definiteness makes a cost-to-go positive.
pub(super) const fn blocks(dimensions: &Dimensions) -> usize {
    dimensions.in_flight() + 1
}

/// Numbers that [`is_positive`] needs to work in.
pub(super) const fn scratch_len(dimensions: &Dimensions) -> usize {
    dimensions.gain_columns() * dimensions.gain_columns()
}

/// `share` times one cost-to-go less another.
pub(super) struct Difference<'v, T> {
    pub(super) dimensions: Dimensions,
    pub(super) share: T,
    /// Also what pivots are measured by.
    pub(super) value: &'v [T],
    /// Nothing, or as long.
    pub(super) less: Option<&'v [T]>,
}

impl<T: Scalar> Difference<'_, T> {
    /// Whether matrix `block` of the difference is positive definite by a margin: all pivots of it, scaled so that those of
    /// `value` have a unit diagonal, exceed `margin`. What costs nothing in either is left out if it does no harm: an input,
    /// which is one that can never be applied, and a state that `is_inert`.
    pub(super) fn is_positive(
        &self,
        block: usize,
        margin: T,
        is_inert: impl Fn(usize) -> bool,
        scratch: &mut [T],
    ) -> bool {
        let (nx, nu) = (self.dimensions.states, self.dimensions.inputs);
        // The first takes all inputs in flight and the state, each later one an input less.
        let first = block.saturating_sub(1) * nu;
        let states = if block == 0 { nx } else { 0 };
        let size = states + self.dimensions.in_flight_rows() - first;
        let place = |index: usize| match index.checked_sub(states) {
            None => Place::State(index),
            Some(input) => Place::Input(first + input),
        };
        for row in 0..size {
            for column in 0..=row {
                let entry = |value: &[T]| self.entry(value, block, place(column), place(row));
                let less = self.less.map_or_else(T::zero, entry);
                scratch[row * size + column] = self.share * entry(self.value) - less;
            }
        }
        for row in 0..size {
            let scale = self.entry(self.value, block, place(row), place(row));
            let (before, own) = scratch.split_at_mut(row * size);
            let own = &mut own[..=row];
            if scale == T::zero() {
                let harmless = match place(row) {
                    Place::State(state) => is_inert(state),
                    Place::Input(_) => true,
                };
                // Nothing may be coupled with what costs nothing.
                if !harmless || own.iter().any(|entry| *entry != T::zero()) {
                    return false;
                }
                continue;
            }
            for column in 0..row {
                let other = &before[column * size..][..=column];
                let pivot = other[column];
                if pivot == T::zero() {
                    if own[column] != T::zero() {
                        return false;
                    }
                    continue;
                }
                let eliminated = own[..column].iter().zip(other).fold(T::zero(), |sum, (a, b)| sum + *a * *b);
                own[column] = (own[column] - eliminated) / pivot;
            }
            let eliminated = own[..row].iter().fold(T::zero(), |sum, entry| sum + *entry * *entry);
            let left = own[row] - eliminated;
            // NaN is no pivot.
            if !(scale > T::zero() && left > margin * scale) {
                return false;
            }
            own[row] = left.sqrt();
        }
        true
    }

    /// One entry of matrix `block` of a cost-to-go, `row` before `column`.
    fn entry(&self, value: &[T], block: usize, row: Place, column: Place) -> T {
        let (nx, v) = (self.dimensions.states, self.dimensions.in_flight_rows());
        match (row, column) {
            (Place::State(row), Place::State(column)) => value[row * nx + column],
            (Place::State(row), Place::Input(column)) => value[nx * nx + row * v + column],
            (Place::Input(row), Place::Input(column)) => {
                Layout::of(&self.dimensions).untold(value, block, row, column)
            }
            // Only one triangle is asked for.
            (Place::Input(_), Place::State(_)) => T::zero(),
        }
    }
}

/// What a row or column stands for.
#[derive(Clone, Copy)]
enum Place {
    State(usize),
    Input(usize),
}
