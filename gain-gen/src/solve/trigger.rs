//! What sending a packet is worth, as the tables of [`slqg::event`]: THEORY 7.

use super::{LoopProblem, Solution, flat::Flat};
use slqg::event::{InvalidTrigger, TableLengths, Tables};

/// The tables of an event trigger in `f64`; layout as in [`Tables`].
#[derive(Debug, Clone, PartialEq)]
pub struct TriggerTables {
    /// `nx x (n_v nu)`, by rows.
    pub state: Vec<f64>,
    /// `W_s` for `s = 0..n_v-1`, upper triangles.
    pub in_flight: Vec<f64>,
    /// `Rbar`, upper triangle.
    pub sequence: Vec<f64>,
}

impl TriggerTables {
    /// As the core takes them.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn as_tables(&self) -> Result<Tables<'_, f64>, InvalidTrigger> {
        Tables::check(&self.state, &self.in_flight, &self.sequence)
    }

    /// Numbers in all tables together.
    pub fn floats(&self) -> usize {
        self.state.len() + self.in_flight.len() + self.sequence.len()
    }
}

/// The tables for the problem's steady state; `None` unless the in-flight recursion found it.
pub fn trigger_tables(problem: &LoopProblem, solution: &Solution) -> Option<TriggerTables> {
    let value = solution.value.as_ref().filter(|_| solution.is_stabilising())?;
    let lengths =
        TableLengths::of(problem.length, problem.default_input, problem.a.nrows(), problem.b.ncols());
    let mut tables = TriggerTables {
        state: vec![0.0; lengths.state],
        in_flight: vec![0.0; lengths.in_flight],
        sequence: vec![0.0; lengths.sequence],
    };
    Flat::new(problem).at(value, |synthesis| {
        synthesis.fill_trigger(&mut tables.state, &mut tables.in_flight, &mut tables.sequence);
    });
    Some(tables)
}
