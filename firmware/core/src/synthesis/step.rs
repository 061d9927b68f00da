//! One backward step of the recursion: expected cost of the sequence, gains, next cost-to-go.
//!
//! What one step needs of the link is in `expectation` and `link`; iterating to a fixed point is the caller's business.

use super::change::Change;
use super::cost_to_go::Layout;
use super::dense::{add_rows, add_scaled, add_tile, mirror_upper};
use super::expectation::{Expectations, Products, products_len, sums_len};
use super::link::{Link, fill_later, fill_told};
use super::{Dimensions, InvalidProblem, Problem, SemidefiniteFactor, semidefinite, triangle};
use crate::Number;

/// The recursion's state: cost-to-go `(P, S, Y, N_t)` and the gains of the last step.
///
/// ```
/// use slqg::DefaultInput;
/// use slqg::synthesis::{Dimensions, Problem, Synthesis};
///
/// // One input a sequence, and no packet is ever late: the linear-quadratic regulator.
/// const DIMENSIONS: Dimensions = Dimensions { states: 1, inputs: 1, length: 1, default_input: DefaultInput::Zero };
/// let problem = Problem { dimensions: DIMENSIONS, a: &[2.0], b: &[1.0], q: &[1.0], r: &[1.0], survival: &[0.0] };
/// let mut workspace = [0.0_f64; DIMENSIONS.workspace_len()];
/// let mut synthesis = Synthesis::new(problem, &mut workspace).expect("slices of the right shape");
/// while synthesis.optimal_step() > 1e-14 {}
/// let p = synthesis.value()[0];
/// assert!((p - (1.0 + 4.0 * p - 4.0 * p * p / (1.0 + p))).abs() < 1e-12, "the Riccati equation");
/// assert!((synthesis.gains()[0] + 2.0 * p / (1.0 + p)).abs() < 1e-12);
/// ```
#[derive(Debug)]
pub struct Synthesis<'p, 'w, T> {
    pub(super) problem: Problem<'p, T>,
    /// `P`, `S`, `Y` and `N_0 .. N_{n_v - 1}` as [`Layout`] says.
    pub(super) value: &'w mut [T],
    /// `Rbar`, `N nu` square: quadratic expected cost of the sequence.
    pub(super) quadratic: &'w mut [T],
    /// Of `quadratic`, from the last [`Synthesis::optimal_step`].
    pub(super) factor: &'w mut [T],
    /// `[Gx Gv]`, `N nu x (nx + n_v nu)`: cost of the sequence times `[x; vbar]`.
    linear: &'w mut [T],
    /// `[Lx M]`, of the same shape, or half of the way there: see `unsolved`.
    gains: &'w mut [T],
    /// One number: not zero where `gains` holds `-W`, with `W^T W` what the gains take off the cost, and the gains are still to
    /// be solved for.
    unsolved: &'w mut [T],
    pub(super) products: Products<'w, T>,
    /// `g(m + 1)` for every stacked in-flight input.
    later: &'w [T],
    /// What weighs the `N_t` in sums over them.
    told: &'w [T],
    /// Two triangles of the inputs in flight.
    sums: &'w mut [T],
    /// `nx + n_v nu` numbers to work in.
    scratch: &'w mut [T],
}

impl<'p, 'w, T: Number> Synthesis<'p, 'w, T> {
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
    /// # Errors
    /// Names the slice whose length does not fit.
    pub fn resume(problem: Problem<'p, T>, workspace: &'w mut [T]) -> Result<Self, InvalidProblem> {
        problem.check(workspace.len())?;
        let dimensions = problem.dimensions;
        let (rows, columns) = (dimensions.sequence_rows(), dimensions.gain_columns());
        let (value, rest) = workspace.split_at_mut(dimensions.value_len());
        let (quadratic, rest) = rest.split_at_mut(rows * rows);
        let (factor, rest) = rest.split_at_mut(semidefinite::workspace_len(rows));
        let (linear, rest) = rest.split_at_mut(rows * columns);
        let (gains, rest) = rest.split_at_mut(rows * columns);
        let (unsolved, rest) = rest.split_at_mut(1);
        let (later, rest) = rest.split_at_mut(dimensions.in_flight_rows());
        fill_later(problem.survival, &dimensions, later);
        let (told, rest) = rest.split_at_mut(2 * dimensions.in_flight());
        fill_told(problem.survival, told);
        let (products, rest) = rest.split_at_mut(products_len(&dimensions));
        let products = Products::new(&dimensions, products);
        let (sums, rest) = rest.split_at_mut(sums_len(&dimensions));
        let scratch = &mut rest[..columns];
        Ok(Self {
            problem,
            value,
            quadratic,
            factor,
            linear,
            gains,
            unsolved,
            products,
            later,
            told,
            sums,
            scratch,
        })
    }

    /// Starts anew from the terminal cost `x^T Q_K x`; `terminal` is `nx x nx`.
    pub fn restart(&mut self, terminal: &[T]) {
        self.value.fill(T::zero());
        let nx = self.dimensions().states;
        self.value[..nx * nx].copy_from_slice(&terminal[..nx * nx]);
    }

    /// Sizes of the problem.
    pub fn dimensions(&self) -> Dimensions {
        self.problem.dimensions
    }

    /// `[Lx M]`, `N nu x (nx + n_v nu)` row-major: `U = Lx xhat + M vbar`. THEORY 3.
    ///
    /// A step needs only half of their solution; the other half is done here, once.
    pub fn gains(&mut self) -> &[T] {
        if !self.unsolved[0].is_zero() {
            let (rows, columns) = (self.dimensions().sequence_rows(), self.dimensions().gain_columns());
            SemidefiniteFactor::resumed(rows, self.factor).solve_rest(self.gains, columns);
            self.unsolved[0] = T::zero();
        }
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
        let length = self.gains.len();
        self.gains.copy_from_slice(&gains[..length]);
        self.unsolved[0] = T::zero();
    }

    /// `P`, `nx x nx`: the cost-to-go of the state when nothing is in flight.
    pub fn cost_to_go(&self) -> &[T] {
        let nx = self.dimensions().states;
        &self.value[..nx * nx]
    }

    /// The whole cost-to-go, [`Dimensions::value_len`] numbers: `P`, `S`, and of `Y` and each `N_t` the lower triangle by
    /// rows, that of `N_t` from in-flight input `t` on.
    pub fn value(&self) -> &[T] {
        self.value
    }

    /// The whole cost-to-go, to set it. `P` must be symmetric.
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
        let (rows, columns) = (self.dimensions().sequence_rows(), self.dimensions().gain_columns());
        for (gain, coefficient) in self.gains.iter_mut().zip(&*self.linear) {
            *gain = -*coefficient;
        }
        SemidefiniteFactor::new(self.quadratic, rows, self.factor).solve_half(self.gains, columns);
        self.unsolved[0] = T::one();
        let value = core::mem::take(&mut self.value);
        let change = self.step_back::<true>(value);
        self.value = value;
        change
    }

    /// One step with the gains held (THEORY 5): linear in the cost-to-go but for the stage cost.
    pub fn fixed_step(&mut self) {
        let value = core::mem::take(&mut self.value);
        self.fixed_step_of(value);
        self.value = value;
    }

    /// The same for a cost-to-go that is kept elsewhere, of [`Dimensions::value_len`] numbers as [`Synthesis::value`] has them.
    /// The one at hand stays as it is.
    ///
    /// # Panics
    /// If it has fewer.
    pub fn fixed_step_of(&mut self, value: &mut [T]) {
        self.gains();
        self.expect_of(value);
        let (rows, columns) = (self.dimensions().sequence_rows(), self.dimensions().gain_columns());
        // X = G + T L, with T + T^T = Rbar: X^T L, plus the transpose, is sym(G^T L) + L^T Rbar L.
        let half = T::nearest(0.5);
        for (row, out) in self.linear.chunks_exact_mut(columns).enumerate() {
            let weights = &self.quadratic[row * rows..][row..rows];
            let (own, later) = self.gains[row * columns..].split_at(columns);
            add_scaled(out, half * weights[0], own);
            add_rows(out, T::one(), rows - row - 1, (&weights[1..], 1), (later, columns));
        }
        self.step_back::<false>(value);
    }

    /// The link as the recursion sees it.
    pub(super) fn link(&self) -> Link<'_, T> {
        let Self { problem: Problem { survival, dimensions, .. }, later, told, .. } = *self;
        Link { survival, dimensions, later, told }
    }

    /// Fills `quadratic` and `linear` from the cost-to-go.
    pub(super) fn expect(&mut self) {
        let value = core::mem::take(&mut self.value);
        self.expect_of(value);
        self.value = value;
    }

    /// The same from this cost-to-go.
    fn expect_of(&mut self, value: &[T]) {
        let Problem { survival, dimensions, .. } = self.problem;
        let link = Link { survival, dimensions, later: self.later, told: self.told };
        let (p, s, y, told) = link.layout().split(value);
        self.products.compute(&self.problem, p, s);
        Expectations { quadratic: self.quadratic, linear: self.linear }.fill(
            &link,
            &self.problem,
            &self.products,
            (y, told),
            self.sums,
            self.scratch,
        );
    }

    /// Replaces a cost-to-go by that of one cycle earlier, given the products of the old one and what the gains take off:
    /// `W^T W` in `gains`, or `-(X^T L + L^T X)` of `linear` and `gains`.
    fn step_back<const MEASURED: bool>(&mut self, value: &mut [T]) -> T {
        let Problem { survival, dimensions, .. } = self.problem;
        let (nx, columns) = (dimensions.states, dimensions.gain_columns());
        let link = Link { survival, dimensions, later: self.later, told: self.told };
        let effect = Effect {
            gains: self.gains,
            with: if self.unsolved[0].is_zero() { Some(&*self.linear) } else { None },
            rows: dimensions.sequence_rows(),
            columns,
        };
        let (p, s, y, told) = Layout::of(&dimensions).split_mut(value);

        // P = Q + A^T P A + Gx^T Lx, S = D A^T P B V0 + D A^T S (I - C) Z + Gx^T M
        let v = link.later.len();
        let (mut of_p, mut of_s) = (Change::<T, MEASURED>::none(), Change::<T, MEASURED>::none());
        for state in 0..nx {
            let row = &mut self.scratch[..columns];
            let (of_states, of_inputs) = row.split_at_mut(nx);
            of_states.copy_from_slice(&self.problem.q[state * nx..][..nx]);
            add_rows(of_states, T::one(), nx, (&self.problem.a[state..], nx), (self.products.pa, nx));
            of_inputs.fill(T::zero());
            link.add_state_row(&self.products, &self.problem, state, of_inputs, |g| g);
            effect.add(-T::one(), state, state, &mut row[state..]);
            of_p.replace_all(&mut p[state * nx..][state..nx], &row[state..nx]);
            of_s.replace_all(&mut s[state * v..][..v], &row[nx..]);
        }
        mirror_upper(p, nx);

        let of_y = link.move_fresh::<MEASURED>(&self.products, y, self.scratch);
        let mut of_told = link.move_told::<MEASURED>(told, self.scratch);
        let taken = &mut self.sums[..triangle::len(v)];
        effect.fill_triangle(nx, taken);
        link.begin_told(&mut of_told, told, taken);
        [of_p, of_s, of_y, of_told]
            .into_iter()
            .fold(T::zero(), |largest, change| largest.max(change.relative()))
    }
}

/// Rows and columns that are summed beside each other, in registers.
const TILE: usize = 4;

/// What the gains take off the cost, as a quadratic form in `[x; vbar]`.
struct Effect<'w, T> {
    /// `W`, or `L`.
    gains: &'w [T],
    /// `X` where `gains` are the gains themselves.
    with: Option<&'w [T]>,
    rows: usize,
    columns: usize,
}

impl<T: Number> Effect<'_, T> {
    /// Adds `sign` times a part of row `row`, from column `first` on, to `out`.
    fn add(&self, sign: T, row: usize, first: usize, out: &mut [T]) {
        let (gains, columns) = (self.gains, self.columns);
        match self.with {
            None => add_rows(out, sign, self.rows, (&gains[row..], columns), (&gains[first..], columns)),
            Some(with) => {
                add_rows(out, -sign, self.rows, (&with[row..], columns), (&gains[first..], columns));
                add_rows(out, -sign, self.rows, (&gains[row..], columns), (&with[first..], columns));
            }
        }
    }

    /// Writes the triangle of the part from row and column `first` on.
    fn fill_triangle(&self, first: usize, out: &mut [T]) {
        if self.columns - first < TILE {
            self.fill_in_tiles::<1>(first, out);
        } else {
            self.fill_in_tiles::<TILE>(first, out);
        }
    }

    fn fill_in_tiles<const SIZE: usize>(&self, first: usize, out: &mut [T]) {
        let size = self.columns - first;
        for row in (0..size).step_by(SIZE) {
            // The last tile ends with the last row, and does some of the one before again.
            let top = row.min(size - SIZE);
            for column in (0..top + SIZE).step_by(SIZE) {
                let left = column.min(size - SIZE);
                let tile = self.tile::<SIZE>(first + top, first + left);
                for (place, entries) in tile.iter().enumerate() {
                    let row = out[triangle::row(top + place)].get_mut(left..).unwrap_or_default();
                    row.iter_mut().zip(entries).for_each(|(entry, value)| *entry = *value);
                }
            }
        }
    }

    /// The square of entries that begins with row `top` and column `left`.
    fn tile<const SIZE: usize>(&self, top: usize, left: usize) -> [[T; SIZE]; SIZE] {
        let (gains, columns) = (self.gains, self.columns);
        let mut tile = [[T::zero(); SIZE]; SIZE];
        match self.with {
            None => add_tile(&mut tile, T::one(), (gains, top), (gains, left), columns),
            Some(with) => {
                add_tile(&mut tile, -T::one(), (with, top), (gains, left), columns);
                add_tile(&mut tile, -T::one(), (gains, top), (with, left), columns);
            }
        }
        tile
    }
}
