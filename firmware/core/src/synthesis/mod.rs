//! The in-flight recursion that computes the gains: once, for `f32` and `f64`, generator and device.
//!
//! THEORY 4 and 5. One backward step of the optimal cost-to-go
//!
//! ```text
//! V(x, rho, theta) = x^T P x + 2 x^T S vbar + <Y, E[v v^T]> - sum_t <N_t, E[vbar_t vbar_t^T]> + const
//! ```
//!
//! costs O(n_v^3 nu^2 + (N nu)^3) and touches only memory that the caller supplies. Matrices are row-major slices, symmetric
//! ones of the inputs in flight by their triangle, and every sum has its order, so that the same input gives the same
//! bits on every machine. [`Synthesis::optimal_step`] minimises, [`Synthesis::fixed_step`] evaluates given gains. When to
//! stop, and whether the loop can be stabilised, is for the caller to decide.
//!
//! A reference adds a linear part to the cost-to-go, [`LinearCost`] (THEORY 6); what sending a packet is worth comes from
//! the same matrices, [`Synthesis::fill_trigger`] (THEORY 7).

mod change;
mod cost_to_go;
mod dense;
mod expectation;
mod linear;
mod link;
mod semidefinite;
mod step;
mod triangle;
mod trigger;

use crate::{DefaultInput, Number};

pub(crate) use cost_to_go::Layout;
pub use linear::{LinearCost, Stage};
pub use semidefinite::{SemidefiniteFactor, workspace_len as semidefinite_workspace_len};
pub use step::Synthesis;

/// Sizes of a synthesis problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dimensions {
    /// States of the plant, `nx`.
    pub states: usize,
    /// Inputs of the plant, `nu`.
    pub inputs: usize,
    /// Inputs per sequence, `N`, at least 1.
    pub length: usize,
    /// What the actuator applies when its buffer has run out.
    pub default_input: DefaultInput,
}

impl Dimensions {
    /// In-flight inputs, `n_v`.
    pub const fn in_flight(&self) -> usize {
        self.default_input.in_flight(self.length)
    }

    /// Rows of the gains: `N nu`.
    pub const fn sequence_rows(&self) -> usize {
        self.length * self.inputs
    }

    /// Entries of the stacked in-flight inputs: `n_v nu`.
    pub const fn in_flight_rows(&self) -> usize {
        self.in_flight() * self.inputs
    }

    /// Numbers in one cost-to-go: `P`, `S`, and triangles of `Y` and the `n_v` matrices `N_t`.
    pub const fn value_len(&self) -> usize {
        Layout::of(self).len()
    }

    /// Columns of the gains over `[x; vbar]`: `nx + n_v nu`.
    pub const fn gain_columns(&self) -> usize {
        self.states + self.in_flight_rows()
    }

    /// Numbers a [`LinearCost`] needs as workspace.
    pub const fn linear_workspace_len(&self) -> usize {
        2 * self.gain_columns() + 2 * self.sequence_rows() + self.in_flight_rows()
    }

    /// Numbers a [`Synthesis`] needs as workspace.
    pub const fn workspace_len(&self) -> usize {
        let (rows, columns) = (self.sequence_rows(), self.gain_columns());
        self.value_len()
            + rows * rows                        // Rbar
            + semidefinite::workspace_len(rows)
            + 2 * rows * columns                 // G = [Gx Gv], gains
            + 1                                  // whether the gains are solved for
            + self.in_flight_rows()              // survival by in-flight input
            + 2 * self.in_flight()               // and by when it is told
            + expectation::products_len(self)
            + expectation::sums_len(self)
            + columns // to work in
    }
}

/// A plant, its cost and its link, as row-major slices.
#[derive(Debug, Clone, Copy)]
pub struct Problem<'a, T> {
    /// Sizes of everything else.
    pub dimensions: Dimensions,
    /// `A`, `nx x nx`.
    pub a: &'a [T],
    /// `B`, `nx x nu`.
    pub b: &'a [T],
    /// `Q`, `nx x nx`, symmetric positive semidefinite.
    pub q: &'a [T],
    /// `R`, `nu x nu`, symmetric positive definite.
    pub r: &'a [T],
    /// Survival function of the controller-to-actuator delay, `N` values, from [`crate::arrival::survival`].
    pub survival: &'a [T],
}

/// Which slice has a length other than the dimensions ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum InvalidProblem {
    /// `length`, `states` or `inputs` is zero.
    Empty,
    /// `a`.
    A,
    /// `b`.
    B,
    /// `q`.
    Q,
    /// `r`.
    R,
    /// `survival`.
    Survival,
    /// The workspace is shorter than [`Dimensions::workspace_len`].
    Workspace,
}

impl core::fmt::Display for InvalidProblem {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Empty => "states, inputs and sequence length must be at least 1",
            Self::A => "a must have states x states entries",
            Self::B => "b must have states x inputs entries",
            Self::Q => "q must have states x states entries",
            Self::R => "r must have inputs x inputs entries",
            Self::Survival => "survival must have one entry per input of a sequence",
            Self::Workspace => "the workspace is too short",
        })
    }
}

impl core::error::Error for InvalidProblem {}

impl<T: Number> Problem<'_, T> {
    fn check(&self, workspace: usize) -> Result<(), InvalidProblem> {
        let Dimensions { states: nx, inputs: nu, length, .. } = self.dimensions;
        if nx == 0 || nu == 0 || length == 0 {
            return Err(InvalidProblem::Empty);
        }
        let shapes = [
            (self.a.len() == nx * nx, InvalidProblem::A),
            (self.b.len() == nx * nu, InvalidProblem::B),
            (self.q.len() == nx * nx, InvalidProblem::Q),
            (self.r.len() == nu * nu, InvalidProblem::R),
            (self.survival.len() == length, InvalidProblem::Survival),
            (workspace >= self.dimensions.workspace_len(), InvalidProblem::Workspace),
        ];
        shapes.into_iter().find(|(fits, _)| !fits).map_or(Ok(()), |(_, wrong)| Err(wrong))
    }
}
