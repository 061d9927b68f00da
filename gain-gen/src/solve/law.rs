//! The control law in both forms: `(Lx, M, r)` for the device, one gain per mode for comparison with the thesis.

use super::LoopProblem;
use crate::design::DeviceScalar;
use nalgebra::DMatrix;
use slqg::{DefaultInput, arrival, in_flight::add_newer};

/// `U = Lx xhat + M vbar`, THEORY 3.
#[derive(Debug, Clone, PartialEq)]
pub struct Law {
    /// Inputs per sequence, `N`.
    pub length: usize,
    /// What the actuator applies when its buffer has run out.
    pub default_input: DefaultInput,
    /// `Lx`, `(N nu) x nx`.
    pub lx: DMatrix<f64>,
    /// `M`, `(N nu) x (n_v nu)`.
    pub m: DMatrix<f64>,
    /// Conditional arrival probabilities `r(b, m)` in the core's table order.
    pub arrival: Vec<f64>,
}

impl Law {
    /// The law whose gains the core's recursion holds: `gains` is `[Lx M]`, row-major, `arrival` the problem's table.
    pub(super) fn from_gains(problem: &LoopProblem, gains: &[f64], arrival: Vec<f64>) -> Self {
        let (states, rows) = (problem.a.nrows(), problem.length * problem.b.ncols());
        let gains = DMatrix::from_row_slice(rows, gains.len() / rows, gains);
        Self {
            length: problem.length,
            default_input: problem.default_input,
            lx: gains.columns(0, states).into_owned(),
            m: gains.columns(states, gains.ncols() - states).into_owned(),
            arrival,
        }
    }

    /// The law with every number as the device's scalar holds it: what is emitted.
    pub fn rounded_to(&self, scalar: DeviceScalar) -> Self {
        let rounded = |value: f64| match scalar {
            DeviceScalar::F32 => f64::from(value as f32),
            DeviceScalar::F64 => value,
        };
        Self {
            length: self.length,
            default_input: self.default_input,
            lx: self.lx.map(rounded),
            m: self.m.map(rounded),
            arrival: self.arrival.iter().copied().map(rounded).collect(),
        }
    }

    /// `[Lx M]` by rows, as the core's recursion takes them.
    pub(super) fn by_rows(&self) -> Vec<f64> {
        let rows = self.lx.row_iter().zip(self.m.row_iter());
        rows.flat_map(|(lx, m)| lx.iter().chain(m.iter()).copied().collect::<Vec<_>>()).collect()
    }

    /// Inputs of the plant, `nu`.
    pub fn inputs(&self) -> usize {
        self.lx.nrows() / self.length
    }

    /// `r` as a matrix: rows `b = 1..N-1`, columns `m = 0..n_v-1`.
    pub fn arrival_matrix(&self) -> DMatrix<f64> {
        let in_flight = self.default_input.in_flight(self.length);
        DMatrix::from_fn(self.length - 1, in_flight, |row, m| {
            self.arrival[arrival::table_index(self.length, row + 1, m)]
        })
    }

    /// Numbers the law stores: `Lx`, `M` and the table of `r`.
    pub fn table_floats(&self) -> usize {
        self.lx.len() + self.m.len() + self.arrival.len()
    }

    /// Numbers the thesis' form stores: `N+1` gains of `N nu` rows over `[x; rho]`, hold: and the default input.
    pub fn coupled_table_floats(&self) -> usize {
        (self.length + 1)
            * self.lx.nrows()
            * (self.lx.ncols() + self.inputs() * sent_count(self.length, self.default_input))
    }

    /// `L(i)` for every age `i = 0..=N`, each `(N nu) x (nx + n_rho)`, thesis (3.31).
    pub fn mode_gains(&self) -> Vec<DMatrix<f64>> {
        (0..=self.length).map(|mode| self.mode_gain(mode)).collect()
    }

    /// The one for the age `mode`.
    pub(super) fn mode_gain(&self, mode: usize) -> DMatrix<f64> {
        let weights = mode_weights(self.length, self.default_input, &self.arrival, mode);
        let sent = &self.m * repeat_per_input(&weights, self.inputs());
        let mut gain = DMatrix::zeros(self.lx.nrows(), self.lx.ncols() + sent.ncols());
        gain.columns_mut(0, self.lx.ncols()).copy_from(&self.lx);
        gain.columns_mut(self.lx.ncols(), sent.ncols()).copy_from(&sent);
        gain
    }
}

/// Inputs in `rho`, thesis (3.26), and with hold the default input after them.
fn sent_count(length: usize, default_input: DefaultInput) -> usize {
    arrival::table_len(length) + usize::from(default_input == DefaultInput::Hold)
}

/// `vbar` as a linear map of what was sent: `n_v x n_rho` weights for the acknowledged age `mode` (`N`: empty).
///
/// The order of columns is that of thesis (3.26): ages `a = 1..N-1`, within each `m = 0..N-1-a`; with hold the input
/// applied last follows. The weights come from the core's own loop over packets.
pub fn mode_weights(length: usize, default_input: DefaultInput, table: &[f64], mode: usize) -> DMatrix<f64> {
    let columns = sent_count(length, default_input);
    let mut weights = DMatrix::zeros(default_input.in_flight(length), columns);
    let mut expected = vec![0.0; weights.nrows()];
    let played = mode + 1;
    for column in 0..columns {
        let mut sent = vec![0.0; columns];
        sent[column] = 1.0;
        let last = sent.get(arrival::table_len(length)).copied().unwrap_or(0.0);
        expected.fill(last);
        for age in (1..=played.min(length - 1)).rev() {
            // A packet's inputs stand where its arrival probabilities do in the core's table.
            let first = arrival::table_index(length, age, 0);
            let (inputs, arrivals) =
                (&sent[first..first + length - age], &table[first..first + length - age]);
            let share = |_, r: f64| if age == played { (1.0, 0.0) } else { (r, 1.0 - r) };
            add_newer(&mut expected, default_input, inputs, arrivals, share);
        }
        weights.column_mut(column).copy_from_slice(&expected);
    }
    weights
}

/// Each scalar weight as a multiple of the `inputs x inputs` identity.
fn repeat_per_input(weights: &DMatrix<f64>, inputs: usize) -> DMatrix<f64> {
    weights.kronecker(&DMatrix::identity(inputs, inputs))
}
