//! [`Solver`]: gains and a proof of stability for a link, computed on the device in slices.
//!
//! A slice is one backward step of [`crate::synthesis`], or less, so that it fits beside a control cycle. First value
//! iteration, until the residual of the fixed-point equation is at rounding level; then the proof of `certificate`, for the
//! gains as the numbers they have become.
//!
//! Value iteration starts from the cost-to-go found last. From any positive semidefinite cost-to-go it converges to the same
//! fixed point as from zero, if there is one: its `j`-th iterate is the least cost of `j` cycles that end with the start as
//! terminal cost. That is at least the least cost without a terminal one, and at most what the optimal law costs, whose
//! terminal cost fades with the rate of its loop. Both bounds go to the fixed point. A good start only shortens the way.

use super::certificate::{self, Difference};
use super::{Basis, Progress, Solved, Unsolved, workspace_len};
use crate::{
    Scalar, arrival,
    estimator::Model,
    synthesis::{Dimensions, InvalidProblem, Problem, Synthesis},
};
use nalgebra::SMatrix;

/// Residual at which the fixed point counts as reached, in rounding errors.
const RESIDUAL: f64 = 4.0;
/// Residual that counts when rounding lets it fall no further, in rounding errors.
const ROUNDING_FLOOR: f64 = 64.0;
/// Steps without a smaller residual after which it is at its floor.
const PATIENCE: u32 = 64;
/// Steps of a proof before its first look; then at every doubling.
const FIRST_LOOK: u32 = 8;
/// Share of the cost-to-go that may be left.
const LEFT: f64 = 0.5;
/// Smallest pivot that a proof accepts, in rounding errors per row.
const MARGIN: f64 = 8.0;

#[derive(Debug, Clone, Copy)]
enum Phase<T> {
    Idle,
    Iterating {
        steps: u32,
        smallest: T,
        stalled: u32,
    },
    Proving {
        found: Solved<T>,
        look: u32,
    },
    /// `block` counts through those of the cost-to-go itself, then through those of what is left of it.
    Looking {
        found: Solved<T>,
        look: u32,
        block: usize,
    },
}

/// Solves for one link after the other, in memory of the caller's.
#[derive(Debug)]
pub struct Solver<'m, T, const NX: usize, const NU: usize> {
    dimensions: Dimensions,
    /// `A^T` and `B^T` by columns: `A` and `B` by rows.
    a: SMatrix<T, NX, NX>,
    b: SMatrix<T, NU, NX>,
    basis: Basis<'m, T>,
    most_steps: u32,
    /// Of the link that is being solved for.
    survival: &'m mut [T],
    phase: Phase<T>,
    workspace: &'m mut [T],
    /// The cost-to-go found last, by optimal steps.
    value: &'m mut [T],
    scratch: &'m mut [T],
    /// Zeros: the weights of a loop that costs nothing.
    nothing: &'m mut [T],
}

impl<'m, T: Scalar, const NX: usize, const NU: usize> Solver<'m, T, NX, NU> {
    /// A solver for the plant `model` and the cost of `basis`, with nothing to do; `memory` needs [`workspace_len`] numbers.
    /// It gives up after `most_steps` backward steps, and after as many steps of a proof.
    ///
    /// # Errors
    /// Names the slice whose length does not fit.
    pub fn new<const NY: usize>(
        model: &Model<T, NX, NU, NY>,
        basis: Basis<'m, T>,
        most_steps: u32,
        memory: &'m mut [T],
    ) -> Result<Self, InvalidProblem> {
        let dimensions = basis.dimensions(NX, NU);
        if memory.len() < workspace_len(&dimensions) {
            return Err(InvalidProblem::Workspace);
        }
        memory.fill(T::zero());
        let (workspace, rest) = memory.split_at_mut(dimensions.workspace_len());
        let (value, rest) = rest.split_at_mut(dimensions.value_len());
        let (scratch, rest) = rest.split_at_mut(certificate::scratch_len(&dimensions));
        let (survival, nothing) = rest.split_at_mut(dimensions.length);
        survival.copy_from_slice(basis.survival);
        let mut solver = Self {
            dimensions,
            a: model.a.transpose(),
            b: model.b.transpose(),
            basis,
            most_steps,
            survival,
            phase: Phase::Idle,
            workspace,
            value,
            scratch,
            nothing,
        };
        solver.synthesis(true).map(drop)?;
        solver.start_anew();
        Ok(solver)
    }

    /// Begins to solve for the link with this survival function, from the cost-to-go found last; what it was at is dropped.
    /// Numbers that are missing are taken from the last one.
    pub fn begin(&mut self, survival: &[T]) {
        let mut last = T::one();
        let given = survival.iter().map(Some).chain(core::iter::repeat(None));
        for (value, given) in self.survival.iter_mut().zip(given) {
            last = given.copied().unwrap_or(last);
            *value = last;
        }
        self.workspace[..self.value.len()].copy_from_slice(self.value);
        self.phase = Phase::Iterating { steps: 0, smallest: T::nearest(f64::INFINITY), stalled: 0 };
    }

    /// Whether the next slice has nothing to do.
    pub fn is_idle(&self) -> bool {
        matches!(self.phase, Phase::Idle)
    }

    /// Whether the next slice belongs to the proof.
    pub fn is_proving(&self) -> bool {
        matches!(self.phase, Phase::Proving { .. } | Phase::Looking { .. })
    }

    /// Survival function of the link that was solved for last, or is being solved for.
    pub fn survival(&self) -> &[T] {
        self.survival
    }

    /// Writes the law of the last step: `Lx`, `M` and the arrival probabilities `r` one after the other, by rows, as
    /// [`crate::bank::Bank::spare`] takes them.
    pub fn write_law(&mut self, tables: &mut [T]) {
        let (rows, columns) = (self.dimensions.sequence_rows(), self.dimensions.gain_columns());
        let (lx, rest) = tables.split_at_mut((rows * NX).min(tables.len()));
        let (m, arrival) = rest.split_at_mut((rows * (columns - NX)).min(rest.len()));
        // The lengths were checked when the solver was made.
        if let Ok(mut synthesis) = self.synthesis(true) {
            let gains = synthesis.gains();
            let by_row = || gains.chunks_exact(columns).map(|row| row.split_at(NX));
            lx.iter_mut().zip(by_row().flat_map(|(lx, _)| lx)).for_each(|(to, from)| *to = *from);
            m.iter_mut().zip(by_row().flat_map(|(_, m)| m)).for_each(|(to, from)| *to = *from);
        }
        if arrival.len() >= arrival::table_len(self.dimensions.length) {
            arrival::fill_table(self.survival(), arrival);
        }
    }

    /// One step, or less.
    pub fn slice(&mut self) -> Progress<T> {
        match self.phase {
            Phase::Idle => Progress::Idle,
            Phase::Iterating { steps, smallest, stalled } => self.iterate(steps + 1, smallest, stalled + 1),
            Phase::Proving { found, look } => self.prove(found, look),
            Phase::Looking { found, look, block } => self.look(found, look, block),
        }
    }

    fn iterate(&mut self, steps: u32, smallest: T, stalled: u32) -> Progress<T> {
        let Ok(mut synthesis) = self.synthesis(true) else { return Progress::Idle };
        let residual = synthesis.optimal_step();
        let stalled = if residual < smallest { 0 } else { stalled };
        let rounding = |errors: f64| T::nearest(errors) * T::EPSILON;
        let at_floor = residual <= rounding(ROUNDING_FLOOR) && stalled >= PATIENCE;
        if residual <= rounding(RESIDUAL) || at_floor {
            self.value.copy_from_slice(&self.workspace[..self.value.len()]);
            let found = Solved { steps, proof_steps: 0, residual, rate: T::one() };
            self.phase = Phase::Proving { found, look: FIRST_LOOK };
        } else if !residual.is_finite() {
            return self.give_up(Unsolved::Diverged);
        } else if steps >= self.most_steps {
            return self.give_up(Unsolved::NotConverged);
        } else {
            self.phase = Phase::Iterating { steps, smallest: smallest.min(residual), stalled };
        }
        Progress::Working
    }

    /// One step of `T^m V`.
    fn prove(&mut self, found: Solved<T>, look: u32) -> Progress<T> {
        let Ok(mut homogeneous) = self.synthesis(false) else { return Progress::Idle };
        homogeneous.fixed_step();
        let found = Solved { proof_steps: found.proof_steps + 1, ..found };
        self.phase = if found.proof_steps >= look {
            Phase::Looking { found, look, block: 0 }
        } else {
            Phase::Proving { found, look }
        };
        Progress::Working
    }

    /// One matrix of `V` or of `V / 2 - T^m V`.
    fn look(&mut self, found: Solved<T>, look: u32, block: usize) -> Progress<T> {
        let blocks = certificate::blocks(&self.dimensions);
        let difference = Difference {
            dimensions: self.dimensions,
            share: if block < blocks { T::one() } else { T::nearest(LEFT) },
            value: &*self.value,
            less: (block >= blocks).then_some(&self.workspace[..self.value.len()]),
        };
        let margin = T::nearest(MARGIN * self.dimensions.gain_columns() as f64) * T::EPSILON;
        // A state that the plant leaves at zero need not cost anything.
        let (a, b) = (&self.a, &self.b);
        let is_inert = |state| {
            a.column(state).iter().all(|entry| entry.is_zero())
                && b.column(state).iter().all(|entry| entry.is_zero())
        };
        let holds = difference.is_positive(block % blocks, margin, is_inert, self.scratch);
        let last = block + 1 == 2 * blocks;
        if holds && last {
            self.phase = Phase::Idle;
            let m = T::nearest(f64::from(found.proof_steps));
            let rate = (T::nearest(LEFT).logarithm() / m).exponential();
            return Progress::Solved(Solved { rate, ..found });
        }
        if holds {
            self.phase = Phase::Looking { found, look, block: block + 1 };
        } else if block < blocks || look >= self.most_steps {
            return self.give_up(Unsolved::NotProved);
        } else {
            self.phase = Phase::Proving { found, look: look.saturating_mul(2).min(self.most_steps) };
        }
        Progress::Working
    }

    fn give_up(&mut self, why: Unsolved) -> Progress<T> {
        self.phase = Phase::Idle;
        if why == Unsolved::NotProved {
            // What could not be proved to fall is no start to go on from.
            self.start_anew();
        }
        Progress::Unsolved(why)
    }

    /// Goes on from `x^T Q x`.
    fn start_anew(&mut self) {
        self.value.fill(T::zero());
        self.value[..NX * NX].copy_from_slice(self.basis.state_cost);
    }

    /// The recursion as the last slice left it: with its cost, or without any.
    fn synthesis(&mut self, costs: bool) -> Result<Synthesis<'_, '_, T>, InvalidProblem> {
        let (nx, nu) = (NX * NX, NU * NU);
        let (q, r) = if costs {
            (self.basis.state_cost, self.basis.input_cost)
        } else {
            (&self.nothing[..nx], &self.nothing[..nu])
        };
        let survival = &*self.survival;
        let problem = Problem {
            dimensions: self.dimensions,
            a: self.a.as_slice(),
            b: self.b.as_slice(),
            q,
            r,
            survival,
        };
        Synthesis::resume(problem, self.workspace)
    }
}
