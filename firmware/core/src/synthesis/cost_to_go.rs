//! How a cost-to-go `(P, S, Y, N_t)` lies in memory: its independent numbers, one after the other.

use super::{Dimensions, triangle};
use crate::Number;

/// Numbers in each part of a cost-to-go. `P` is `nx x nx` and `S` is `nx x n_v nu`, both by rows. `Y` and then
/// `N_0 .. N_{n_v - 1}` are triangles, by rows of the lower one, and `N_t` begins with in-flight input `t`: nothing in
/// flight is told before its time, so it is zero in rows and columns before.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    states: usize,
    inputs: usize,
    in_flight_rows: usize,
}

impl Layout {
    pub(crate) const fn of(dimensions: &Dimensions) -> Self {
        Self {
            states: dimensions.states,
            inputs: dimensions.inputs,
            in_flight_rows: dimensions.in_flight_rows(),
        }
    }

    /// Numbers in all.
    pub(crate) const fn len(&self) -> usize {
        let mut left = self.in_flight_rows;
        let mut told = 0;
        while left > 0 {
            told += triangle::len(left);
            left -= self.inputs;
        }
        self.before_fresh() + triangle::len(self.in_flight_rows) + told
    }

    const fn before_fresh(&self) -> usize {
        self.states * (self.states + self.in_flight_rows)
    }

    /// `P`, `S`, `Y` and all `N_t`.
    pub(crate) fn split<'v, T>(&self, value: &'v [T]) -> (&'v [T], &'v [T], &'v [T], &'v [T]) {
        let (p, rest) = value.split_at(self.states * self.states);
        let (s, rest) = rest.split_at(self.states * self.in_flight_rows);
        let (y, told) = rest.split_at(triangle::len(self.in_flight_rows));
        (p, s, y, told)
    }

    /// The same, to change.
    pub(crate) fn split_mut<'v, T>(
        &self,
        value: &'v mut [T],
    ) -> (&'v mut [T], &'v mut [T], &'v mut [T], &'v mut [T]) {
        let (p, rest) = value.split_at_mut(self.states * self.states);
        let (s, rest) = rest.split_at_mut(self.states * self.in_flight_rows);
        let (y, told) = rest.split_at_mut(triangle::len(self.in_flight_rows));
        (p, s, y, told)
    }

    /// The triangles `N_0, N_1, ..` of `told`, each with the in-flight row it begins with.
    pub(crate) fn each_told<'v, T>(
        &self,
        told: &'v [T],
    ) -> impl Iterator<Item = (usize, &'v [T])> + use<'v, T> {
        let (rows, inputs) = (self.in_flight_rows, self.inputs);
        let mut rest = told;
        (0..rows).step_by(inputs).map(move |first| {
            let (triangle, later) = rest.split_at(triangle::len(rows - first));
            rest = later;
            (first, triangle)
        })
    }

    /// Entry of `Y - sum_{t >= earliest} N_t`.
    pub(crate) fn untold<T: Number>(&self, value: &[T], earliest: usize, row: usize, column: usize) -> T {
        let (_, _, y, told) = self.split(value);
        let reach = row.min(column);
        let told = self.each_told(told).skip(earliest).take_while(|(first, _)| *first <= reach);
        told.fold(triangle::entry(y, row, column), |left, (first, matrix)| {
            left - triangle::entry(matrix, row - first, column - first)
        })
    }
}
