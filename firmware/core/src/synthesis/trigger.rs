//! What sending a packet is worth, as constant tables: THEORY 7, read off the cost-to-go.
//!
//! Not sending is sending over a link on which nothing ever arrives. The difference of the two expected costs-to-go is
//! linear in the weights that the link puts on what is in flight: wherever the recursion has `g`, it has `1 - g`.
//! What is done with the tables is [`crate::event`]'s business.

use super::{Dimensions, Synthesis};
use crate::Number;
use crate::event::{TableLengths, packed_index};

impl<T: Number> Synthesis<'_, '_, T> {
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
        for row in 0..rows {
            for column in row..rows {
                sequence[packed_index(rows, row, column)] = self.quadratic[row * rows + column];
            }
        }
        let link = self.link();
        for (row, out) in state.chunks_exact_mut(v.max(1)).take(nx).enumerate() {
            out.fill(T::zero());
            link.add_state_row(&self.products, &self.problem, row, out, |g| one - g);
        }
        let (_, _, y, told) = link.layout().split(self.value);
        let mut from = 0;
        for (s, (first, told)) in link.layout().each_told(told).enumerate() {
            let size = v - first;
            for row in first..v {
                for column in row..v {
                    let told = link.moved((first, told), row, column, |g_row, g_column| {
                        one - link.still_untold(s, g_row, g_column)
                    });
                    // What is applied in cycle s, with all that follows it; of the later ones only what is told.
                    let mut now = T::zero();
                    if row < first + nu {
                        now = link.moved((0, y), row, column, |g_row, g_column| one - g_row.min(g_column));
                    }
                    if row < nu {
                        now += link.applied_now(&self.products, column, row, |g| one - g);
                    }
                    in_flight[from + packed_index(size, row - first, column - first)] = now - told;
                }
            }
            from += TableLengths::packed(size);
        }
    }
}
