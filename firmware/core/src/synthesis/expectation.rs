//! What one step of the recursion expects of the link and the plant: `Rbar`, `Gx` and `Gv` of THEORY 4.
//!
//! Written in the survival function `g(d) = P(delay > d) = 1 - Q(d)`, in which every weight of THEORY 4 is a product,
//! quotient or difference of neighbours and keeps its relative accuracy however small it is:
//!
//! ```text
//! q0 + D c_m = 1 - g(m+1)        D c_m          = g(0) - g(m+1)      D (1 - e_t)  = g(t)
//! D (1 - c_m) = g(m+1)           c_{m|t}        = (g(t) - g(m+1)) / g(t)     for m >= t
//! ```
//!
//! The sums over `t` need two numbers for each pair of inputs in flight. With `g_m = g(m+1)`, `k_m = 1 - g_m`, `m2 <= m`,
//!
//! ```text
//! H_s = sum_{t<=s} N_t g(0) / g(t)            F = sum_{s<=m2} (g(s) - g(s+1)) / g(0) H_s
//! sum_t N_t           =  F + g_m2 / g(0) H_m2                     sum_t c_{m2|t} N_t  =  F
//! sum_t c_{m|t} N_t   =  F + (g_m2 - g_m) / g(0) H_m2
//! sum_t { 1 - g(t) + g(t) c_{m|t} c_{m2|t} } N_t  =  k_m2 sum_t N_t - g_m F
//! ```
//!
//! (summed by parts: what arrives between `t` and `m` arrives in one of these cycles). No weight is negative, so nothing
//! cancels that does not cancel in the sums themselves.

use super::dense::{add_product, add_rows, add_scaled, add_transposed_product};
use super::link::{Link, inverse};
use super::{Dimensions, Problem, triangle};
use crate::Number;

/// Products of the cost-to-go with the plant, computed once a step.
#[derive(Debug)]
pub(super) struct Products<'w, T> {
    /// `P A`, `nx x nx`.
    pub(super) pa: &'w mut [T],
    /// `P B`, `nx x nu`.
    pub(super) pb: &'w mut [T],
    /// `R_B = R + B^T P B`, `nu x nu`.
    pub(super) rb: &'w mut [T],
    /// `A^T S`, `nx x n_v nu`.
    pub(super) ats: &'w mut [T],
    /// `B^T S`, `nu x n_v nu`.
    pub(super) bts: &'w mut [T],
}

/// Numbers that [`Products`] need as workspace.
pub(super) const fn products_len(dimensions: &Dimensions) -> usize {
    let (nx, nu, v) = (dimensions.states, dimensions.inputs, dimensions.in_flight_rows());
    (nx + nu) * (nx + v) + nu * nu
}

impl<'w, T: Number> Products<'w, T> {
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
        for product in [&mut *self.pa, self.pb, self.ats, self.bts] {
            product.fill(T::zero());
        }
        add_product(self.pa, (p, nx), (problem.a, nx));
        add_product(self.pb, (p, nx), (problem.b, nu));
        self.rb.copy_from_slice(problem.r);
        add_transposed_product(self.rb, (problem.b, nu), (self.pb, nu));
        add_transposed_product(self.ats, (problem.a, nx), (s, v));
        add_transposed_product(self.bts, (problem.b, nu), (s, v));
    }
}

/// Numbers needed for the sums over `t`: two triangles of the inputs in flight.
pub(super) const fn sums_len(dimensions: &Dimensions) -> usize {
    2 * triangle::len(dimensions.in_flight_rows())
}

/// Where the expectations are written: both are filled with zeros first.
pub(super) struct Expectations<'w, T> {
    /// `Rbar`, `N nu` square.
    pub(super) quadratic: &'w mut [T],
    /// `[Gx Gv]`, `N nu x (nx + n_v nu)`.
    pub(super) linear: &'w mut [T],
}

impl<T: Number> Expectations<'_, T> {
    /// `Rbar`, `Gx` and `Gv` of the cost-to-go with these products, `Y` and `N_t`; to work in, `sums` of [`sums_len`] numbers and a
    /// row of the inputs in flight.
    pub(super) fn fill(
        &mut self,
        link: &Link<'_, T>,
        problem: &Problem<'_, T>,
        products: &Products<'_, T>,
        (y, told): (&[T], &[T]),
        sums: &mut [T],
        row: &mut [T],
    ) {
        let Dimensions { length, .. } = link.dimensions;
        // In pieces that stay in the cache.
        for part in [&mut *self.quadratic, self.linear] {
            let width = (part.len() / length).max(1);
            part.chunks_mut(width).for_each(|rows| rows.fill(T::zero()));
        }
        let (history, arrived) = sums.split_at_mut(sums.len() / 2);
        add_up(link, told, history, arrived);
        self.add_in_flight(link, (y, told), (history, arrived), row);
        self.add_applied_now(link, problem, products);
    }

    /// Adds `E^T [ Q(min+1) o Y - sum_t .. o N_t ] E` to `Rbar`, and
    /// `E^T [ max(g(m2+1) - g(m+1), 0) o Y - sum_t .. o N_t ] Z` to `Gv`, row by row of the lower triangle.
    fn add_in_flight(
        &mut self,
        link: &Link<'_, T>,
        (y, told): (&[T], &[T]),
        (history, arrived): (&mut [T], &mut [T]),
        row: &mut [T],
    ) {
        let Dimensions { states: nx, inputs: nu, .. } = link.dimensions;
        let (rows, columns) = (link.dimensions.sequence_rows(), link.dimensions.gain_columns());
        let v = link.later.len();
        let ends_certain = link.ends_certain();
        for m in 0..v {
            let square = &mut row[..=m];
            let (of_row, of_column) = (&mut history[triangle::row(m)], &mut arrived[triangle::row(m)]);
            weigh(link, m, &y[triangle::row(m)], square, of_row, of_column);
            if ends_certain {
                for (first, matrix) in link.certain(told).take_while(|(first, _)| *first <= m) {
                    add_scaled(&mut square[first..], -T::one(), &matrix[triangle::row(m - first)]);
                }
            }
            // Now `square` is row `m` of what stands between `E^T` and `E`, and `of_row` and `of_column` are row and column `m` of
            // what stands between `E^T` and `Z`.
            let left = link.left_for(m);
            link.leave_behind(&mut self.quadratic[left * rows..][..rows], square);
            link.move_up(&mut self.linear[left * columns + nx..][..v], of_row);
            let earlier = link.earlier(m);
            let moved = m.min(rows - nu);
            let quadratic = self.quadratic[nu * rows..].chunks_exact_mut(rows);
            for (target, entry) in quadratic.zip(&square[..moved]) {
                target[left] += *entry;
            }
            if let Some(earlier) = earlier {
                let linear = self.linear[nu * columns..].chunks_exact_mut(columns);
                for (target, entry) in linear.zip(&of_column[..moved]) {
                    target[nx + earlier] += *entry;
                }
            }
            // With hold the last input stays where it is.
            for m2 in moved..m {
                self.quadratic[m2 * rows + left] += square[m2];
                if let Some(earlier) = earlier {
                    self.linear[m2 * columns + nx + earlier] += of_column[m2];
                }
            }
        }
    }

    /// Adds `q0 J^T R_B J + q0 (J^T B^T S E + E^T S^T B J)` to `Rbar`, and what has a `B` or an `A` in it to `Gx`, `Gv`.
    fn add_applied_now(&mut self, link: &Link<'_, T>, problem: &Problem<'_, T>, products: &Products<'_, T>) {
        let Dimensions { states: nx, inputs: nu, .. } = link.dimensions;
        let (rows, columns) = (link.dimensions.sequence_rows(), link.dimensions.gain_columns());
        let v = link.later.len();
        let g_0 = link.g(0);
        let at_once = T::one() - g_0;
        for i in 0..nu {
            add_scaled(&mut self.quadratic[i * rows..][..nu], at_once, &products.rb[i * nu..][..nu]);
            let row = &mut self.linear[i * columns..][..nx];
            add_rows(row, at_once, nx, (&problem.b[i..], nu), (products.pa, nx));
        }
        for m in 0..v {
            let left = link.left_for(m);
            let g_m = link.later[m];
            for j in 0..nu {
                let coupling = products.bts[j * v + m];
                self.quadratic[j * rows + left] += at_once * coupling;
                self.quadratic[left * rows + j] += at_once * coupling;
                self.linear[left * columns + nx + j] += (g_0 - g_m) * coupling;
            }
            let by_then = T::one() - g_m;
            let row = &mut self.linear[left * columns..][..nx];
            for (entry, coupling) in row.iter_mut().zip(products.ats[m..].iter().step_by(v)) {
                *entry += by_then * *coupling;
            }
        }
    }
}

/// Fills the triangles of `H_{m2}` and `F`.
fn add_up<T: Number>(link: &Link<'_, T>, told: &[T], history: &mut [T], arrived: &mut [T]) {
    history.fill(T::zero());
    arrived.fill(T::zero());
    for ((first, matrix), weights) in link.layout().each_told(told).zip(link.told.chunks_exact(2)) {
        let (inverse, arrives) = (weights[0], weights[1]);
        if inverse.is_zero() {
            break;
        }
        let start = triangle::len(first);
        add_told(&mut history[start..], &mut arrived[start..], (first, matrix), inverse, arrives);
    }
}

/// Adds a triangle that begins with in-flight row `first` to triangles from that row on. A function of its own, so that the
/// compiler knows that they do not overlap.
#[inline(never)]
fn add_told<T: Number>(
    history: &mut [T],
    arrived: &mut [T],
    (first, matrix): (usize, &[T]),
    inverse: T,
    arrives: T,
) {
    let (mut history, mut arrived, mut entries) = (history, arrived, matrix);
    let mut width = 0;
    while !entries.is_empty() {
        width += 1;
        let (row, rest) = entries.split_at(width);
        let (of_row, later_history) = history.split_at_mut(first + width);
        let (until_row, later_arrived) = arrived.split_at_mut(first + width);
        (entries, history, arrived) = (rest, later_history, later_arrived);
        let (of_row, until_row) = (&mut of_row[first..], &mut until_row[first..]);
        for index in 0..width {
            let sum = of_row[index] + inverse * row[index];
            of_row[index] = sum;
            until_row[index] += arrives * sum;
        }
    }
}

/// From row `m` of `Y`, `H` and `F` to that of what stands between `E^T` and `E`, but for what is certain, and to row and column
/// `m` of what stands between `E^T` and `Z`.
#[inline(never)]
fn weigh<T: Number>(
    link: &Link<'_, T>,
    m: usize,
    y: &[T],
    square: &mut [T],
    history: &mut [T],
    arrived: &mut [T],
) {
    let relative = inverse(link.g(0)).unwrap_or_else(T::zero);
    let (g_m, width) = (link.later[m], y.len());
    let later = &link.later[..width];
    let (square, history, arrived) = (&mut square[..width], &mut history[..width], &mut arrived[..width]);
    for m2 in 0..width {
        let (g_m2, y) = (later[m2], y[m2]);
        let (until_m2, f) = (relative * history[m2], arrived[m2]);
        square[m2] = (T::one() - g_m2) * (y - (f + g_m2 * until_m2)) + g_m * f;
        history[m2] = (g_m2 - g_m) * y - g_m2 * (f + (g_m2 - g_m) * until_m2);
        arrived[m2] = -(g_m * f);
    }
}
