//! The plan of constrained model predictive control: one quadratic program in every cycle. Thesis (2.4).
//!
//! Variables are the inputs of the plan and the states that follow from them, `[u_d .. u_{d+H-1}; x_{d+1} .. x_{d+H}]`: with
//! the states kept, an unstable plant does not make the program ill-conditioned. The solver is Clarabel, an interior-point
//! method; from cycle to cycle only the state that the plan starts from changes.

use crate::contender::Constrained;
use clarabel::{
    algebra::CscMatrix,
    solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT},
};
use gain_gen::solve::LoopProblem;
use nalgebra::{DMatrix, DVector, SVector};
use slqg::Scalar;

/// The program with its solver, and what the plan does not begin with.
pub(super) struct Optimiser {
    problem: LoopProblem,
    limits: Vec<(f64, f64)>,
    delay: usize,
    solver: DefaultSolver<f64>,
    /// Right-hand side of the constraints; the first `nx` numbers are `A x_d`.
    bounds: Vec<f64>,
}

/// Entries of a sparse matrix, in any order.
#[derive(Default)]
struct Entries {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl Entries {
    /// Puts `block` at this place; `upper` keeps only what is on the diagonal of the whole or above it.
    fn put(&mut self, (row, column): (usize, usize), block: &DMatrix<f64>, upper: bool) {
        for (at, &value) in block.iter().enumerate() {
            let (row, column) = (row + at % block.nrows(), column + at / block.nrows());
            if value != 0.0 && !(upper && row > column) {
                self.rows.push(row);
                self.columns.push(column);
                self.values.push(value);
            }
        }
    }

    fn matrix(self, rows: usize, columns: usize) -> CscMatrix<f64> {
        CscMatrix::new_from_triplets(rows, columns, self.rows, self.columns, self.values)
    }
}

impl Optimiser {
    pub(super) fn new(constrained: &Constrained) -> Self {
        let Constrained { problem, terminal, limits, horizon, delay, .. } = constrained;
        let (states, inputs) = problem.b.shape();
        let (planned, size) = (horizon * inputs, horizon * (inputs + states));
        let state_at = |ahead: usize| planned + (ahead - 1) * states;

        // The solver minimises half of the form.
        let mut weights = Entries::default();
        for ahead in 0..*horizon {
            weights.put((ahead * inputs, ahead * inputs), &(&problem.r * 2.0), true);
            let weight = if ahead + 1 < *horizon { &problem.q } else { terminal };
            weights.put((state_at(ahead + 1), state_at(ahead + 1)), &(weight * 2.0), true);
        }
        // x_{t+1} - A x_t - B u_t = 0, then u <= greatest, then -u <= -least.
        let mut constraints = Entries::default();
        let (dynamics, one) = (horizon * states, DMatrix::identity(states, states));
        for ahead in 0..*horizon {
            let row = ahead * states;
            constraints.put((row, ahead * inputs), &-&problem.b, false);
            constraints.put((row, state_at(ahead + 1)), &one, false);
            if ahead > 0 {
                constraints.put((row, state_at(ahead)), &-&problem.a, false);
            }
        }
        let one = DMatrix::identity(planned, planned);
        constraints.put((dynamics, 0), &one, false);
        constraints.put((dynamics + planned, 0), &-one, false);
        let greatest = limits.iter().map(|limit| limit.1).cycle().take(planned);
        let least = limits.iter().map(|limit| -limit.0).cycle().take(planned);
        let bounds: Vec<f64> = std::iter::repeat_n(0.0, dynamics).chain(greatest).chain(least).collect();

        let cones = [SupportedConeT::ZeroConeT(dynamics), SupportedConeT::NonnegativeConeT(2 * planned)];
        // Presolving would drop rows that the next cycle needs.
        let settings =
            DefaultSettings { verbose: false, presolve_enable: false, ..DefaultSettings::default() };
        let solver = DefaultSolver::new(
            &weights.matrix(size, size),
            &vec![0.0; size],
            &constraints.matrix(bounds.len(), size),
            &bounds,
            &cones,
            settings,
        );
        Self {
            problem: problem.clone(),
            limits: limits.clone(),
            delay: *delay,
            solver: solver.expect("dimensions agree"),
            bounds,
        }
    }

    /// The sequence for the estimate `posterior_mean`, with `expected` in flight; every input within the limits.
    ///
    /// Where the solver finds no plan, as for a state that has grown beyond all bounds, it repeats what is in flight.
    pub(super) fn sequence<T: Scalar, const NX: usize, const NU: usize>(
        &mut self,
        posterior_mean: &SVector<T, NX>,
        expected: &[SVector<T, NU>],
    ) -> Vec<SVector<T, NU>> {
        let (states, inputs) = self.problem.b.shape();
        let expected_at = |ahead: usize| {
            let input = expected.get(ahead).copied().unwrap_or_else(SVector::zeros);
            DVector::from_fn(inputs, |row, _| input[row].widen())
        };
        let mut state = DVector::from_fn(states, |row, _| posterior_mean[row].widen());
        for ahead in 0..self.delay {
            state = &self.problem.a * state + &self.problem.b * expected_at(ahead);
        }
        let plan = self.plan(&(&self.problem.a * state));
        let input_at = |ahead: usize| {
            let own = ahead.checked_sub(self.delay).zip(plan.as_ref());
            let input = match own {
                Some((place, plan)) => plan.rows(place * inputs, inputs).into_owned(),
                None => expected_at(ahead),
            };
            // A plan is within its limits up to the solver's tolerance.
            SVector::from_fn(|row, _| {
                let Some(&(least, greatest)) = self.limits.get(row) else { return T::zero() };
                T::nearest(input[row].clamp(least, greatest))
            })
        };
        (0..self.problem.length).map(input_at).collect()
    }

    /// The inputs from the `d`-th cycle on, one after the other, where `next` is `A x_d`.
    fn plan(&mut self, next: &DVector<f64>) -> Option<DVector<f64>> {
        self.bounds[..next.len()].copy_from_slice(next.as_slice());
        if !next.iter().all(|value| value.is_finite()) {
            return None;
        }
        self.solver.update_b(&self.bounds).expect("nothing was presolved");
        self.solver.solve();
        let found = matches!(self.solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
        found.then(|| DVector::from_column_slice(&self.solver.solution.x))
    }
}
