//! The reference solver: the thesis' coupled recursion over the actuator's `N + 1` modes, (3.29), (3.31), (3.32).
//!
//! Dense, `O(N n^3)` a step with `n = nx + nu N (N-1) / 2`. It takes any transition matrix of the age and is what
//! the in-flight recursion is checked against; it shares nothing with it but the rank-revealing solve.

use super::{
    LoopProblem, ModeChain, Solution, Start,
    closed_loop::{ClosedLoop, expect},
    iterate::{Ending, Recursion, iterate},
    law::{Law, mode_weights},
    modes::{Mode, modes},
    tracking::Tracked,
};
use nalgebra::{DMatrix, DVector};
use slqg::synthesis;

pub(super) struct CoupledRecursion {
    /// By age, `N + 1`.
    modes: Vec<Mode>,
    /// What the controller knows of the network; its transitions may be others in each step.
    pub(super) chain: ModeChain,
    states: usize,
    /// `K(i)`, thesis (3.32), for each mode of the chain; the same for the next two.
    pub(super) cost_to_go: Vec<DMatrix<f64>>,
    /// `L(i)`, thesis (3.31).
    pub(super) gains: Vec<DMatrix<f64>>,
    /// `E[R-hat + B-hat^T K B-hat | i]` of the last step.
    sequence_cost: Vec<DMatrix<f64>>,
}

impl CoupledRecursion {
    /// `state_terminal`: cost of the state where the recursion starts, `nx x nx`.
    pub(super) fn new(problem: &LoopProblem, state_terminal: &DMatrix<f64>) -> Self {
        Self::over(ModeChain::independent(&problem.link, problem.length), problem, state_terminal)
    }

    /// The same over any chain; the problem's link does not matter.
    pub(super) fn over(chain: ModeChain, problem: &LoopProblem, state_terminal: &DMatrix<f64>) -> Self {
        let modes = modes(problem);
        let count = chain.ages.len();
        let size = modes[0].a.nrows();
        let mut terminal = DMatrix::zeros(size, size);
        terminal.view_mut((0, 0), state_terminal.shape()).copy_from(state_terminal);
        Self {
            states: problem.a.nrows(),
            cost_to_go: vec![terminal; count],
            gains: vec![DMatrix::zeros(modes[0].b.ncols(), size); count],
            sequence_cost: Vec::new(),
            chain,
            modes,
        }
    }

    /// The loop's matrices in each mode of the chain.
    fn in_modes(&self) -> impl Iterator<Item = &Mode> {
        self.chain.ages.iter().map(|&age| &self.modes[age])
    }

    fn closed_loop(&self) -> ClosedLoop<'_> {
        ClosedLoop { modes: &self.modes, chain: &self.chain, gains: &self.gains }
    }
}

impl Recursion for CoupledRecursion {
    fn step(&mut self) -> f64 {
        let parts: Vec<_> =
            self.in_modes().zip(&self.cost_to_go).map(|(mode, cost)| mode.backward(cost)).collect();
        let state_cost: Vec<_> =
            self.in_modes().zip(&parts).map(|(mode, part)| &mode.q + &part.state).collect();
        let sequence_cost: Vec<_> =
            self.in_modes().zip(&parts).map(|(mode, part)| &mode.r + &part.sequence).collect();
        let (mut difference, mut size) = (0.0, 0.0);
        let mut next = Vec::with_capacity(parts.len());
        self.sequence_cost.clear();
        for from in 0..parts.len() {
            let quadratic = expect(&self.chain.transitions, from, sequence_cost.iter());
            let linear = expect(&self.chain.transitions, from, parts.iter().map(|part| &part.coupling));
            let mut gain = -&linear;
            // Column-major it is the transposed right side that the solve takes by rows.
            solve_semidefinite(&quadratic, gain.as_mut_slice(), linear.nrows());
            self.sequence_cost.push(quadratic);
            let value = expect(&self.chain.transitions, from, state_cost.iter()) + &linear * gain.transpose();
            let value = (&value + value.transpose()) * 0.5;
            difference += (&value - &self.cost_to_go[from]).abs().sum();
            size += value.abs().sum();
            self.gains[from] = gain.transpose();
            next.push(value);
        }
        self.cost_to_go = next;
        difference / size
    }

    fn size(&self) -> f64 {
        self.cost_to_go[0].view((0, 0), (self.states, self.states)).trace()
    }

    /// The reference stays plain value iteration.
    fn evaluate(&mut self, _accuracy: f64) -> bool {
        false
    }

    fn gains(&mut self) -> Vec<f64> {
        self.gains.iter().flat_map(|gain| gain.iter().copied()).collect()
    }

    fn fall_back(&mut self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        self.modes.len()
    }

    fn rate(&mut self) -> f64 {
        self.closed_loop().rate()
    }
}

/// The recursion at its fixed point, and how it got there.
pub(super) fn settle(start: &Start) -> (CoupledRecursion, Ending) {
    let mut recursion = CoupledRecursion::new(&start.problem, start.cost_to_go());
    let ending = iterate(&mut recursion, start.cost_scale(), start.runs_dry());
    (recursion, ending)
}

pub(super) fn solve(start: &Start) -> Solution {
    let problem = &start.problem;
    let (recursion, ending) = settle(start);
    let states = recursion.states;
    Solution {
        outcome: ending.outcome,
        iterations: ending.iterations,
        policy_iterations: ending.policy_iterations,
        residual: ending.residual,
        mean_square_rate: ending.mean_square_rate,
        gain_error: ending.gain_error,
        law: in_flight_form(problem, &recursion.gains),
        cost_to_go: recursion.cost_to_go[0].view((0, 0), (states, states)).into_owned(),
        coupled_gains: Some(recursion.gains),
        value: None,
        slowest: None,
        start: start.clone(),
        unknown_weight: 0.0,
    }
}

/// `L_k(i)` of thesis (3.31) for a task of `steps` cycles with the terminal weight `terminal`, `nx x nx`: for each cycle
/// the gains of all modes, and last the state block of `K_0`.
pub fn finite_horizon_reference(
    problem: &LoopProblem,
    terminal: &DMatrix<f64>,
    steps: usize,
) -> (Vec<Vec<DMatrix<f64>>>, DMatrix<f64>) {
    let mut recursion = CoupledRecursion::new(problem, terminal);
    let mut gains = Vec::with_capacity(steps);
    for _ in 0..steps {
        recursion.step();
        gains.push(recursion.gains.clone());
    }
    gains.reverse();
    let states = recursion.states;
    (gains, recursion.cost_to_go[0].view((0, 0), (states, states)).into_owned())
}

/// Replaces `rhs`, of `columns` columns by rows, by `matrix^# rhs`.
pub(super) fn solve_semidefinite(matrix: &DMatrix<f64>, rhs: &mut [f64], columns: usize) {
    let rows = matrix.nrows();
    let mut workspace = vec![0.0; synthesis::semidefinite_workspace_len(rows)];
    synthesis::SemidefiniteFactor::new(matrix.as_slice(), rows, &mut workspace).solve(rhs, columns);
}

/// Thesis Theorem 4.1 for a task whose output follows `reference`, `z_k` for `k = 0..=K`: for each cycle `Uff` of (4.6), with
/// its sign mended, in every mode; and `sigma_0`, `s_0` of (4.9) and (4.13) for an actuator whose buffer is empty.
pub fn tracking_reference(
    problem: &LoopProblem,
    tracked: &Tracked,
    reference: &[DVector<f64>],
) -> (Vec<Vec<DVector<f64>>>, DVector<f64>, f64) {
    let terminal = tracked.z.tr_mul(&(&tracked.terminal_weight * &tracked.z));
    let mut recursion = CoupledRecursion::new(problem, &terminal);
    let (count, size) = (recursion.gains.len(), recursion.modes[0].a.nrows());
    let weighted = |weight: &DMatrix<f64>, z: &DVector<f64>| {
        let mut sigma = DVector::zeros(size);
        sigma.rows_mut(0, terminal.nrows()).copy_from(&tracked.z.tr_mul(&(weight * z)));
        (sigma, z.dot(&(weight * z)))
    };
    let (last, before) = reference.split_last().expect("a task has an end");
    let (sigma, constant) = weighted(&tracked.terminal_weight, last);
    let (mut sigmas, mut constants) = (vec![sigma; count], vec![constant; count]);
    let mut feedforward = Vec::with_capacity(before.len());
    for z in before.iter().rev() {
        recursion.step();
        let (stage, stage_constant) = weighted(&tracked.weight, z);
        let mut chosen = Vec::with_capacity(count);
        let (mut next_sigmas, mut next_constants) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for from in 0..count {
            let mut passed_on = stage.clone();
            let mut on_sequence = DVector::zeros(recursion.gains[from].nrows());
            let mut constant = stage_constant;
            for (to, mode) in recursion.in_modes().enumerate() {
                let probability = recursion.chain.transitions[(from, to)];
                passed_on += mode.a.tr_mul(&sigmas[to]) * probability;
                on_sequence += mode.b.tr_mul(&sigmas[to]) * probability;
                constant += constants[to] * probability;
            }
            let mut input = on_sequence.clone();
            solve_semidefinite(&recursion.sequence_cost[from], input.as_mut_slice(), 1);
            next_sigmas.push(passed_on + recursion.gains[from].tr_mul(&on_sequence));
            next_constants.push(constant - on_sequence.dot(&input));
            chosen.push(input);
        }
        (sigmas, constants) = (next_sigmas, next_constants);
        feedforward.push(chosen);
    }
    feedforward.reverse();
    let empty = count - 1;
    (feedforward, sigmas[empty].rows(0, terminal.nrows()).into_owned(), constants[empty])
}

/// The one `(Lx, M)` that explains the gains of all modes: `L(i) = [Lx, M V(i)]` (THEORY 3), by least squares.
fn in_flight_form(problem: &LoopProblem, gains: &[DMatrix<f64>]) -> Law {
    let (nx, nu) = (problem.a.nrows(), problem.b.ncols());
    let arrival = problem.arrival_table();
    let sent = gains[0].ncols() - nx;
    let identity = DMatrix::<f64>::identity(nu, nu);
    let weights: Vec<_> = (0..gains.len())
        .map(|mode| mode_weights(problem.length, problem.default_input, &arrival, mode).kronecker(&identity))
        .collect();
    let rows = weights[0].nrows();
    let stacked = DMatrix::from_fn(rows, sent * gains.len(), |row, column| {
        weights[column / sent][(row, column % sent)]
    });
    let explained = DMatrix::from_fn(gains[0].nrows(), sent * gains.len(), |row, column| {
        gains[column / sent][(row, nx + column % sent)]
    });
    let m = if rows == 0 || sent == 0 {
        DMatrix::zeros(gains[0].nrows(), rows)
    } else {
        let inverse = stacked.pseudo_inverse(1e-12).expect("the tolerance is not negative");
        explained * inverse
    };
    Law {
        length: problem.length,
        default_input: problem.default_input,
        lx: gains[0].columns(0, nx).into_owned(),
        m,
        arrival,
    }
}
