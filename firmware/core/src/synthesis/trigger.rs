//! What sending a packet is worth, as constant tables: THEORY 7, read off the cost-to-go.
//!
//! Not sending is sending over a link on which nothing ever arrives. The difference of the two expected costs-to-go is
//! linear in the weights that the link puts on what is in flight: wherever the recursion has `g`, it has `1 - g`.
//! What is done with the tables is [`crate::event`]'s business.

use super::dense::mirror_upper;
use super::{Dimensions, Synthesis};
use crate::Scalar;
use crate::event::{TableLengths, packed_index};

impl<T: Scalar> Synthesis<'_, '_, T> {
    /// Writes the tables of [`crate::event::Tables`] for the cost-to-go at hand. They go with the law that is optimal for it:
    /// at a fixed point that of the last [`Synthesis::optimal_step`].
    ///
    /// With `x` the state, `v` the inputs in flight and `U` the sequence of the optimal law, sending is worth
    ///
    /// ```text
    /// 2 x^T S' vbar + sum_s E[ h(s)^T W_s h(s) ] + U^T Rbar U
    /// S'  = q0 A^T P B V0 + A^T S (1 - g(m+1)) Z
    /// W_s = row and column s of [ q0 V0^T R_B V0 + sym(V0^T B^T S (1 - g(m+1)) Z) + Z^T (1 - g(max+1)) o Y Z ]
    ///       - Z^T (1 - g(m+1) g(m2+1) / g(s)) o N_s Z
    /// ```
    ///
    /// with `h(s)` the inputs in flight as expected once the actuator has told all up to cycle `k+s`.
    ///
    /// # Panics
    /// If a table is shorter than [`TableLengths`] says.
    pub fn fill_trigger(&mut self, state: &mut [T], in_flight: &mut [T], sequence: &mut [T]) {
        self.expect();
        let dimensions = self.dimensions();
        let Dimensions { states: nx, inputs: nu, .. } = dimensions;
        let (v, rows, one) = (dimensions.in_flight_rows(), dimensions.sequence_rows(), T::one());
        let (p_len, s_len, square) = self.parts();
        for row in 0..rows {
            for column in row..rows {
                sequence[packed_index(rows, row, column)] = self.quadratic[row * rows + column];
            }
        }
        let mut squares = core::mem::take(&mut self.squares);
        let (applied, told) = squares.split_at_mut(square);
        let link = self.link();
        for (row, out) in state.chunks_exact_mut(v.max(1)).take(nx).enumerate() {
            link.state_row(&self.products, &self.problem, row, out, |g| one - g);
        }
        let (y, n) = self.value[p_len + s_len..].split_at(square);
        link.shift(0, y, applied, |g_row, g_column| one - g_row.min(g_column));
        link.add_applied_now(&self.products, applied, |g| one - g);
        mirror_upper(applied, v);
        let mut from = 0;
        for s in 0..dimensions.in_flight() {
            let g_s = link.g(s);
            // A packet that must have arrived leaves nothing in flight.
            let left =
                |g_row: T, g_column: T| if g_s > T::zero() { g_row * (g_column / g_s) } else { T::zero() };
            link.shift(s, &n[s * square..(s + 1) * square], told, |row, column| one - left(row, column));
            let first = s * nu;
            let size = v - first;
            for row in 0..size {
                for column in row..size {
                    let at = (first + row) * v + first + column;
                    // What is applied in cycle s, with all that follows it; of the later ones only what is told.
                    let now = if row < nu { applied[at] } else { T::zero() };
                    in_flight[from + packed_index(size, row, column)] = now - told[at];
                }
            }
            from += TableLengths::packed(size);
        }
        self.squares = core::mem::take(&mut squares);
    }
}
