//! What one step of the recursion expects of the link and the plant: every formula of THEORY 4 but the minimum.
//!
//! Written in the survival function `g(d) = P(delay > d) = 1 - Q(d)`, in which every weight of THEORY 4 is a product,
//! quotient or difference of neighbours and keeps its relative accuracy however small it is:
//!
//! ```text
//! q0 + D c_m = 1 - g(m+1)        D c_m          = g(0) - g(m+1)      D (1 - e_t)  = g(t)
//! D (1 - c_m) = g(m+1)           c_{m|t}        = (g(t) - g(m+1)) / g(t)     for m >= t
//! ```
//!
//! `N_t` is zero in rows and columns before `t` (nothing in flight is told before its time), so sums over `t` run over
//! `m, m2 >= t` only.

use super::dense::{add_product, add_scaled, add_transposed_product, mirror_upper};
use super::{Dimensions, Problem};
use crate::{DefaultInput, Scalar, arrival};

/// Products of the cost-to-go with the plant, computed once a step.
#[derive(Debug)]
pub(super) struct Products<'w, T> {
    /// `P A`, `nx x nx`.
    pub(super) pa: &'w mut [T],
    /// `P B`, `nx x nu`.
    pb: &'w mut [T],
    /// `R_B = R + B^T P B`, `nu x nu`.
    rb: &'w mut [T],
    /// `A^T S`, `nx x n_v nu`.
    ats: &'w mut [T],
    /// `B^T S`, `nu x n_v nu`.
    bts: &'w mut [T],
}

impl<'w, T: Scalar> Products<'w, T> {
    pub(super) fn new(dimensions: &Dimensions, workspace: &'w mut [T]) -> Self {
        let (nx, nu, v) = (dimensions.states, dimensions.inputs, dimensions.in_flight_rows());
        let (pa, rest) = workspace.split_at_mut(nx * nx);
        let (pb, rest) = rest.split_at_mut(nx * nu);
        let (rb, rest) = rest.split_at_mut(nu * nu);
        let (ats, rest) = rest.split_at_mut(nx * v);
        let (bts, _) = rest.split_at_mut(nu * v);
        Self { pa, pb, rb, ats, bts }
    }

    pub(super) fn compute(&mut self, problem: &Problem<'_, T>, p: &[T], s: &[T]) {
        let Dimensions { states: nx, inputs: nu, .. } = problem.dimensions;
        let v = problem.dimensions.in_flight_rows();
        let one = T::one();
        for product in [&mut *self.pa, self.pb, self.ats, self.bts] {
            product.fill(T::zero());
        }
        add_product(self.pa, one, (p, nx), (problem.a, nx));
        add_product(self.pb, one, (p, nx), (problem.b, nu));
        for (entry, weight) in self.rb.iter_mut().zip(problem.r) {
            *entry = *weight;
        }
        add_transposed_product(self.rb, one, (problem.b, nu), (self.pb, nu));
        add_transposed_product(self.ats, one, (problem.a, nx), (s, v));
        add_transposed_product(self.bts, one, (problem.b, nu), (s, v));
    }
}

/// Writes `g(m + 1)` for every stacked in-flight input: how likely a packet sent now is still under way when the input
/// it leaves behind would be applied.
pub(super) fn fill_later<T: Scalar>(survival: &[T], dimensions: &Dimensions, later: &mut [T]) {
    for (row, value) in later.iter_mut().enumerate() {
        *value = arrival::truncated(survival, row / dimensions.inputs + 1);
    }
}

/// The link as the recursion sees it.
pub(super) struct Link<'a, T> {
    pub(super) survival: &'a [T],
    pub(super) dimensions: Dimensions,
    /// From [`fill_later`]; falls from entry to entry.
    pub(super) later: &'a [T],
}

impl<T: Scalar> Link<'_, T> {
    /// `g(d)`, constant from `d = N - 1` on: a packet later than that is useless.
    pub(super) fn g(&self, d: usize) -> T {
        arrival::truncated(self.survival, d)
    }

    /// `Z` on stacked inputs: where entry `row` stands one cycle earlier; `None` past the end with zero default.
    pub(super) fn earlier(&self, row: usize) -> Option<usize> {
        let nu = self.dimensions.inputs;
        match self.dimensions.default_input {
            _ if row + nu < self.later.len() => Some(row + nu),
            DefaultInput::Zero => None,
            DefaultInput::Hold => Some(row),
        }
    }

    /// `E` on stacked inputs: which entry of the sequence becomes entry `row` in flight.
    pub(super) fn left_for(&self, row: usize) -> usize {
        let nu = self.dimensions.inputs;
        if row + nu < self.dimensions.sequence_rows() { row + nu } else { row }
    }

    /// What stands between `E^T` and `E` in `Rbar`, and between `E^T` and `Z` in `Gv`; both `n_v nu` square.
    pub(super) fn in_flight_cost(&self, y: &[T], n: &[T], quadratic: &mut [T], linear: &mut [T]) {
        let nu = self.dimensions.inputs;
        let v = self.later.len();
        let (zero, one) = (T::zero(), T::one());
        for row in 0..v {
            let g_row = self.later[row];
            let of_row = row * v..(row + 1) * v;
            let out = quadratic[of_row.clone()].iter_mut().zip(&mut linear[of_row.clone()]);
            for ((quadratic, linear), (entry, g_column)) in out.zip(y[of_row].iter().zip(self.later)) {
                *quadratic = (one - g_row.max(*g_column)) * *entry;
                *linear = (*g_column - g_row).max(zero) * *entry;
            }
        }
        for (t, told) in n.chunks_exact((v * v).max(1)).enumerate() {
            let g_t = self.g(t);
            let known = one - g_t;
            let first = t * nu;
            for row in first..v {
                let arrives = if g_t > zero { (g_t - self.later[row]) / g_t } else { zero };
                let from = row * v;
                // Rbar is symmetric: its upper triangle is enough, and mirrored below.
                let entries = told[from + row..from + v].iter().zip(&self.later[row..]);
                for (out, (entry, g_column)) in quadratic[from + row..from + v].iter_mut().zip(entries) {
                    *out -= (known + arrives * (g_t - *g_column)) * *entry;
                }
                let entries = told[from + first..from + v].iter().zip(&self.later[first..]);
                for (out, (entry, g_column)) in linear[from + first..from + v].iter_mut().zip(entries) {
                    *out -= arrives * *g_column * *entry;
                }
            }
        }
        mirror_upper(quadratic, v);
    }

    /// `Rbar = q0 J^T R_B J + q0 (J^T B^T S E + E^T S^T B J) + E^T inner E`.
    pub(super) fn quadratic(&self, products: &Products<'_, T>, inner: &[T], out: &mut [T]) {
        let nu = self.dimensions.inputs;
        let v = self.dimensions.in_flight_rows();
        let rows = self.dimensions.sequence_rows();
        let at_once = T::one() - self.g(0);
        out.fill(T::zero());
        for i in 0..nu {
            add_scaled(&mut out[i * rows..i * rows + nu], at_once, &products.rb[i * nu..(i + 1) * nu]);
            for column in 0..v {
                let later = self.left_for(column);
                let coupling = at_once * products.bts[i * v + column];
                out[i * rows + later] += coupling;
                out[later * rows + i] += coupling;
            }
        }
        for row in 0..v {
            let out_row = self.left_for(row) * rows;
            for column in 0..v {
                out[out_row + self.left_for(column)] += inner[row * v + column];
            }
        }
    }

    /// `[Gx Gv]`: `Gx = q0 J^T B^T P A + E^T (q0 I + D C) S^T A`, `Gv = E^T [D C S^T B V0 + inner Z]`.
    pub(super) fn linear(
        &self,
        problem: &Problem<'_, T>,
        products: &Products<'_, T>,
        inner: &[T],
        out: &mut [T],
    ) {
        let Dimensions { states: nx, inputs: nu, .. } = self.dimensions;
        let v = self.dimensions.in_flight_rows();
        let columns = self.dimensions.gain_columns();
        let at_once = T::one() - self.g(0);
        out.fill(T::zero());
        for (b_row, pa_row) in problem.b.chunks_exact(nu).zip(products.pa.chunks_exact(nx)) {
            for i in 0..nu {
                add_scaled(&mut out[i * columns..i * columns + nx], at_once * b_row[i], pa_row);
            }
        }
        for row in 0..v {
            let out_row = &mut out[self.left_for(row) * columns..][..columns];
            let by_then = T::one() - self.later[row];
            for (state, entry) in out_row[..nx].iter_mut().enumerate() {
                *entry += by_then * products.ats[state * v + row];
            }
            let meanwhile = self.g(0) - self.later[row];
            for j in 0..nu {
                out_row[nx + j] += meanwhile * products.bts[j * v + row];
            }
            for column in 0..v {
                if let Some(earlier) = self.earlier(column) {
                    out_row[nx + earlier] += inner[row * v + column];
                }
            }
        }
    }

    /// One row of `D A^T P B V0 + D A^T S (I - C) Z`, where `weight` is the identity: it takes each `g` that an input in
    /// flight is weighed with.
    pub(super) fn state_row(
        &self,
        products: &Products<'_, T>,
        problem: &Problem<'_, T>,
        row: usize,
        out: &mut [T],
        weight: impl Fn(T) -> T,
    ) {
        let Dimensions { states: nx, inputs: nu, .. } = self.dimensions;
        let v = self.dimensions.in_flight_rows();
        out.fill(T::zero());
        // n_v = 0: there is no in-flight input to couple with.
        for j in 0..nu.min(v) {
            for inner in 0..nx {
                out[j] += weight(self.g(0)) * problem.a[inner * nx + row] * products.pb[inner * nu + j];
            }
        }
        for column in 0..v {
            if let Some(earlier) = self.earlier(column) {
                out[earlier] += weight(self.later[column]) * products.ats[row * v + column];
            }
        }
    }

    /// `Z^T (D Y o (1 - max(c_m, c_m2))) Z`.
    pub(super) fn shift_fresh(&self, y: &[T], out: &mut [T]) {
        // `later` falls, so that of the later of two inputs is the smaller one.
        self.shift(0, y, out, |g_row, g_column| g_row.min(g_column));
    }

    /// Adds `D V0^T R_B V0 + sym(D V0^T B^T S (I - C) Z)`; `weight` as in [`Link::state_row`].
    pub(super) fn add_applied_now(&self, products: &Products<'_, T>, out: &mut [T], weight: impl Fn(T) -> T) {
        let nu = self.dimensions.inputs;
        let v = self.dimensions.in_flight_rows();
        for i in 0..nu.min(v) {
            add_scaled(&mut out[i * v..i * v + nu], weight(self.g(0)), &products.rb[i * nu..(i + 1) * nu]);
            for column in 0..v {
                if let Some(earlier) = self.earlier(column) {
                    let coupling = weight(self.later[column]) * products.bts[i * v + column];
                    out[i * v + earlier] += coupling;
                    out[earlier * v + i] += coupling;
                }
            }
        }
    }

    /// `Z^T [ D (1 - e_t) (I - C_t) N_t (I - C_t) ] Z`.
    pub(super) fn shift_told(&self, t: usize, told: &[T], out: &mut [T]) {
        let g_t = self.g(t);
        if g_t > T::zero() {
            self.shift(t, told, out, |g_row, g_column| g_row * (g_column / g_t));
        } else {
            out.fill(T::zero());
        }
    }

    /// `Z^T (weight o matrix) Z` for a matrix that is zero before in-flight input `first`; `weight` takes `g` of row and
    /// column.
    pub(super) fn shift(&self, first: usize, matrix: &[T], out: &mut [T], weight: impl Fn(T, T) -> T) {
        let nu = self.dimensions.inputs;
        let v = self.later.len();
        let first = first * nu;
        out.fill(T::zero());
        for row in first..v {
            let Some(out_row) = self.earlier(row) else { break };
            let g_row = self.later[row];
            let (from, to) = (row * v, out_row * v);
            // With zero default what would pass the end is gone; with hold it stays where it is.
            let moving = first..v.saturating_sub(nu).max(first);
            let staying = match self.dimensions.default_input {
                DefaultInput::Zero => v..v,
                DefaultInput::Hold => moving.end..v,
            };
            let source = matrix[from..][moving.clone()].iter().zip(&self.later[moving.clone()]);
            let target = &mut out[to + nu..][moving];
            for (out, (entry, g_column)) in target.iter_mut().zip(source) {
                *out += weight(g_row, *g_column) * *entry;
            }
            let source = matrix[from..][staying.clone()].iter().zip(&self.later[staying.clone()]);
            for (out, (entry, g_column)) in out[to..][staying].iter_mut().zip(source) {
                *out += weight(g_row, *g_column) * *entry;
            }
        }
    }
}
