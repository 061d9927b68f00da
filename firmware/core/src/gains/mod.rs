//! `Gains`: the optimal control law as constant data, checked at compile time.
//!
//! The law itself is here, `tables` says what it is made of, and `checked` makes it. Where gains come from is
//! [`crate::synthesis`]; what they multiply is [`crate::estimator`]'s state and [`crate::in_flight`]'s expected inputs.

mod checked;
mod tables;

use crate::{DefaultInput, Scalar, arrival};
use heapless::Vec;
use nalgebra::SVector;

pub use tables::{InvalidGains, Tables};

/// Steady-state gains `U = Lx xhat + M vbar`, THEORY 3; equal to thesis (3.30) for every mode.
///
/// All tables are row-major. Build them with [`Gains::new`], in a `const` where they are known at compile
/// time: tables of a wrong length then do not compile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains<'a, T, const NX: usize, const NU: usize> {
    length: usize,
    default_input: DefaultInput,
    lx: &'a [T],
    m: &'a [T],
    arrival: &'a [T],
}

impl<'a, T: Scalar, const NX: usize, const NU: usize> Gains<'a, T, NX, NU> {
    /// Inputs per sequence, `N`.
    pub const fn length(&self) -> usize {
        self.length
    }

    /// What the actuator does when its buffer has run out; the gains are optimal for this choice only.
    pub const fn default_input(&self) -> DefaultInput {
        self.default_input
    }

    /// Expected in-flight inputs the law takes, `n_v`: `N-1` with zero default, `N` with hold.
    pub const fn in_flight(&self) -> usize {
        self.default_input.in_flight(self.length)
    }

    /// `r(b, m)`: probability that a packet of age `b >= 1` arrives by cycle `k+m`, given that it had not by `k-1`.
    pub fn arrival(&self, b: usize, m: usize) -> T {
        self.arrival[arrival::table_index(self.length, b, m)]
    }

    /// `r(b, 0), r(b, 1), .. r(b, N-1-b)` for `b = 1, 2, .. N-1`, row after row: each until the packet's last input is due.
    pub const fn arrival_table(&self) -> &'a [T] {
        self.arrival
    }

    /// The control sequence `U = Lx xhat + M vbar`, one entry per cycle from the current one on.
    ///
    /// `posterior_mean`: estimate of the state given all that has arrived. `expected`: `vbar`, `n_v` inputs.
    /// Holds the first `N` of `Gains::length` inputs if the capacity is smaller, which
    /// [`crate::controller::Controller::new`] rules out.
    pub fn sequence<const N: usize>(
        &self,
        posterior_mean: &SVector<T, NX>,
        expected: &[SVector<T, NU>],
    ) -> Vec<SVector<T, NU>, N> {
        // A controller's capacity is its gains' length, as a rule. Lengths that are constants then halve the work: no loop
        // counts, and `expected` stays in registers.
        let count = expected.len();
        match self.default_input {
            DefaultInput::Zero if self.length == N && count + 1 == N => {
                self.times(N, N - 1, posterior_mean, expected)
            }
            DefaultInput::Hold if self.length == N && count == N => {
                self.times(N, N, posterior_mean, expected)
            }
            _ => self.times(self.length.min(N), self.in_flight(), posterior_mean, expected),
        }
    }

    /// `length` inputs of the law for `in_flight` expected ones.
    #[inline(always)]
    fn times<const N: usize>(
        &self,
        length: usize,
        in_flight: usize,
        posterior_mean: &SVector<T, NX>,
        expected: &[SVector<T, NU>],
    ) -> Vec<SVector<T, NU>, N> {
        let (rows, columns) = (length * NU, in_flight * NU);
        // Checked tables are as long.
        let tables = self.lx.get(..rows * NX).zip(self.m.get(..rows * columns));
        let Some((of_state, of_sent)) = tables else { return Vec::new() };
        let mut of_state = of_state.chunks_exact(NX);
        // Without anything in flight there is no table to cut into rows.
        let mut of_sent = of_sent.chunks_exact(columns.max(1));
        let mut sequence = [SVector::zeros(); N];
        for input in sequence.iter_mut().take(length) {
            *input = SVector::from_fn(|_, _| {
                let from_state =
                    of_state.next().map_or_else(T::zero, |row| add_dot(T::zero(), row, posterior_mean));
                let from_sent = of_sent.next().map_or_else(T::zero, |row| {
                    row.chunks_exact(NU)
                        .zip(expected)
                        .fold(T::zero(), |sum, (gains, input)| add_dot(sum, gains, input))
                });
                from_state + from_sent
            });
        }
        let mut sequence = Vec::from(sequence);
        sequence.truncate(length);
        sequence
    }
}

/// Sum of products in index order: the order is part of the promise that host and target agree to the bit.
pub(crate) fn dot<'v, T: Scalar>(row: &[T], vector: impl Iterator<Item = &'v T>) -> T {
    row.iter().zip(vector).fold(T::zero(), |sum, (gain, value)| sum + *gain * *value)
}

/// `sum + row . vector`, in index order likewise.
pub(crate) fn add_dot<T: Scalar, const D: usize>(sum: T, row: &[T], vector: &SVector<T, D>) -> T {
    row.iter().zip(vector.iter()).fold(sum, |sum, (gain, value)| sum + *gain * *value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Gains<'static, f64, 2, 1> = Gains::<f64, 2, 1>::new(
        2,
        DefaultInput::Zero,
        Tables { lx: &[1.0, 2.0, 3.0, 4.0], m: &[10.0, 20.0], arrival: &[0.5] },
    );

    #[test]
    fn the_law_is_state_gain_plus_in_flight_gain() {
        let sequence: Vec<_, 4> = LAW.sequence(&SVector::from([1.0, -1.0]), &[SVector::from([0.5])]);
        assert_eq!(sequence.as_slice(), &[SVector::from([4.0]), SVector::from([9.0])]);
    }
}
