//! What a packet is worth where the later ones go out in every p-th cycle: THEORY 15.
//!
//! A packet now, then in every p-th cycle, is compared with none until `s` cycles from now, then in every p-th, for `s = 1..p`. All of
//! these costs are quadratics in the estimate and in the inputs in flight. They share the moments of what is in flight, and those
//! that wait share the tables of the one that sends now: `s` cycles later it sends, with less in flight.

use super::{Candidate, InvalidTrigger, TableLengths, packed_index};
use crate::{Scalar, checked::Finite, gains::Gains, gains::dot, in_flight::InFlight, played::DefaultInput};
use nalgebra::SVector;

/// Numbers in a phase beside its tables: `a_s`, and `p / s`.
const PHASE_NUMBERS: usize = 2;

/// What sending is worth before a packet in every p-th cycle, as tables; symmetric matrices by rows of their upper triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduleTables<'a, T> {
    /// Cycles from one packet to the next, `p`.
    pub period: usize,
    /// `W_i` for `i = 0..n_v-1`, symmetric of `(n_v - i) nu` rows: what the inputs in flight from cycle `k+i` on cost if a packet
    /// is sent in cycle `k`.
    pub in_flight: Finite<'a, T>,
    /// `N_0`, symmetric of `n_v nu` rows: what the packet takes off, as far as it makes up for what is expected.
    pub decided: Finite<'a, T>,
    /// For each `s = 1..p`, one after the other: `P_s - P_0`, symmetric of `nx` rows; `S_s - S_0`, `nx x (n_v nu)` by rows; what is
    /// applied in a cycle `s` cycles before a packet costs with all that follows it, `nu x (n_v nu)` by rows; the constant `a_s`; `p / s`.
    pub phases: Finite<'a, T>,
}

impl<'a, T: Scalar> ScheduleTables<'a, T> {
    /// Tables of these numbers.
    ///
    /// # Errors
    /// If one is not finite. How many there must be, [`super::Trigger::check_schedule`] knows.
    pub fn check(
        period: usize,
        in_flight: &'a [T],
        decided: &'a [T],
        phases: &'a [T],
    ) -> Result<Self, InvalidTrigger> {
        let checked = |numbers| Finite::check(numbers).ok_or(InvalidTrigger::NotFinite);
        Ok(Self {
            period,
            in_flight: checked(in_flight)?,
            decided: checked(decided)?,
            phases: checked(phases)?,
        })
    }
}

impl<T> ScheduleTables<'_, T> {
    /// Whether they are for these dimensions.
    pub(super) const fn fit(
        &self,
        length: usize,
        default_input: DefaultInput,
        states: usize,
        inputs: usize,
    ) -> bool {
        let rows = default_input.in_flight(length).saturating_mul(inputs);
        let lengths = TableLengths::of(length, default_input, states, inputs);
        self.period > 0
            && self.in_flight.len() == lengths.in_flight
            && self.decided.len() == TableLengths::packed(rows)
            && self.phases.len() == self.period.saturating_mul(phase_len(states, rows, inputs))
    }
}

/// Numbers of one phase of the [`ScheduleTables`], `rows` being `n_v nu`.
pub const fn phase_len(states: usize, rows: usize, inputs: usize) -> usize {
    TableLengths::packed(states)
        .saturating_add(states.saturating_mul(rows))
        .saturating_add(inputs.saturating_mul(rows))
        .saturating_add(PHASE_NUMBERS)
}

/// Numbers to work in for a decision.
pub(super) const fn numbers_len(rows: usize, period: usize) -> usize {
    TableLengths::packed(rows).saturating_add(period)
}

/// One of the phases, taken apart.
struct Phase<'a, T> {
    state: &'a [T],
    coupling: &'a [T],
    applied: &'a [T],
    constant: T,
    per_packet: T,
}

impl<T: Scalar> ScheduleTables<'_, T> {
    fn phases<const NX: usize, const NU: usize>(&self, rows: usize) -> impl Iterator<Item = Phase<'_, T>> {
        self.phases.numbers().chunks_exact(phase_len(NX, rows, NU)).filter_map(move |phase| {
            let (state, rest) = phase.split_at_checked(TableLengths::packed(NX))?;
            let (coupling, rest) = rest.split_at_checked(NX * rows)?;
            let (applied, rest) = rest.split_at_checked(NU * rows)?;
            let [constant, per_packet] = *rest else { return None };
            Some(Phase { state, coupling, applied, constant, per_packet })
        })
    }

    /// What sending now saves against waiting for `s = 1..p` cycles, without what packets cost: `p` numbers. `None` if there is less room than [`super::Trigger::numbers_len`] says, or inputs are not as many as they must be.
    pub fn savings<'n, const NX: usize, const NU: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        in_flight: &InFlight<'_, T, NU>,
        candidate: &Candidate<'_, T, NX, NU>,
        room: &mut [SVector<T, NU>],
        numbers: &'n mut [T],
    ) -> Option<&'n [T]> {
        let Candidate { posterior_mean, expected, ref played, .. } = *candidate;
        let (count, rows) = (expected.len(), expected.len() * NU);
        let decided = self.decided.numbers();
        if decided.len() != TableLengths::packed(rows) {
            return None;
        }
        let (moments, rest) = numbers.split_at_mut_checked(TableLengths::packed(rows))?;
        let savings = rest.get_mut(..self.period)?;
        // Numbers one after the other, which every phase goes through.
        let flat = moments.get_mut(..rows)?;
        for (place, input) in flat.chunks_exact_mut(NU).zip(expected) {
            place.copy_from_slice(input.as_slice());
        }
        for (saving, phase) in savings.iter_mut().zip(self.phases::<NX, NU>(rows)) {
            let mut twice = T::zero();
            for (state, weights) in posterior_mean.iter().zip(phase.coupling.chunks_exact(rows.max(1))) {
                twice += *state * dot(weights, flat.iter());
            }
            let of_state = form(phase.state, posterior_mean.as_slice());
            *saving = phase.constant + of_state + (twice + twice);
        }
        let mut now = -form(decided, flat);
        let holds = gains.default_input() == DefaultInput::Hold;
        for told in 0..count {
            let size = rows - told * NU;
            let moments = moments.get_mut(..TableLengths::packed(size))?;
            moments.fill(T::zero());
            in_flight.for_each_newest(gains, played, told, room, |probability, expected| {
                add_moments(moments, probability, expected.get(told..).unwrap_or_default());
            });
            double_beside_diagonal(moments, size);
            let moments = Moments { entries: moments, size, inputs: NU, holds };
            // From here on an actuator that holds applies the same for ever.
            let lasts = holds && told + 1 == count;
            now += self.add_later_sending(&moments, told, rows, lasts, savings);
            // What is told up to here decides the packet of the next cycle.
            let decided =
                if lasts { moments.triangle(decided, rows) } else { moments.later().triangle(decided, rows) };
            let deciding = if lasts { self.period } else { told + 1 };
            let deciding = savings.get_mut(told..deciding.min(self.period)).unwrap_or_default();
            deciding.iter_mut().for_each(|saving| *saving -= decided);
            let mut lasting = T::zero();
            let waiting = savings.get_mut(told..).unwrap_or_default();
            for (saving, phase) in waiting.iter_mut().zip(self.phases::<NX, NU>(rows)) {
                let applied = moments.rows(phase.applied, rows, NU);
                lasting = if lasts { lasting + applied } else { applied };
                *saving += lasting;
            }
        }
        savings.iter_mut().for_each(|saving| *saving -= now);
        Some(savings)
    }

    /// What is in flight up to cycle `k+told` costs once a packet is sent, which may be in any cycle up to then. Returns that of one
    /// sent now.
    fn add_later_sending(
        &self,
        moments: &Moments<'_, T>,
        told: usize,
        rows: usize,
        lasts: bool,
        savings: &mut [T],
    ) -> T {
        let (mut rest, mut table_rows, mut now) = (self.in_flight.numbers(), rows, T::zero());
        for of_table in 0..=told {
            let Some((table, later)) = rest.split_at_checked(TableLengths::packed(table_rows)) else { break };
            let waited = told - of_table;
            if lasts || waited <= savings.len() {
                let cost = moments.triangle(table, table_rows);
                if waited == 0 {
                    now += cost;
                }
                let first = waited.max(1) - 1;
                let last = if lasts { savings.len() } else { waited };
                savings
                    .get_mut(first..last)
                    .unwrap_or_default()
                    .iter_mut()
                    .for_each(|saving| *saving += cost);
            }
            rest = later;
            table_rows = table_rows.saturating_sub(moments.inputs);
        }
        now
    }

    /// The price of a packet at which sending now is as good as waiting for the best moment.
    pub(super) fn benefit<const NX: usize, const NU: usize>(
        &self,
        gains: &Gains<'_, T, NX, NU>,
        in_flight: &InFlight<'_, T, NU>,
        candidate: &Candidate<'_, T, NX, NU>,
        room: &mut [SVector<T, NU>],
        numbers: &mut [T],
    ) -> T {
        let rows = candidate.expected.len() * NU;
        let cannot_be_judged = T::nearest(f64::NAN);
        let Some(savings) = self.savings(gains, in_flight, candidate, room, numbers) else {
            return cannot_be_judged;
        };
        let mut least = T::nearest(f64::INFINITY);
        for (saving, phase) in savings.iter().zip(self.phases::<NX, NU>(rows)) {
            let price = *saving * phase.per_packet;
            if price < least || !price.is_finite() {
                least = price;
            }
        }
        least
    }
}

/// `E[h h^T]` of the inputs from some cycle on, by rows of the upper triangle; what stands beside the diagonal is doubled.
struct Moments<'m, T> {
    entries: &'m [T],
    size: usize,
    inputs: usize,
    /// Whether the last input goes on, or zeros follow it.
    holds: bool,
}

impl<'m, T: Scalar> Moments<'m, T> {
    /// Those of the inputs from one cycle later on.
    fn later(&self) -> Moments<'m, T> {
        let size = self.size.saturating_sub(self.inputs);
        let first = self.entries.len().saturating_sub(TableLengths::packed(size));
        Moments { entries: self.entries.get(first..).unwrap_or_default(), size, ..*self }
    }

    /// `E[h' W h]` for a triangle of `table_rows`, at least as many as there are moments.
    fn triangle(&self, table: &[T], table_rows: usize) -> T {
        let (mut rest, mut sum) = (table, T::zero());
        for row in 0..if self.holds { table_rows } else { self.size } {
            let Some((weights, below)) = rest.split_at_checked(table_rows - row) else { break };
            rest = below;
            sum += self.row(row, weights);
        }
        sum
    }

    /// The same for the first `count` rows alone, each of `columns` in a table.
    fn rows(&self, table: &[T], columns: usize, count: usize) -> T {
        let mut sum = T::zero();
        for (row, weights) in table.chunks_exact(columns.max(1)).take(count).enumerate() {
            sum += self.row(row, weights.get(row..).unwrap_or_default());
        }
        sum
    }

    /// The same for one row, of which `weights` are from the diagonal on.
    fn row(&self, row: usize, weights: &[T]) -> T {
        let own = self.size.saturating_sub(row);
        let first = if own > 0 { packed_index(self.size, row, row) } else { 0 };
        let entries = self.entries.get(first..first + own).unwrap_or_default();
        let mut sum = dot(weights, entries.iter());
        if self.holds {
            for (column, weight) in weights.iter().enumerate().skip(own) {
                sum += *weight * self.held(row, row + column);
            }
        }
        sum
    }

    /// The moment of a row and a column behind the end, where the last input goes on.
    fn held(&self, row: usize, column: usize) -> T {
        let input = |at: usize| if at < self.size { at } else { self.size - self.inputs + at % self.inputs };
        let (one, other) = (input(row), input(column));
        let place = packed_index(self.size, one.min(other), one.max(other));
        let moment = self.entries.get(place).copied().unwrap_or_else(T::zero);
        // Two different inputs that are the same now.
        if one == other && row != column { moment + moment } else { moment }
    }
}

/// Adds `probability h h^T`.
fn add_moments<T: Scalar, const NU: usize>(moments: &mut [T], probability: T, expected: &[SVector<T, NU>]) {
    let mut rest = moments;
    for (place, input) in expected.iter().enumerate() {
        let later = expected.get(place + 1..).unwrap_or_default();
        for entry in 0..NU {
            let weighed = probability * input[entry];
            let Some((own, below)) = rest.split_at_mut_checked(NU - entry + later.len() * NU) else { return };
            let (beside, behind) = own.split_at_mut(NU - entry);
            for (moment, other) in beside.iter_mut().zip(input.iter().skip(entry)) {
                *moment += weighed * *other;
            }
            for (moments, other) in behind.chunks_exact_mut(NU).zip(later) {
                moments.iter_mut().zip(other).for_each(|(moment, other)| *moment += weighed * *other);
            }
            rest = below;
        }
    }
}

/// `v^T W v` for the symmetric `W` whose upper triangle is `table`.
fn form<T: Scalar>(table: &[T], vector: &[T]) -> T {
    let (mut rest, mut sum) = (table, T::zero());
    for (row, value) in vector.iter().enumerate() {
        let Some((weights, below)) = rest.split_at_checked(vector.len() - row) else { break };
        let Some((own, beside)) = weights.split_first() else { break };
        let others = dot(beside, vector.get(row + 1..).unwrap_or_default().iter());
        sum += *value * (*own * *value + (others + others));
        rest = below;
    }
    sum
}

fn double_beside_diagonal<T: Scalar>(moments: &mut [T], size: usize) {
    let mut rest = moments;
    for row in 0..size {
        let Some((own, below)) = rest.split_at_mut_checked(size - row) else { return };
        own.iter_mut().skip(1).for_each(|moment| *moment += *moment);
        rest = below;
    }
}
