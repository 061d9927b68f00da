//! What a packet does, whenever it arrives, as linear maps over one cycle. THEORY 14.
//!
//! Let `v_m` be the input that the actuator will apply `m` cycles on if nothing sent from now on arrives by then. Which it is depends
//! on the arrival of packets that are under way, and of nothing else. So the packet of this cycle, with the inputs `U` and the
//! delay `d`, makes of it
//!
//! ```text
//! u = U_0 if d = 0, else v_0 ;     v+_m = (E U)_m if d <= m+1, else (Z v)_m
//! ```
//!
//! with a delay that is independent of everything before: no age of the buffer is needed.

use crate::solve::LoopProblem;
use nalgebra::DMatrix;
use slqg::DefaultInput;

/// The maps, blocks of `nu x nu`.
pub(super) struct Sent {
    /// `J`, `nu x N nu`: the input for the cycle itself.
    pub(super) first: DMatrix<f64>,
    /// `V0`, `nu x n_v nu`.
    pub(super) next: DMatrix<f64>,
    /// `E`, `n_v nu x N nu`: what a packet leaves for later.
    pub(super) left: DMatrix<f64>,
    /// `Z`, `n_v nu x n_v nu`: a cycle later.
    pub(super) shift: DMatrix<f64>,
    /// `q(0)`.
    pub(super) at_once: f64,
    /// `c_m = P(d <= m+1)` for each of the `n_v nu` rows.
    pub(super) arrived: Vec<f64>,
}

impl Sent {
    pub(super) fn of(problem: &LoopProblem) -> Self {
        let (length, inputs) = (problem.length, problem.b.ncols());
        let holds = problem.default_input == DefaultInput::Hold;
        let in_flight = problem.default_input.in_flight(length);
        let at = |rows, columns, is_one: &dyn Fn(usize, usize) -> bool| {
            DMatrix::from_fn(rows * inputs, columns * inputs, |i, j| {
                let is_same = i % inputs == j % inputs;
                if is_same && is_one(i / inputs, j / inputs) { 1.0 } else { 0.0 }
            })
        };
        let survival = problem.survival();
        Self {
            first: at(1, length, &|_, j| j == 0),
            next: at(1, in_flight, &|_, j| j == 0),
            left: at(in_flight, length, &|i, j| j == (i + 1).min(length - 1)),
            shift: at(in_flight, in_flight, &|i, j| j == i + 1 || (holds && i + 1 == in_flight && j == i)),
            at_once: 1.0 - survival[0],
            // A packet that is later than its last input is of no use.
            arrived: (0..in_flight * inputs)
                .map(|row| 1.0 - survival[(row / inputs + 1).min(length - 1)])
                .collect(),
        }
    }

    /// `C`, `n_v nu` square: the probabilities on the diagonal.
    pub(super) fn weights(&self) -> DMatrix<f64> {
        DMatrix::from_diagonal(&self.arrived.clone().into())
    }
}
