//! What a reference adds to the cost-to-go: `- 2 sx^T x - 2 sv^T vbar + s`, and the feedforward that follows. THEORY 6.
//!
//! The stage cost is `(H x - z)^T Q (H x - z) + (u - u_ref)^T R (u - u_ref)`, with the input `u` that is really applied.
//! Its quadratic part is the recursion's own, with `H^T Q H` for `Q`. The linear part depends on no age and on nothing
//! that was sent, and runs backwards beside it. What the feedforward is used for is [`crate::tracking`]'s business.

use super::dense::{add_scaled, dot};
use super::semidefinite::SemidefiniteFactor;
use super::{Dimensions, Synthesis};
use crate::Number;

/// What one cycle's reference asks for.
#[derive(Debug, Clone, Copy)]
pub struct Stage<'a, T> {
    /// `H^T Q z`, `nx` numbers: the reference as the state's cost sees it.
    pub state: &'a [T],
    /// `R u_ref`, `nu` numbers: the input that costs nothing, zero unless the set point needs one.
    pub input: &'a [T],
    /// `z^T Q z + u_ref^T R u_ref`: the cost of doing nothing about it.
    pub constant: T,
}

/// The linear part of a cost-to-go, with the feedforward of its last step.
#[derive(Debug)]
pub struct LinearCost<'w, T> {
    states: usize,
    /// `[sx; sv]`, `nx + n_v nu`.
    terms: &'w mut [T],
    /// The same one cycle earlier, while it is made.
    next: &'w mut [T],
    /// `g`, `N nu`.
    coefficient: &'w mut [T],
    /// `Uff = Rbar^# g`, `N nu`.
    feedforward: &'w mut [T],
    /// `n_v nu`.
    displaced: &'w mut [T],
    constant: T,
}

impl<'w, T: Number> LinearCost<'w, T> {
    /// A linear part that is zero; `workspace` needs [`Dimensions::linear_workspace_len`] numbers.
    ///
    /// # Panics
    /// If it has fewer.
    pub fn new(dimensions: &Dimensions, workspace: &'w mut [T]) -> Self {
        workspace.fill(T::zero());
        let (columns, rows) = (dimensions.gain_columns(), dimensions.sequence_rows());
        let (terms, rest) = workspace.split_at_mut(columns);
        let (next, rest) = rest.split_at_mut(columns);
        let (coefficient, rest) = rest.split_at_mut(rows);
        let (feedforward, rest) = rest.split_at_mut(rows);
        let (displaced, _) = rest.split_at_mut(dimensions.in_flight_rows());
        let states = dimensions.states;
        Self { states, terms, next, coefficient, feedforward, displaced, constant: T::zero() }
    }

    /// Starts anew at the end of a task: `sx = H^T Q_K z_K` (`nx` numbers) and `s = z_K^T Q_K z_K`.
    pub fn restart(&mut self, state: &[T], constant: T) {
        self.terms.fill(T::zero());
        for (term, value) in self.terms.iter_mut().zip(&state[..self.states]) {
            *term = *value;
        }
        self.constant = constant;
    }

    /// `sx`, `nx` numbers.
    pub fn state(&self) -> &[T] {
        &self.terms[..self.states]
    }

    /// `sv`, `n_v nu` numbers.
    pub fn in_flight(&self) -> &[T] {
        &self.terms[self.states..]
    }

    /// `s`: with the state known it completes the cost, thesis (4.13).
    pub fn constant(&self) -> T {
        self.constant
    }

    /// `Uff`, `N nu`: what the reference adds to the sequence of this cycle, `U = Lx xhat + M vbar + Uff`.
    pub fn feedforward(&self) -> &[T] {
        self.feedforward
    }

    /// `l`, `n_v nu`: `2 l^T vbar` is what the inputs in flight are worth towards the reference as far as a packet sent now
    /// would displace them. [`crate::event`] takes it off what sending is worth.
    pub fn displaced(&self) -> &[T] {
        self.displaced
    }

    /// One cycle back, with the gains and the expected costs of the recursion's last [`Synthesis::optimal_step`], which
    /// went over the same cycle.
    ///
    /// ```text
    /// g  = J^T q0 (B^T sx + R u_ref) + E^T (1 - g(m+1)) sv       Uff = Rbar^# g
    /// l  = V0^T q0 (B^T sx + R u_ref) + Z^T (1 - g(m+1)) sv
    /// sx = A^T sx + H^T Q z + Lx^T g                             sv = V0^T D (B^T sx + R u_ref) + Z^T g(m+1) sv + M^T g
    /// s  = s + z^T Q z + u_ref^T R u_ref - g^T Uff
    /// ```
    pub fn step_back(&mut self, synthesis: &mut Synthesis<'_, '_, T>, stage: Stage<'_, T>) {
        let Dimensions { states: nx, inputs: nu, .. } = synthesis.dimensions();
        let (rows, columns) = (synthesis.dimensions().sequence_rows(), synthesis.dimensions().gain_columns());
        let (zero, one) = (T::zero(), T::one());
        for values in [&mut *self.next, self.coefficient, self.displaced] {
            values.fill(zero);
        }
        let (sx, sv) = self.terms.split_at(nx);
        let (next_x, next_v) = self.next.split_at_mut(nx);
        let link = synthesis.link();
        let later = link.g(0);
        for i in 0..nu {
            let now = stage.input[i] + column_sum(synthesis.problem.b, nu, i, sx);
            self.coefficient[i] += (one - later) * now;
            if let (Some(displaced), Some(next)) = (self.displaced.get_mut(i), next_v.get_mut(i)) {
                *displaced += (one - later) * now;
                *next += later * now;
            }
        }
        for (row, value) in sv.iter().enumerate() {
            let under_way = link.later[row];
            self.coefficient[link.left_for(row)] += (one - under_way) * *value;
            if let Some(earlier) = link.earlier(row) {
                self.displaced[earlier] += (one - under_way) * *value;
                next_v[earlier] += under_way * *value;
            }
        }
        for (state, value) in next_x.iter_mut().enumerate() {
            *value = stage.state[state] + column_sum(synthesis.problem.a, nx, state, sx);
        }
        for (coefficient, gains) in self.coefficient.iter().zip(synthesis.gains().chunks_exact(columns)) {
            add_scaled(self.next, *coefficient, gains);
        }
        self.feedforward.copy_from_slice(self.coefficient);
        SemidefiniteFactor::resumed(rows, synthesis.factor).solve(self.feedforward, 1);
        self.terms.copy_from_slice(self.next);
        self.constant += stage.constant - dot(self.coefficient, self.feedforward);
    }
}

/// One entry of `matrix^T vector`, `matrix` having `columns` columns.
fn column_sum<T: Number>(matrix: &[T], columns: usize, column: usize, vector: &[T]) -> T {
    let rows = matrix.chunks_exact(columns).zip(vector);
    rows.fold(T::zero(), |sum, (row, value)| sum + row[column] * *value)
}
