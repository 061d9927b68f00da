//! The thesis' model of the loop: plant, packets in flight and actuator, one set of matrices for each age of the buffer.
//!
//! Thesis (3.26)-(3.29), for hold (3.42) with its misprints mended. What is done with them is in `coupled` and `closed_loop`.

use super::LoopProblem;
use nalgebra::DMatrix;
use slqg::{DefaultInput, arrival};

/// The loop in one mode: thesis (3.29), for hold (3.42) with its misprints mended.
pub(crate) struct Mode {
    /// `A-hat`, `n x n`.
    pub(crate) a: DMatrix<f64>,
    /// `B-hat`, `n x N nu`.
    pub(crate) b: DMatrix<f64>,
    /// `Q-hat`, `n x n`.
    pub(super) q: DMatrix<f64>,
    /// `R-hat`, `N nu` square.
    pub(super) r: DMatrix<f64>,
    /// States and inputs of the plant: the first rows of `a`, the first columns of `b`.
    pub(super) plant: (usize, usize),
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
pub(super) struct Backward {
    /// `A^T K A`, `n x n`.
    pub(super) state: DMatrix<f64>,
    /// `A^T K B`, `n x N nu`. Column-major it is the row-major `B^T K A` that the core's solve takes.
    pub(super) coupling: DMatrix<f64>,
    /// `B^T K B`, `N nu` square.
    pub(super) sequence: DMatrix<f64>,
}

impl Mode {
    /// One step back with the symmetric cost `k`, `n x n`.
    pub(super) fn backward(&self, k: &DMatrix<f64>) -> Backward {
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
            Mode { a_entries: entries(&a), b_entries: entries(&b), a, b, q, r, plant: (nx, nu) }
        })
        .collect()
}
