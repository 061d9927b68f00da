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
struct Mode {
    /// `A-hat`, `n x n`.
    a: DMatrix<f64>,
    /// `A-hat^T`: nalgebra multiplies by a transposed copy several times faster than by a transposed view.
    a_transposed: DMatrix<f64>,
    /// `B-hat^T`.
    b_transposed: DMatrix<f64>,
    /// `B-hat`, `n x N nu`.
    b: DMatrix<f64>,
    /// `Q-hat`, `n x n`.
    q: DMatrix<f64>,
    /// `R-hat`, `N nu` square.
    r: DMatrix<f64>,
}

/// The loop in every mode `theta = 0..=N`.
fn modes(problem: &LoopProblem) -> Vec<Mode> {
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
            Mode { a_transposed: a.transpose(), b_transposed: b.transpose(), a, b, q, r }
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
    fn new(problem: &LoopProblem) -> Self {
        let modes = modes(problem);
        let size = modes[0].a.nrows();
        let mut terminal = DMatrix::zeros(size, size);
        terminal.view_mut((0, 0), problem.q.shape()).copy_from(&problem.q);
        Self {
            transitions: age_transitions(&problem.link, problem.length),
            states: problem.a.nrows(),
            cost_to_go: vec![terminal; modes.len()],
            gains: modes.iter().map(|mode| DMatrix::zeros(mode.b.ncols(), size)).collect(),
            modes,
        }
    }

    /// `sum_j p(i, j) parts[j]`.
    fn expect(&self, from: usize, parts: &[DMatrix<f64>]) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(parts[0].nrows(), parts[0].ncols());
        for (to, part) in parts.iter().enumerate() {
            let probability = self.transitions[(from, to)];
            if probability > 0.0 {
                sum.zip_apply(part, |entry, term| *entry += probability * term);
            }
        }
        sum
    }
}

impl Recursion for CoupledRecursion {
    fn step(&mut self) -> f64 {
        let mut state_cost = Vec::with_capacity(self.modes.len());
        let mut coupling = Vec::with_capacity(self.modes.len());
        let mut sequence_cost = Vec::with_capacity(self.modes.len());
        for (mode, cost_to_go) in self.modes.iter().zip(&self.cost_to_go) {
            let ka = cost_to_go * &mode.a;
            let kb = cost_to_go * &mode.b;
            state_cost.push(&mode.q + &mode.a_transposed * &ka);
            // Transposed: a column-major A^T K B is the row-major B^T K A that the core's solve takes.
            coupling.push(&mode.a_transposed * &kb);
            sequence_cost.push(&mode.r + &mode.b_transposed * &kb);
        }
        let (mut difference, mut size) = (0.0, 0.0);
        let mut next = Vec::with_capacity(self.modes.len());
        for from in 0..self.modes.len() {
            let quadratic = self.expect(from, &sequence_cost);
            let linear = self.expect(from, &coupling);
            let mut gain = -&linear;
            let rows = quadratic.nrows();
            let mut workspace = vec![0.0; synthesis::semidefinite_workspace_len(rows)];
            synthesis::SemidefiniteFactor::new(quadratic.as_slice(), rows, &mut workspace)
                .solve(gain.as_mut_slice(), linear.nrows());
            let value = self.expect(from, &state_cost) + &linear * gain.transpose();
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

    fn rate(&self) -> f64 {
        let closed_loop = |from: usize, to: usize| &self.modes[to].a + &self.modes[to].b * &self.gains[from];
        let size = self.modes[0].a.nrows();
        let matrices: Vec<Vec<(usize, f64, DMatrix<f64>)>> = (0..self.modes.len())
            .map(|from| {
                (0..self.modes.len())
                    .filter(|&to| self.transitions[(from, to)] > 0.0)
                    .map(|to| (to, self.transitions[(from, to)], closed_loop(from, to)))
                    .collect()
            })
            .collect();
        let start: Vec<f64> = (0..self.modes.len())
            .flat_map(|_| DMatrix::<f64>::identity(size, size).as_slice().to_vec())
            .collect();
        spectral_radius(&start, |from, to| {
            let costs: Vec<_> = from
                .chunks_exact(size * size)
                .map(|cost| DMatrix::from_column_slice(size, size, cost))
                .collect();
            for (row, out) in matrices.iter().zip(to.chunks_exact_mut(size * size)) {
                let mut sum = DMatrix::zeros(size, size);
                for (next, probability, closed) in row {
                    sum += closed.transpose() * (&costs[*next] * closed) * *probability;
                }
                out.copy_from_slice(((&sum + sum.transpose()) * 0.5).as_slice());
            }
        })
    }
}

pub(super) fn solve(problem: &LoopProblem) -> Solution {
    let mut recursion = CoupledRecursion::new(problem);
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
