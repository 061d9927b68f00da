//! Coordinates in which a problem is solved: states of equal cost, inputs of equal price.
//!
//! They come from the data, by [`crate::balance`], so that no verdict and no gain depends on the units of the design.
//! All of them are powers of two: going there and back is exact.

use super::{Law, LoopProblem, Solution, flat::scale_value};
use crate::balance::{power_of_two, state_units};
use nalgebra::{DMatrix, DVector};
use slqg::synthesis::Dimensions;

/// `x = D z`, `u = E w`, and costs in units of `R` in these inputs.
#[derive(Debug, Clone)]
pub(super) struct Coordinates {
    states: Vec<f64>,
    inputs: Vec<f64>,
}

impl Coordinates {
    /// Those in which the problem is given.
    pub(super) fn given(problem: &LoopProblem) -> Self {
        Self { states: vec![1.0; problem.a.nrows()], inputs: vec![1.0; problem.b.ncols()] }
    }

    /// Balanced over transitions, inputs and weights.
    pub(super) fn of(problem: &LoopProblem) -> Self {
        let inputs: Vec<f64> =
            problem.r.diagonal().iter().map(|&price| power_of_two(price.sqrt().recip())).collect();
        let inflow = DMatrix::from_fn(problem.b.nrows(), inputs.len(), |i, j| problem.b[(i, j)] * inputs[j]);
        let weights = problem.q.diagonal().map(|weight| weight.max(0.0).sqrt());
        let states = state_units(&problem.a, &inflow, &DMatrix::from_diagonal(&weights));
        Self { states, inputs }
    }

    /// The same with states and inputs measured by what they cost: `cost`, `nx x nx`, and `price`, `nu x nu`, have diagonals
    /// near 1 then. What costs nothing keeps its unit.
    pub(super) fn by_cost(&self, cost: &DMatrix<f64>, price: &DMatrix<f64>) -> Self {
        let measured = |units: &[f64], cost: &DMatrix<f64>| {
            let costs = cost.diagonal();
            let by_cost = units.iter().zip(costs.iter()).map(|(&unit, &cost)| {
                if cost > 0.0 && cost.is_finite() { unit * power_of_two(cost.sqrt().recip()) } else { unit }
            });
            by_cost.collect()
        };
        Self { states: measured(&self.states, cost), inputs: measured(&self.inputs, price) }
    }

    /// Units of states and inputs here, in those of `other`.
    pub(super) fn relative_to(&self, other: &Self) -> (Vec<f64>, Vec<f64>) {
        let ratios =
            |here: &[f64], there: &[f64]| here.iter().zip(there).map(|(here, there)| here / there).collect();
        (ratios(&self.states, &other.states), ratios(&self.inputs, &other.inputs))
    }

    /// Those that `relative`, given in these, stands for.
    pub(super) fn then(&self, relative: &Self) -> Self {
        let product =
            |here: &[f64], there: &[f64]| here.iter().zip(there).map(|(here, there)| here * there).collect();
        Self {
            states: product(&self.states, &relative.states),
            inputs: product(&self.inputs, &relative.inputs),
        }
    }

    /// A gain over `[x; rho]`, `(N nu) x n`, as one over these states and inputs.
    pub(super) fn express_gain(&self, gain: &DMatrix<f64>) -> DMatrix<f64> {
        let (d, e) = (&self.states, &self.inputs);
        let column = |j: usize| if j < d.len() { d[j] } else { e[(j - d.len()) % e.len()] };
        DMatrix::from_fn(gain.nrows(), gain.ncols(), |i, j| gain[(i, j)] * column(j) / e[i % e.len()])
    }

    /// A cost over the states of the problem, `nx x nx`, as one over these.
    pub(super) fn express_cost(&self, cost: &DMatrix<f64>) -> DMatrix<f64> {
        let d = &self.states;
        DMatrix::from_fn(d.len(), d.len(), |i, j| cost[(i, j)] * d[i] * d[j])
    }

    /// The problem in these coordinates.
    pub(super) fn express(&self, problem: &LoopProblem) -> LoopProblem {
        let (d, e) = (&self.states, &self.inputs);
        let scaled = |matrix: &DMatrix<f64>, rows: &dyn Fn(usize) -> f64, columns: &[f64]| {
            DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * rows(i) * columns[j])
        };
        LoopProblem {
            a: scaled(&problem.a, &|i| d[i].recip(), d),
            b: scaled(&problem.b, &|i| d[i].recip(), e),
            q: scaled(&problem.q, &|i| d[i], d),
            r: scaled(&problem.r, &|i| e[i], e),
            ..problem.clone()
        }
    }

    /// A law of the design's as one for these coordinates.
    pub(super) fn express_law(&self, law: &Law) -> Law {
        let (d, e) = (&self.states, &self.inputs);
        let input = |stacked: usize| e[stacked % e.len()];
        let mut law = law.clone();
        for (i, j) in grid(&law.lx) {
            law.lx[(i, j)] *= d[j] / input(i);
        }
        for (i, j) in grid(&law.m) {
            law.m[(i, j)] *= input(j) / input(i);
        }
        law
    }

    /// A law for these coordinates as one of the design's.
    pub(super) fn restore_law(&self, law: &Law) -> Law {
        let inverse = |units: &[f64]| units.iter().map(|unit| unit.recip()).collect();
        Self { states: inverse(&self.states), inputs: inverse(&self.inputs) }.express_law(law)
    }

    /// Outputs of the design's states, `ny x nx`, as those of these.
    pub(super) fn express_output(&self, output: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(output.nrows(), output.ncols(), |i, j| output[(i, j)] * self.states[j])
    }

    /// A filter's gain for these states, `nx x ny`, as one for the design's.
    pub(super) fn restore_filter_gain(&self, gain: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(gain.nrows(), gain.ncols(), |i, j| gain[(i, j)] * self.states[i])
    }

    /// A filter's gain of the design's as one for these states, `nx x ny`.
    pub(super) fn express_filter_gain(&self, gain: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(gain.nrows(), gain.ncols(), |i, j| gain[(i, j)] / self.states[i])
    }

    /// A covariance of these inputs, `nu x nu`, as one of the design's.
    pub(super) fn restore_input_covariance(&self, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        let e = &self.inputs;
        DMatrix::from_fn(e.len(), e.len(), |i, j| covariance[(i, j)] * e[i] * e[j])
    }

    /// A cost over these states, `nx x nx`, as one over the design's.
    pub(super) fn cost(&self, cost: &DMatrix<f64>) -> DMatrix<f64> {
        let d = &self.states;
        DMatrix::from_fn(d.len(), d.len(), |i, j| cost[(i, j)] / d[i] / d[j])
    }

    /// Makes of a gain over states and inputs in flight here, `(N nu) x n`, one over the design's.
    pub(super) fn restore_gain(&self, gain: &mut DMatrix<f64>) {
        let (d, e) = (&self.states, &self.inputs);
        for (i, j) in grid(gain) {
            gain[(i, j)] *= e[i % e.len()] / if j < d.len() { d[j] } else { e[(j - d.len()) % e.len()] };
        }
    }

    /// A covariance of the design's states, `nx x nx`, as one of these.
    pub(super) fn express_covariance(&self, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        let d = &self.states;
        DMatrix::from_fn(d.len(), d.len(), |i, j| covariance[(i, j)] / d[i] / d[j])
    }

    /// The design's state, and the inputs that were sent after it, in these coordinates.
    pub(super) fn express_augmented(&self, augmented: &mut DVector<f64>) {
        let (d, e) = (&self.states, &self.inputs);
        for (place, value) in augmented.iter_mut().enumerate() {
            *value /= if place < d.len() { d[place] } else { e[(place - d.len()) % e.len()] };
        }
    }

    /// A solution for these coordinates as one for the design's.
    pub(super) fn restore(&self, mut solution: Solution, dimensions: &Dimensions) -> Solution {
        let (d, e) = (&self.states, &self.inputs);
        let nu = e.len();
        let input = |stacked: usize| e[stacked % nu];
        for (i, j) in grid(&solution.law.lx) {
            solution.law.lx[(i, j)] *= input(i) / d[j];
        }
        for (i, j) in grid(&solution.law.m) {
            solution.law.m[(i, j)] *= input(i) / input(j);
        }
        solution.coupled_gains.iter_mut().flatten().for_each(|gain| self.restore_gain(gain));
        solution.cost_to_go = self.cost(&solution.cost_to_go);
        for value in solution.value.iter_mut().chain(&mut solution.slowest) {
            self.restore_value(value, dimensions);
        }
        solution
    }

    /// A cost-to-go `(P, S, Y, N_t)` of the design's, as the core lays it out, as one for these coordinates.
    pub(super) fn express_value(&self, value: &mut [f64], dimensions: &Dimensions) {
        self.change_value(value, dimensions, |unit| unit);
    }

    /// A cost-to-go for these coordinates, as the core lays it out, as one for the design's.
    pub(super) fn restore_value(&self, value: &mut [f64], dimensions: &Dimensions) {
        self.change_value(value, dimensions, f64::recip);
    }

    fn change_value(&self, value: &mut [f64], dimensions: &Dimensions, factor: impl Fn(f64) -> f64) {
        let states: Vec<f64> = self.states.iter().map(|&unit| factor(unit)).collect();
        let inputs: Vec<f64> = self.inputs.iter().map(|&unit| factor(unit)).collect();
        let in_flight = inputs.repeat(dimensions.in_flight());
        scale_value(value, self.inputs.len(), &states, &in_flight);
    }
}

/// Every place of a matrix.
fn grid(matrix: &DMatrix<f64>) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (rows, columns) = matrix.shape();
    (0..columns).flat_map(move |j| (0..rows).map(move |i| (i, j)))
}
