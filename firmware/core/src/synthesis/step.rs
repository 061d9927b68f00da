//! One backward step of the recursion: expected cost of the sequence, gains, next cost-to-go.
//!
//! What one step needs of the link is in `expectation`; iterating to a fixed point is the caller's business.

use super::change::Change;
use super::dense::{add_product, add_scaled, add_transposed_product, mirror_upper};
use super::expectation::{Link, Products, fill_later};
use super::{Dimensions, InvalidProblem, Problem, SemidefiniteFactor, semidefinite};
use crate::{DefaultInput, Scalar};

/// The recursion's state: cost-to-go `(P, S, Y, N_t)` and the gains of the last step.
#[derive(Debug)]
pub struct Synthesis<'p, 'w, T> {
    pub(super) problem: Problem<'p, T>,
    /// `P` (`nx x nx`), `S` (`nx x n_v nu`), `Y` and `N_0 .. N_{n_v - 1}` (each `n_v nu` square), in this order.
    pub(super) value: &'w mut [T],
    /// `Rbar`, `N nu` square: quadratic expected cost of the sequence.
    pub(super) quadratic: &'w mut [T],
    /// Of `quadratic`, with its `rank`, from the last [`Synthesis::optimal_step`].
    pub(super) factor: &'w mut [T],
    pub(super) rank: usize,
    /// `[Gx Gv]`, `N nu x (nx + n_v nu)`: cost of the sequence times `[x; vbar]`.
    linear: &'w mut [T],
    /// `[Lx M]`, of the same shape.
    gains: &'w mut [T],
    /// What the gains take off the cost, as a quadratic form in `[x; vbar]`.
    effect: &'w mut [T],
    /// Two squares of `n_v nu` rows.
    pub(super) squares: &'w mut [T],
    pub(super) products: Products<'w, T>,
    /// `g(m + 1)` for every stacked in-flight input.
    later: &'w [T],
}

impl<'p, 'w, T: Scalar> Synthesis<'p, 'w, T> {
    /// A recursion whose cost-to-go is zero; `workspace` needs [`Dimensions::workspace_len`] numbers.
    ///
    /// # Errors
    /// Names the slice whose length does not fit.
    pub fn new(problem: Problem<'p, T>, workspace: &'w mut [T]) -> Result<Self, InvalidProblem> {
        problem.check(workspace.len())?;
        workspace.fill(T::zero());
        Self::resume(problem, workspace)
    }

    /// A recursion with the cost-to-go and the gains that another one of the same dimensions has left in `workspace`: for
    /// work that is done in slices. Plant, cost and link may have changed since.
    ///
    /// Before a [`super::LinearCost`] is stepped with it, it needs an [`Synthesis::optimal_step`] of its own.
    ///
    /// # Errors
    /// Names the slice whose length does not fit.
    pub fn resume(problem: Problem<'p, T>, workspace: &'w mut [T]) -> Result<Self, InvalidProblem> {
        problem.check(workspace.len())?;
        let dimensions = problem.dimensions;
        let (rows, columns) = (dimensions.sequence_rows(), dimensions.gain_columns());
        let v = dimensions.in_flight_rows();
        let (value, rest) = workspace.split_at_mut(dimensions.value_len());
        let (quadratic, rest) = rest.split_at_mut(rows * rows);
        let (factor, rest) = rest.split_at_mut(semidefinite::workspace_len(rows));
        let (linear, rest) = rest.split_at_mut(rows * columns);
        let (gains, rest) = rest.split_at_mut(rows * columns);
        let (effect, rest) = rest.split_at_mut(columns * columns);
        let (squares, rest) = rest.split_at_mut(2 * v * v);
        let (later, rest) = rest.split_at_mut(v);
        fill_later(problem.survival, &dimensions, later);
        let products = Products::new(&dimensions, rest);
        Ok(Self {
            problem,
            value,
            quadratic,
            factor,
            rank: 0,
            linear,
            gains,
            effect,
            squares,
            products,
            later,
        })
    }

    /// Starts anew from the terminal cost `x^T Q_K x`; `terminal` is `nx x nx`.
    pub fn restart(&mut self, terminal: &[T]) {
        self.value.fill(T::zero());
        let nx = self.dimensions().states;
        for (entry, weight) in self.value[..nx * nx].iter_mut().zip(terminal) {
            *entry = *weight;
        }
    }

    /// Sizes of the problem.
    pub fn dimensions(&self) -> Dimensions {
        self.problem.dimensions
    }

    /// `[Lx M]`, `N nu x (nx + n_v nu)` row-major: `U = Lx xhat + M vbar`. THEORY 3.
    pub fn gains(&self) -> &[T] {
        self.gains
    }

    /// Computes `Rbar` and `[Gx Gv]` of the present cost-to-go and leaves that as it is: for a link with several states,
    /// whose expectation over the next one the caller takes.
    pub fn look_ahead(&mut self) {
        self.expect();
    }

    /// `[Gx Gv]`, `N nu x (nx + n_v nu)` row-major, from the last [`Synthesis::look_ahead`]: what a sequence `U` costs
    /// with `[x; vbar]` at hand is `U^T Rbar U + 2 U^T [Gx Gv] [x; vbar]`.
    pub fn coupling(&self) -> &[T] {
        self.linear
    }

    /// `Rbar`, `N nu` square: what a sequence that differs from the optimal one by `d` costs more is `d^T Rbar d`.
    pub fn sequence_cost(&self) -> &[T] {
        self.quadratic
    }

    /// Sets the gains that [`Synthesis::fixed_step`] evaluates; same layout as [`Synthesis::gains`].
    pub fn set_gains(&mut self, gains: &[T]) {
        for (entry, gain) in self.gains.iter_mut().zip(gains) {
            *entry = *gain;
        }
    }

    /// `P`, `nx x nx`: the cost-to-go of the state when nothing is in flight.
    pub fn cost_to_go(&self) -> &[T] {
        let nx = self.dimensions().states;
        &self.value[..nx * nx]
    }

    /// The whole cost-to-go `(P, S, Y, N_t)`, [`Dimensions::value_len`] numbers.
    pub fn value(&self) -> &[T] {
        self.value
    }

    /// The whole cost-to-go, to set it. `P`, `Y` and every `N_t` must be symmetric.
    pub fn value_mut(&mut self) -> &mut [T] {
        self.value
    }

    /// One step of value iteration (THEORY 4): new gains, then the cost-to-go one cycle earlier.
    ///
    /// Returns the relative change of the cost-to-go: the largest over `P`, `S`, `Y` and the `N_t` of the sum of
    /// absolute changes over the sum of absolute values. At a fixed point it is that equation's residual; it is
    /// infinite once a value or a sum of them has overflowed.
    pub fn optimal_step(&mut self) -> T {
        self.expect();
        let dimensions = self.dimensions();
        let (rows, columns) = (dimensions.sequence_rows(), dimensions.gain_columns());
        for (gain, coefficient) in self.gains.iter_mut().zip(self.linear.iter()) {
            *gain = -*coefficient;
        }
        let factor = SemidefiniteFactor::new(self.quadratic, rows, self.factor);
        factor.solve(self.gains, columns);
        self.rank = factor.rank();
        self.effect.fill(T::zero());
        add_transposed_product(self.effect, T::one(), (self.linear, columns), (self.gains, columns));
        mirror_upper(self.effect, columns);
        self.step_back()
    }

    /// One step with the gains held (THEORY 5): linear in the cost-to-go but for the stage cost.
    ///
    /// Returns the relative change as [`Synthesis::optimal_step`] does.
    pub fn fixed_step(&mut self) -> T {
        self.expect();
        let dimensions = self.dimensions();
        let (rows, columns) = (dimensions.sequence_rows(), dimensions.gain_columns());
        // G + Rbar L / 2: its product with L, plus the transpose, is sym(G^T L) + L^T Rbar L.
        let half = T::nearest(0.5);
        add_product(self.linear, half, (self.quadratic, rows), (self.gains, columns));
        self.effect.fill(T::zero());
        add_transposed_product(self.effect, T::one(), (self.linear, columns), (self.gains, columns));
        for row in 0..columns {
            for column in row..columns {
                self.effect[row * columns + column] += self.effect[column * columns + row];
            }
            // The diagonal met itself above, which is what sym() asks for.
        }
        mirror_upper(self.effect, columns);
        self.step_back()
    }

    /// The link as the recursion sees it.
    pub(super) fn link(&self) -> Link<'_, T> {
        Link { survival: self.problem.survival, dimensions: self.problem.dimensions, later: self.later }
    }

    /// Numbers in `P`, in `S`, and in each of the others.
    pub(super) fn parts(&self) -> (usize, usize, usize) {
        let dimensions = self.dimensions();
        let (nx, v) = (dimensions.states, dimensions.in_flight_rows());
        (nx * nx, nx * v, v * v)
    }

    /// Fills `quadratic` and `linear` from the cost-to-go.
    pub(super) fn expect(&mut self) {
        let link =
            Link { survival: self.problem.survival, dimensions: self.problem.dimensions, later: self.later };
        let (p_len, s_len, square) = self.parts();
        let (p, rest) = self.value.split_at(p_len);
        let (s, rest) = rest.split_at(s_len);
        let (y, n) = rest.split_at(square);
        self.products.compute(&self.problem, p, s);
        let (inner_quadratic, inner_linear) = self.squares.split_at_mut(square);
        link.in_flight_cost(y, n, inner_quadratic, inner_linear);
        link.quadratic(&self.products, inner_quadratic, self.quadratic);
        link.linear(&self.problem, &self.products, inner_linear, self.linear);
    }

    /// Replaces the cost-to-go by that of one cycle earlier, given `effect` and the products of the old one.
    fn step_back(&mut self) -> T {
        let dimensions = self.dimensions();
        let link = Link { survival: self.problem.survival, dimensions, later: self.later };
        let (p_len, s_len, square) = self.parts();
        let (nx, v, columns) = (dimensions.states, dimensions.in_flight_rows(), dimensions.gain_columns());
        let effect = &*self.effect;
        let effect_at = |row: usize, column: usize| effect[row * columns + column];
        let (p, rest) = self.value.split_at_mut(p_len);
        let (s, rest) = rest.split_at_mut(s_len);
        let (y, n) = rest.split_at_mut(square);
        let (next, run_out) = self.squares.split_at_mut(square);

        let mut largest = T::zero();
        // P = Q + A^T P A + Gx^T Lx
        let mut part = Change::none();
        let (a, q) = (self.problem.a, self.problem.q);
        for row in 0..nx {
            for column in row..nx {
                let mut sum = q[row * nx + column];
                for inner in 0..nx {
                    sum += a[inner * nx + row] * self.products.pa[inner * nx + column];
                }
                part.replace(&mut p[row * nx + column], sum + effect_at(row, column));
            }
        }
        mirror_upper(p, nx);
        largest = largest.max(part.relative());

        // S = D A^T P B V0 + D A^T S (I - C) Z + Gx^T M
        let mut part = Change::none();
        for row in 0..nx {
            let next_row = &mut next[..v];
            link.state_row(&self.products, &self.problem, row, next_row, |g| g);
            for (column, value) in next_row.iter().enumerate() {
                part.replace(&mut s[row * v + column], *value + effect_at(row, nx + column));
            }
        }
        largest = largest.max(part.relative());

        // Y = D V0^T R_B V0 + sym(D V0^T B^T S (I - C) Z) + Z^T (D Y o (1 - max(c_m, c_m2))) Z
        let mut part = Change::none();
        link.shift_fresh(y, next);
        link.add_applied_now(&self.products, next, |g| g);
        mirror_upper(next, v);
        part.replace_all(y, next);
        largest = largest.max(part.relative());

        // N_{t+1} = Z^T [ D (1 - e_t) (I - C_t) N_t (I - C_t) ] Z, N_0 = -Gv^T M; oldest first, so that each is
        // read before it is written. With hold what runs out joins the last one.
        let mut part = Change::none();
        let last = dimensions.in_flight().checked_sub(1);
        let hold = dimensions.default_input == DefaultInput::Hold;
        if let (Some(last), true) = (last, hold) {
            link.shift_told(last, &n[last * square..], run_out);
        }
        for told in last.map(|last| (0..=last).rev()).into_iter().flatten() {
            if told > 0 {
                link.shift_told(told - 1, &n[(told - 1) * square..told * square], next);
            } else {
                for (row, entries) in next.chunks_exact_mut(v).enumerate() {
                    for (column, entry) in entries.iter_mut().enumerate() {
                        *entry = -effect_at(nx + row, nx + column);
                    }
                }
            }
            if hold && Some(told) == last {
                add_scaled(next, T::one(), run_out);
            }
            // Rows and columns before `told` are zero and stay so.
            let first = told * dimensions.inputs;
            for row in first..v {
                let entries = &mut n[told * square + row * v..][first..v];
                part.replace_all(entries, &next[row * v + first..(row + 1) * v]);
            }
        }
        largest.max(part.relative())
    }
}
