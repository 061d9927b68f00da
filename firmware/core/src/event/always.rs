//! What a packet is worth where every later one is sent. THEORY 7.

use super::{Candidate, InvalidTrigger};
use crate::{
    Scalar,
    checked::Finite,
    gains::{Gains, dot},
    in_flight::InFlight,
    played::DefaultInput,
};
use nalgebra::SVector;

/// What sending is worth, as tables; symmetric matrices by rows of their upper triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tables<'a, T> {
    /// `nx x (n_v nu)`, by rows: state times expected inputs in flight.
    pub state: Finite<'a, T>,
    /// `W_s` for `s = 0..n_v-1`, symmetric of `(n_v - s) nu` rows: the inputs in flight from cycle `k+s` on.
    pub in_flight: Finite<'a, T>,
    /// `Rbar`, symmetric of `N nu` rows: the sequence.
    pub sequence: Finite<'a, T>,
}

/// Numbers in each of the [`Tables`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableLengths {
    /// In [`Tables::state`].
    pub state: usize,
    /// In [`Tables::in_flight`].
    pub in_flight: usize,
    /// In [`Tables::sequence`].
    pub sequence: usize,
}

impl TableLengths {
    /// For sequences of `length` inputs to a plant of these dimensions. Saturates.
    pub const fn of(length: usize, default_input: DefaultInput, states: usize, inputs: usize) -> Self {
        let expected = default_input.in_flight(length);
        let (mut in_flight, mut left) = (0_usize, expected);
        // Dimensions that were read from somewhere may be absurd.
        while left > 0 && inputs > 0 && in_flight < usize::MAX {
            in_flight = in_flight.saturating_add(Self::packed(left.saturating_mul(inputs)));
            left -= 1;
        }
        Self {
            state: states.saturating_mul(expected.saturating_mul(inputs)),
            in_flight,
            sequence: Self::packed(length.saturating_mul(inputs)),
        }
    }

    /// Of the upper triangle of a square of `size` rows.
    pub const fn packed(size: usize) -> usize {
        size.saturating_mul(size.saturating_add(1)) / 2
    }
}

/// Where entry `(row, column)`, `row <= column`, of a symmetric matrix of `size` rows stands in its upper triangle.
pub const fn packed_index(size: usize, row: usize, column: usize) -> usize {
    row * size - row * (row + 1) / 2 + column
}

impl<T: Copy> Tables<'_, T> {
    /// Whether they have as many numbers as the dimensions ask for.
    pub(super) const fn fit(
        &self,
        length: usize,
        default_input: DefaultInput,
        states: usize,
        inputs: usize,
    ) -> bool {
        let lengths = TableLengths::of(length, default_input, states, inputs);
        self.state.len() == lengths.state
            && self.in_flight.len() == lengths.in_flight
            && self.sequence.len() == lengths.sequence
    }
}

impl<'a, T: Scalar> Tables<'a, T> {
    /// Tables of these numbers.
    ///
    /// # Errors
    /// If one is not finite. How many there must be, [`super::Trigger::check`] knows.
    pub fn check(state: &'a [T], in_flight: &'a [T], sequence: &'a [T]) -> Result<Self, InvalidTrigger> {
        let checked = |numbers| Finite::check(numbers).ok_or(InvalidTrigger::NotFinite);
        Ok(Self { state: checked(state)?, in_flight: checked(in_flight)?, sequence: checked(sequence)? })
    }
}

impl<T: Scalar> Tables<'_, T> {
    /// Expected cost, over all time to come, that sending `candidate` saves: [`super::Trigger::benefit`].
    pub(super) fn benefit<const NX: usize, const NU: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        in_flight: &InFlight<'_, T, NU>,
        candidate: &Candidate<'_, T, NX, NU>,
        room: &mut [SVector<T, NU>],
    ) -> T {
        let Candidate { posterior_mean, expected, inputs, displaced, played } = *candidate;
        let columns = expected.len() * NU;
        let mut twice = T::zero();
        for (row, state) in posterior_mean.iter().enumerate() {
            let weights = &self.state.numbers()[row * columns..(row + 1) * columns];
            twice += *state * dot(weights, expected.iter().flat_map(|input| input.iter()));
        }
        for (worth, input) in displaced.iter().zip(expected) {
            twice -= dot(worth.as_slice(), input.iter());
        }
        let mut benefit = (twice + twice) + quadratic(self.sequence.numbers(), inputs);
        let mut tables = self.in_flight.numbers();
        for told in 0..expected.len() {
            let (table, rest) = tables.split_at(TableLengths::packed((expected.len() - told) * NU));
            tables = rest;
            in_flight.for_each_newest(gains, &played, told, room, |probability, expected| {
                benefit += probability * quadratic(table, &expected[told..]);
            });
        }
        benefit
    }
}

/// `v^T W v` for the symmetric `W` whose upper triangle is `table`.
fn quadratic<T: Scalar, const NU: usize>(table: &[T], vector: &[SVector<T, NU>]) -> T {
    let entries = || vector.iter().flat_map(|input| input.iter());
    let mut rest = table;
    let mut sum = T::zero();
    for (row, value) in entries().enumerate() {
        let (weights, below) = rest.split_at(vector.len() * NU - row);
        rest = below;
        // Entries beside the diagonal count twice.
        let beside = dot(&weights[1..], entries().skip(row + 1));
        sum += *value * (weights[0] * *value + (beside + beside));
    }
    sum
}
