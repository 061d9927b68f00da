//! The link as the recursion sees it, and how the inputs in flight move on from one cycle to the next.

use super::change::Change;
use super::cost_to_go::Layout;
use super::dense::{add_rows, add_scaled};
use super::expectation::Products;
use super::{Dimensions, Problem, triangle};
use crate::{DefaultInput, Number, arrival};

/// Writes `g(m + 1)` for every stacked in-flight input: how likely a packet sent now is still under way when the input
/// it leaves behind would be applied.
pub(super) fn fill_later<T: Number>(survival: &[T], dimensions: &Dimensions, later: &mut [T]) {
    for (block, values) in later.chunks_exact_mut(dimensions.inputs).enumerate() {
        values.fill(arrival::truncated(survival, block + 1));
    }
}

/// One over a survival probability, `None` if there is no such number: nothing can still be under way.
pub(super) fn inverse<T: Number>(survival: T) -> Option<T> {
    let inverse = T::one() / survival;
    (survival > T::zero() && inverse.is_finite()).then_some(inverse)
}

/// Writes two numbers for each `t`, of those that may still be under way: `g(0) / g(t)`, or zero where that is no number, and
/// `(g(t) - g(t+1)) / g(0)`.
pub(super) fn fill_told<T: Number>(survival: &[T], told: &mut [T]) {
    let g = |t| arrival::truncated(survival, t);
    for (t, weights) in told.chunks_exact_mut(2).enumerate() {
        let inverses = inverse(g(0)).zip(inverse(g(t)));
        weights[0] = inverses.map_or(T::zero(), |_| g(0) / g(t));
        weights[1] = inverses.map_or(T::zero(), |(relative, _)| (g(t) - g(t + 1)) * relative);
    }
}

/// The link as the recursion sees it.
pub(super) struct Link<'a, T> {
    pub(super) survival: &'a [T],
    pub(super) dimensions: Dimensions,
    /// From [`fill_later`]; falls from entry to entry.
    pub(super) later: &'a [T],
    /// From [`fill_told`].
    pub(super) told: &'a [T],
}

impl<T: Number> Link<'_, T> {
    /// `g(d)`, constant from `d = N - 1` on: a packet later than that is useless.
    pub(super) fn g(&self, d: usize) -> T {
        arrival::truncated(self.survival, d)
    }

    pub(super) fn layout(&self) -> Layout {
        Layout::of(&self.dimensions)
    }

    /// Those `N_t` for which `g(t)` is zero: nothing is in flight any more that is told then.
    pub(super) fn certain<'v>(&self, told: &'v [T]) -> impl Iterator<Item = (usize, &'v [T])> {
        let possible = self.told.chunks_exact(2).take_while(|weights| !weights[0].is_zero()).count();
        self.layout().each_told(told).skip(possible)
    }

    /// Whether there are such.
    pub(super) fn ends_certain(&self) -> bool {
        // `g` falls.
        self.told.iter().rev().nth(1).is_some_and(T::is_zero)
    }

    /// The weight of `N_t` between inputs with `g` of `m + 1` and `m2 + 1`, one cycle earlier: `g(m+1) g(m2+1) / g(t)`. A packet
    /// that must have arrived leaves nothing in flight.
    pub(super) fn still_untold(&self, t: usize, g_m: T, g_m2: T) -> T {
        let g_t = self.g(t);
        if g_t > T::zero() { (g_m / g_t) * g_m2 } else { T::zero() }
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

    /// The inverse of [`Link::earlier`].
    fn sources(&self, row: usize) -> impl Iterator<Item = usize> {
        let shifted = row.checked_sub(self.dimensions.inputs);
        shifted.into_iter().chain((self.earlier(row) == Some(row)).then_some(row))
    }

    /// `E` on stacked inputs: which entry of the sequence becomes entry `row` in flight.
    pub(super) fn left_for(&self, row: usize) -> usize {
        let nu = self.dimensions.inputs;
        if row + nu < self.dimensions.sequence_rows() { row + nu } else { row }
    }

    /// Adds a row over the inputs in flight, or the beginning of one, to one over the sequence that left them: times `E`.
    pub(super) fn leave_behind(&self, out: &mut [T], row: &[T]) {
        let nu = self.dimensions.inputs;
        let (moving, staying) = row.split_at(row.len().min(out.len() - nu));
        add_scaled(&mut out[nu..], T::one(), moving);
        add_scaled(&mut out[moving.len()..], T::one(), staying);
    }

    /// Adds a row over the inputs in flight, or the beginning of one, to the same one cycle earlier: times `Z`.
    pub(super) fn move_up(&self, out: &mut [T], row: &[T]) {
        let nu = self.dimensions.inputs;
        let (moving, ending) = row.split_at(row.len().min(out.len() - nu));
        add_scaled(&mut out[nu..], T::one(), moving);
        if self.dimensions.default_input == DefaultInput::Hold {
            add_scaled(&mut out[moving.len()..], T::one(), ending);
        }
    }

    /// One row of `D A^T P B V0 + D A^T S (I - C) Z`, where `weight` is the identity: it takes each `g` that an input in
    /// flight is weighed with. `out` must be zero.
    pub(super) fn add_state_row(
        &self,
        products: &Products<'_, T>,
        problem: &Problem<'_, T>,
        row: usize,
        out: &mut [T],
        weight: impl Fn(T) -> T,
    ) {
        let Dimensions { states: nx, inputs: nu, .. } = self.dimensions;
        let v = self.later.len();
        // n_v = 0: there is no in-flight input to couple with.
        let Some(now) = out.get_mut(..nu) else { return };
        add_rows(now, weight(self.g(0)), nx, (&problem.a[row..], nx), (products.pb, nu));
        let ats = self.later.iter().zip(&products.ats[row * v..(row + 1) * v]);
        let moving = v - nu;
        for (out, (g, entry)) in out[nu..].iter_mut().zip(ats.clone()) {
            *out += weight(*g) * *entry;
        }
        if self.dimensions.default_input == DefaultInput::Hold {
            for (out, (g, entry)) in out[moving..].iter_mut().zip(ats.skip(moving)) {
                *out += weight(*g) * *entry;
            }
        }
    }

    /// Entry `(row, column)`, `column < nu`, of `D V0^T R_B V0 + sym(D V0^T B^T S (I - C) Z)`; `weight` as in
    /// [`Link::add_state_row`].
    pub(super) fn applied_now(
        &self,
        products: &Products<'_, T>,
        row: usize,
        column: usize,
        weight: impl Fn(T) -> T,
    ) -> T {
        let (nu, v) = (self.dimensions.inputs, self.later.len());
        let coupling = |now: usize, other: usize| {
            let terms = self.sources(other).map(|m| weight(self.later[m]) * products.bts[now * v + m]);
            terms.fold(T::zero(), |sum, term| sum + term)
        };
        let mut sum = coupling(column, row);
        if row < nu {
            sum += weight(self.g(0)) * products.rb[row * nu + column] + coupling(row, column);
        }
        sum
    }

    /// Entry `(row, column)` of `Z^T (weight o matrix) Z`, where `matrix` is a triangle that begins with in-flight row
    /// `first`; `weight` takes `g` of row and column.
    pub(super) fn moved(
        &self,
        (first, matrix): (usize, &[T]),
        row: usize,
        column: usize,
        weight: impl Fn(T, T) -> T,
    ) -> T {
        let mut sum = T::zero();
        for m in self.sources(row).filter(|m| *m >= first) {
            for m2 in self.sources(column).filter(|m2| *m2 >= first) {
                let entry = triangle::entry(matrix, m - first, m2 - first);
                sum += weight(self.later[m], self.later[m2]) * entry;
            }
        }
        sum
    }

    /// Whether [`Link::moved`] adds up several entries in this row.
    pub(super) fn adds_up(&self, row: usize) -> bool {
        self.earlier(row) == Some(row)
    }

    /// `Y` becomes `D V0^T R_B V0 + sym(D V0^T B^T S (I - C) Z) + Z^T (D Y o (1 - max(c_m, c_m2))) Z`.
    pub(super) fn move_fresh<const MEASURED: bool>(
        &self,
        products: &Products<'_, T>,
        y: &mut [T],
        row: &mut [T],
    ) -> Change<T, MEASURED> {
        let nu = self.dimensions.inputs;
        let mut change = Change::none();
        // From the last row on, so that each is read before it is written.
        for m in (0..self.later.len()).rev() {
            let row = &mut row[..=m];
            for column in 0..nu.min(m + 1) {
                row[column] = self.applied_now(products, m, column, |g| g);
            }
            if m < nu || self.adds_up(m) {
                for (column, entry) in row.iter_mut().enumerate() {
                    let moved = self.moved((0, y), m, column, |g_m, g_m2| g_m.min(g_m2));
                    *entry = if column < nu { *entry + moved } else { moved };
                }
                change.replace_all(&mut y[triangle::row(m)], row);
                continue;
            }
            let (before, after) = y.split_at_mut(triangle::len(m));
            let (now, moved) = after[..=m].split_at_mut(nu);
            change.replace_all(now, row);
            // `later` falls: that of the later of two inputs is the smaller one.
            change.replace_scaled(moved, &before[triangle::row(m - nu)], self.later[m - nu]);
        }
        change
    }

    /// Each `N_{t+1}` becomes `Z^T [ D (1 - e_t) (I - C_t) N_t (I - C_t) ] Z`, the oldest first, so that each is read before it
    /// is written. With hold what runs out joins the last one.
    pub(super) fn move_told<const MEASURED: bool>(
        &self,
        told: &mut [T],
        row: &mut [T],
    ) -> Change<T, MEASURED> {
        let (nu, v) = (self.dimensions.inputs, self.later.len());
        let mut change = Change::none();
        // With hold the last rows add up several.
        let last = v - if self.dimensions.default_input == DefaultInput::Hold { nu } else { 0 };
        let mut end = told.len();
        for t in (1..self.dimensions.in_flight()).rev() {
            let first = t * nu;
            let start = end - triangle::len(v - first);
            let (before, target) = told[..end].split_at_mut(start);
            end = start;
            let source = &before[start - triangle::len(v - first + nu)..];
            let weights = &self.later[first - nu..];
            let possible = inverse(self.g(t - 1)).unwrap_or_else(T::zero);
            let (shifted, added_up) = target.split_at_mut(triangle::len(last - first));
            change.replace_triangle(shifted, source, possible, weights);
            let mut target = added_up;
            for m in last..v {
                let (entries, rest) = target.split_at_mut(m - first + 1);
                target = rest;
                let row = &mut row[..entries.len()];
                for (column, entry) in row.iter_mut().enumerate() {
                    let weight = |g_m, g_m2| self.still_untold(t - 1, g_m, g_m2);
                    *entry = self.moved((first - nu, source), m, first + column, weight);
                }
                self.add_what_stays(t, entries, row);
                change.replace_all(entries, row);
            }
        }
        change
    }

    /// `N_0` becomes what a step takes off, `taken`, a triangle.
    pub(super) fn begin_told<const MEASURED: bool>(
        &self,
        change: &mut Change<T, MEASURED>,
        told: &mut [T],
        taken: &mut [T],
    ) {
        for m in 0..self.later.len() {
            let (row, target) = (&mut taken[triangle::row(m)], &mut told[triangle::row(m)]);
            self.add_what_stays(0, target, row);
            change.replace_all(target, row);
        }
    }

    /// With hold, adds to a row of the last of the `N_t` what it has of itself.
    fn add_what_stays(&self, t: usize, before: &[T], row: &mut [T]) {
        let last =
            self.dimensions.default_input == DefaultInput::Hold && t + 1 == self.dimensions.in_flight();
        if last {
            let g = self.later[self.later.len() - 1];
            add_scaled(row, self.still_untold(t, g, g), before);
        }
    }
}
