//! The reference solver: the thesis' coupled recursion over the actuator's `N + 1` modes, (3.29), (3.31), (3.32).
//!
//! Dense, `O(N n^3)` a step with `n = nx + nu N (N-1) / 2`. It takes any transition matrix of the age and is what
//! the in-flight recursion is checked against; it shares nothing with it but the rank-revealing solve.

use super::{
    LoopProblem, Solution, age_transitions,
    iterate::{Recursion, iterate},
    law::{Law, mode_weights},
    spectral::spectral_radius,
};
use crate::stability;
use nalgebra::DMatrix;
use slqg::{DefaultInput, arrival, synthesis};

/// The loop in one mode: thesis (3.29), for hold (3.42) with its misprints mended.
pub(crate) struct Mode {
    /// `A-hat`, `n x n`.
    pub(crate) a: DMatrix<f64>,
    /// `B-hat`, `n x N nu`.
    pub(crate) b: DMatrix<f64>,
    /// `Q-hat`, `n x n`.
    q: DMatrix<f64>,
    /// `R-hat`, `N nu` square.
    r: DMatrix<f64>,
    /// What is not zero in `a` and `b`: outside the plant's rows they only shift.
    a_entries: Vec<Entry>,
    b_entries: Vec<Entry>,
}

/// Row, column and value of an entry that is not zero.
type Entry = (usize, usize, f64);

fn entries(matrix: &DMatrix<f64>) -> Vec<Entry> {
    let all = (0..matrix.ncols()).flat_map(|column| (0..matrix.nrows()).map(move |row| (row, column)));
    all.filter(|&at| matrix[at] != 0.0).map(|(row, column)| (row, column, matrix[(row, column)])).collect()
}

/// `left` times a matrix of `columns` columns that has only these entries.
fn times(left: &DMatrix<f64>, entries: &[Entry], columns: usize) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(left.nrows(), columns);
    for &(row, column, value) in entries {
        product.column_mut(column).axpy(value, &left.column(row), 1.0);
    }
    product
}

/// A cost `xi^T K xi` at the end of a step, in terms of where the step starts and the sequence sent.
struct Backward {
    /// `A^T K A`, `n x n`.
    state: DMatrix<f64>,
    /// `A^T K B`, `n x N nu`. Column-major it is the row-major `B^T K A` that the core's solve takes.
    coupling: DMatrix<f64>,
    /// `B^T K B`, `N nu` square.
    sequence: DMatrix<f64>,
}

impl Mode {
    /// One step back with the symmetric cost `k`, `n x n`.
    fn backward(&self, k: &DMatrix<f64>) -> Backward {
        let (size, inputs) = self.b.shape();
        let a_k = times(k, &self.a_entries, size).transpose();
        let b_k = times(k, &self.b_entries, inputs).transpose();
        Backward {
            state: times(&a_k, &self.a_entries, size),
            coupling: times(&a_k, &self.b_entries, inputs),
            sequence: times(&b_k, &self.b_entries, inputs),
        }
    }
}

/// The loop in every mode `theta = 0..=N`.
pub(crate) fn modes(problem: &LoopProblem) -> Vec<Mode> {
    let (nx, nu, length) = (problem.a.nrows(), problem.b.ncols(), problem.length);
    let sent = arrival::table_len(length);
    let hold = problem.default_input == DefaultInput::Hold;
    let n = nx + nu * (sent + usize::from(hold));
    let identity = DMatrix::<f64>::identity(nu, nu);
    let column_of = |age: usize, m: usize| nx + nu * arrival::table_index(length, age, m);
    let last_input = nx + nu * sent;

    // What does not depend on the mode: the plant, and packets growing one cycle older. F and G of (3.27).
    let mut a = DMatrix::zeros(n, n);
    a.view_mut((0, 0), (nx, nx)).copy_from(&problem.a);
    let mut b = DMatrix::zeros(n, length * nu);
    for age in 1..length {
        for m in 0..length - age {
            if age == 1 {
                b.view_mut((column_of(1, m), (m + 1) * nu), (nu, nu)).copy_from(&identity);
            } else {
                a.view_mut((column_of(age, m), column_of(age - 1, m + 1)), (nu, nu)).copy_from(&identity);
            }
        }
    }
    (0..=length)
        .map(|theta| {
            // u_k = from_state xi + from_sequence U: H, J and D of (3.28).
            let mut from_state = DMatrix::zeros(nu, n);
            let mut from_sequence = DMatrix::zeros(nu, length * nu);
            if theta == 0 {
                from_sequence.view_mut((0, 0), (nu, nu)).copy_from(&identity);
            } else if theta < length {
                from_state.view_mut((0, column_of(theta, 0)), (nu, nu)).copy_from(&identity);
            } else if hold {
                from_state.view_mut((0, last_input), (nu, nu)).copy_from(&identity);
            }
            let (mut a, mut b) = (a.clone(), b.clone());
            let mut plant_rows = a.rows_mut(0, nx);
            plant_rows += &problem.b * &from_state;
            let mut plant_rows = b.rows_mut(0, nx);
            plant_rows += &problem.b * &from_sequence;
            if hold {
                a.rows_mut(last_input, nu).copy_from(&from_state);
                b.rows_mut(last_input, nu).copy_from(&from_sequence);
            }
            let mut q = from_state.transpose() * &problem.r * &from_state;
            let mut of_state = q.view_mut((0, 0), (nx, nx));
            of_state += &problem.q;
            let r = from_sequence.transpose() * &problem.r * &from_sequence;
            Mode { a_entries: entries(&a), b_entries: entries(&b), a, b, q, r }
        })
        .collect()
}

struct CoupledRecursion {
    modes: Vec<Mode>,
    transitions: DMatrix<f64>,
    states: usize,
    /// `K(i)`, thesis (3.32).
    cost_to_go: Vec<DMatrix<f64>>,
    /// `L(i)`, thesis (3.31).
    gains: Vec<DMatrix<f64>>,
}

impl CoupledRecursion {
    /// `state_terminal`: cost of the state where the recursion starts, `nx x nx`.
    fn new(problem: &LoopProblem, state_terminal: &DMatrix<f64>) -> Self {
        let modes = modes(problem);
        let size = modes[0].a.nrows();
        let mut terminal = DMatrix::zeros(size, size);
        terminal.view_mut((0, 0), state_terminal.shape()).copy_from(state_terminal);
        Self {
            transitions: age_transitions(&problem.link, problem.length),
            states: problem.a.nrows(),
            cost_to_go: vec![terminal; modes.len()],
            gains: modes.iter().map(|mode| DMatrix::zeros(mode.b.ncols(), size)).collect(),
            modes,
        }
    }

    fn closed_loop(&self) -> ClosedLoop<'_> {
        ClosedLoop { modes: &self.modes, transitions: &self.transitions, gains: &self.gains }
    }
}

/// `sum_j p(i, j) parts[j]`, row `i` of the transition matrix.
fn expect<'p>(
    transitions: &DMatrix<f64>,
    from: usize,
    parts: impl Iterator<Item = &'p DMatrix<f64>>,
) -> DMatrix<f64> {
    let mut terms = parts.enumerate().map(|(to, part)| (transitions[(from, to)], part));
    let (probability, first) = terms.next().expect("there are at least two modes");
    let mut sum = first * probability;
    for (probability, part) in terms.filter(|&(probability, _)| probability > 0.0) {
        sum.zip_apply(part, |entry, term| *entry += probability * term);
    }
    sum
}

/// Steps that the search for the rate takes in one. A step costs less than making a direction orthogonal to all found
/// before, and several at once leave fewer directions: most are packets that fade within a sequence.
const STRIDE: u32 = 16;

/// The loop with one gain per acknowledged age held: thesis (3.29) with `U = L(j) xi`.
#[derive(Clone, Copy)]
pub(crate) struct ClosedLoop<'a> {
    /// The loop in every mode, `N + 1`.
    pub(crate) modes: &'a [Mode],
    /// `p(j, i)`, `(N+1) x (N+1)`.
    pub(crate) transitions: &'a DMatrix<f64>,
    /// `L(j)`, `(N nu) x n` each.
    pub(crate) gains: &'a [DMatrix<f64>],
}

impl ClosedLoop<'_> {
    /// Size of the augmented state, `n`.
    pub(crate) fn size(&self) -> usize {
        self.modes[0].a.nrows()
    }

    /// Expected costs a step earlier: `sum_i p(j,i) (A(i)+B(i)L(j))^T X(i) (A(i)+B(i)L(j))` for `j = 0..=N`, the right
    /// side of thesis (3.36). Symmetric `X(0), .., X(N)` one after the other, `n x n` each.
    ///
    /// Multiplied out, so that products of `n x n` matrices are taken once a mode and not once a pair of modes.
    pub(crate) fn apply(&self, from: &[f64], to: &mut [f64]) {
        let size = self.size();
        let costs = from.chunks_exact(size * size).map(|cost| DMatrix::from_column_slice(size, size, cost));
        let parts: Vec<_> = self.modes.iter().zip(costs).map(|(mode, cost)| mode.backward(&cost)).collect();
        for ((mode, gain), out) in self.gains.iter().enumerate().zip(to.chunks_exact_mut(size * size)) {
            let state = expect(self.transitions, mode, parts.iter().map(|part| &part.state));
            let coupling = expect(self.transitions, mode, parts.iter().map(|part| &part.coupling));
            let sequence = expect(self.transitions, mode, parts.iter().map(|part| &part.sequence));
            let half = state * 0.5 + (coupling + gain.tr_mul(&(sequence * 0.5))) * gain;
            out.copy_from_slice((&half + half.transpose()).as_slice());
        }
    }

    /// Spectral radius of [`ClosedLoop::apply`]: the mean-square rate, below 1 iff the loop is mean-square stable.
    pub(crate) fn rate(&self) -> f64 {
        let one = DMatrix::<f64>::identity(self.size(), self.size()).as_slice().repeat(self.modes.len());
        let mut between = one.clone();
        let radius = spectral_radius(&one, |from, to| {
            self.apply(from, to);
            for _ in 1..STRIDE {
                between.copy_from_slice(to);
                self.apply(&between, to);
            }
        });
        radius.powf(1.0 / f64::from(STRIDE))
    }
}

/// Mean-square rate of the problem's plant and link with the gains `L(j)`, `j = 0..=N`, of [`Solution::mode_gains`].
///
/// The gains need not be made for this problem: that is how margins are found. Dense, so slow for long sequences.
///
/// # Panics
/// If the gains do not have the problem's dimensions.
pub fn mean_square_rate(problem: &LoopProblem, gains: &[DMatrix<f64>]) -> f64 {
    let transitions = age_transitions(&problem.link, problem.length);
    ClosedLoop { modes: &modes(problem), transitions: &transitions, gains }.rate()
}

impl Recursion for CoupledRecursion {
    fn step(&mut self) -> f64 {
        let parts: Vec<_> =
            self.modes.iter().zip(&self.cost_to_go).map(|(mode, cost)| mode.backward(cost)).collect();
        let state_cost: Vec<_> =
            self.modes.iter().zip(&parts).map(|(mode, part)| &mode.q + &part.state).collect();
        let sequence_cost: Vec<_> =
            self.modes.iter().zip(&parts).map(|(mode, part)| &mode.r + &part.sequence).collect();
        let (mut difference, mut size) = (0.0, 0.0);
        let mut next = Vec::with_capacity(self.modes.len());
        for from in 0..self.modes.len() {
            let quadratic = expect(&self.transitions, from, sequence_cost.iter());
            let linear = expect(&self.transitions, from, parts.iter().map(|part| &part.coupling));
            let mut gain = -&linear;
            let rows = quadratic.nrows();
            let mut workspace = vec![0.0; synthesis::semidefinite_workspace_len(rows)];
            synthesis::SemidefiniteFactor::new(quadratic.as_slice(), rows, &mut workspace)
                .solve(gain.as_mut_slice(), linear.nrows());
            let value = expect(&self.transitions, from, state_cost.iter()) + &linear * gain.transpose();
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
    fn evaluate(&mut self) -> bool {
        false
    }

    fn memory(&self) -> usize {
        self.modes.len()
    }

    fn rate(&self) -> f64 {
        self.closed_loop().rate()
    }
}

pub(super) fn solve(problem: &LoopProblem) -> Solution {
    let mut recursion = CoupledRecursion::new(problem, &problem.q);
    let ending = iterate(&mut recursion, problem.stage_cost_scale(), stability::runs_dry(problem));
    let states = recursion.states;
    Solution {
        outcome: ending.outcome,
        iterations: ending.iterations,
        policy_iterations: ending.policy_iterations,
        residual: ending.residual,
        mean_square_rate: ending.mean_square_rate,
        law: in_flight_form(problem, &recursion.gains),
        cost_to_go: recursion.cost_to_go[0].view((0, 0), (states, states)).into_owned(),
        coupled_gains: Some(recursion.gains),
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
