//! What sending is worth before a packet in every p-th cycle, as the tables of [`slqg::event`]: THEORY 15.

use super::super::{LoopProblem, flat::Flat};
use super::Schedule;
use nalgebra::DMatrix;
use slqg::{
    DefaultInput,
    event::{InvalidTrigger, ScheduleTables, TableLengths, phase_len},
};

/// The tables of an event trigger over a schedule in `f64`; layout as in [`ScheduleTables`].
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduledTrigger {
    /// Cycles from one packet to the next, `p`.
    pub period: usize,
    /// `W_i` for `i = 0..n_v-1`, upper triangles.
    pub in_flight: Vec<f64>,
    /// `N_0`, upper triangle.
    pub decided: Vec<f64>,
    /// One block for each `s = 1..p`.
    pub phases: Vec<f64>,
}

impl ScheduledTrigger {
    /// As the core takes them.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn as_tables(&self) -> Result<ScheduleTables<'_, f64>, InvalidTrigger> {
        ScheduleTables::check(self.period, &self.in_flight, &self.decided, &self.phases)
    }

    /// Numbers in all tables together.
    pub fn floats(&self) -> usize {
        self.in_flight.len() + self.decided.len() + self.phases.len()
    }
}

/// A cost-to-go as the core lays it out, by its parts.
struct Parts<'v> {
    states: usize,
    /// `n_v nu`.
    rows: usize,
    inputs: usize,
    value: &'v [f64],
}

impl Parts<'_> {
    fn p(&self, row: usize, column: usize) -> f64 {
        self.value[row * self.states + column]
    }

    fn s(&self, row: usize, column: usize) -> f64 {
        self.value[self.states * self.states + row * self.rows + column]
    }

    /// `Y`; rows before columns or after them.
    fn y(&self, row: usize, column: usize) -> f64 {
        let first = self.states * (self.states + self.rows);
        self.value[first + lower(row, column)]
    }

    /// `N_t`, zero in rows and columns that belong to inputs before `t`, and beyond the last `t`.
    fn told(&self, t: usize, row: usize, column: usize) -> f64 {
        let first = t * self.inputs;
        if row.min(column) < first || first >= self.rows {
            return 0.0;
        }
        let triangle = |rows: usize| rows * (rows + 1) / 2;
        let before: usize = (0..t).map(|t| triangle(self.rows - t * self.inputs)).sum();
        let start = self.states * (self.states + self.rows) + triangle(self.rows) + before;
        self.value[start + lower(row - first, column - first)]
    }
}

/// Where an entry of a symmetric matrix stands in its lower triangle, by rows.
fn lower(row: usize, column: usize) -> usize {
    let (row, column) = (row.max(column), row.min(column));
    row * (row + 1) / 2 + column
}

impl Schedule {
    /// The tables of the trigger that takes later packets to follow this schedule. `problem` is the one that it was solved for, with
    /// process noise and error of the estimate, `nx x nx` each: of costs that do not depend on what is known these are all.
    pub fn trigger(
        &self,
        problem: &LoopProblem,
        process_noise: &DMatrix<f64>,
        error: &DMatrix<f64>,
    ) -> ScheduledTrigger {
        let (states, inputs) = problem.b.shape();
        let rows = problem.default_input.in_flight(problem.length) * inputs;
        // One cycle more without a packet than the schedule has.
        let never = Flat::with_survival(problem, vec![1.0; problem.length]);
        let mut longest = self.values[self.period - 1].clone();
        let mut workspace = vec![0.0; never.dimensions.workspace_len()];
        never.synthesis(&mut workspace).fixed_step_of(&mut longest);
        let values: Vec<&[f64]> = self.values.iter().chain([&longest]).map(Vec::as_slice).collect();
        let parts = |ahead: usize| Parts { states, rows, inputs, value: values[ahead] };
        let now = parts(0);

        let lengths = TableLengths::of(problem.length, problem.default_input, states, inputs);
        let mut in_flight = Vec::with_capacity(lengths.in_flight);
        for cycle in 0..rows / inputs {
            for row in cycle * inputs..rows {
                for column in row..rows {
                    let applied = if row < (cycle + 1) * inputs { now.y(row, column) } else { 0.0 };
                    in_flight.push(applied - now.told(cycle + 1, row, column));
                }
            }
        }
        let upper = (0..rows).flat_map(|row| (row..rows).map(move |column| (row, column)));
        let decided = upper.map(|(row, column)| now.told(0, row, column)).collect();

        let weighed = |ahead: usize, weight: &DMatrix<f64>| -> f64 {
            let of_cycle = parts(ahead);
            (0..states)
                .flat_map(|row| (0..states).map(move |column| (row, column)))
                .map(|(row, column)| of_cycle.p(row, column) * weight[(row, column)])
                .sum()
        };
        let noise: Vec<f64> = (0..self.period).map(|ahead| weighed(ahead, process_noise)).collect();
        let decision = self.error_weight(problem).component_mul(error).sum();
        let per_cycle = (noise.iter().sum::<f64>() + decision) / self.period as f64;
        let mut phases = Vec::with_capacity(self.period * phase_len(states, rows, inputs));
        for waited in 1..=self.period {
            let (later, before) = (parts(waited), parts(waited - 1));
            for row in 0..states {
                phases.extend((row..states).map(|column| later.p(row, column) - now.p(row, column)));
            }
            for row in 0..states {
                phases.extend((0..rows).map(|column| later.s(row, column) - now.s(row, column)));
            }
            for row in 0..inputs.min(rows) {
                phases.extend((0..rows).map(|column| {
                    // The one input that is held stays in flight: that is of the next cycle.
                    let stays = problem.default_input == DefaultInput::Hold && rows == inputs;
                    later.y(row, column) - if stays { before.y(row, column) } else { 0.0 }
                }));
            }
            let meanwhile: f64 = noise[..waited].iter().sum();
            let estimated = weighed(waited, error) - weighed(0, error);
            phases.push(meanwhile + estimated - waited as f64 * per_cycle);
            phases.push(self.period as f64 / waited as f64);
        }
        ScheduledTrigger { period: self.period, in_flight, decided, phases }
    }
}
