//! `Gains`: the optimal control law as constant data, checked at compile time.
//!
//! The law itself is here, `rows` computes it, `tables` says what it is made of, and `checked` makes it. Where gains come from is
//! [`crate::synthesis`]; what they multiply is [`crate::estimator`]'s state and [`crate::in_flight`]'s expected inputs.

mod checked;
mod rows;
mod tables;

use crate::{Scalar, arrival, played::DefaultInput};
use nalgebra::SVector;

use rows::Rows;
pub use tables::{InvalidGains, Tables};

/// Steady-state gains `U = Lx xhat + M vbar`, THEORY 3; equal to thesis (3.30) for every mode.
///
/// All tables are row-major. Build them with [`Gains::new`], in a `const` where they are known at compile
/// time: tables of a wrong length then do not compile.
///
/// ```
/// use slqg::DefaultInput;
/// use slqg::checked::{Finite, Probabilities};
/// use slqg::gains::{Gains, Tables};
/// use slqg::nalgebra::{Vector1, Vector2};
///
/// const LAW: Gains<'static, f32, 2, 1> = Gains::<f32, 2, 1>::new(
///     2,
///     DefaultInput::Zero,
///     Tables {
///         lx: Finite::<f32>::new(&[-3.0, -2.5, -2.5, -2.25]),
///         m: Finite::<f32>::new(&[0.0, -0.5]),
///         arrival: Probabilities::<f32>::new(&[0.5]),
///     },
/// );
/// let mut sequence = [Vector1::zeros(); 2];
/// LAW.fill_sequence(&Vector2::new(1.0, 0.0), &[Vector1::new(2.0)], &mut sequence);
/// assert_eq!(sequence, [Vector1::new(-3.0), Vector1::new(-3.5)]);
/// ```
///
/// Tables of another length do not compile:
///
/// ```compile_fail
/// # use slqg::DefaultInput;
/// # use slqg::checked::{Finite, Probabilities};
/// # use slqg::gains::{Gains, Tables};
/// const LAW: Gains<'static, f32, 2, 1> = Gains::<f32, 2, 1>::new(
///     2,
///     DefaultInput::Zero,
///     Tables {
///         lx: Finite::<f32>::new(&[-3.0, -2.5, -2.5]),
///         m: Finite::<f32>::new(&[0.0, -0.5]),
///         arrival: Probabilities::<f32>::new(&[0.5]),
///     },
/// );
/// # assert_eq!(LAW.length(), 2);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains<'a, T, const NX: usize, const NU: usize> {
    length: usize,
    default_input: DefaultInput,
    tables: Tables<'a, T>,
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
        self.arrival_table()[arrival::table_index(self.length, b, m)]
    }

    /// `r(b, 0), r(b, 1), .. r(b, N-1-b)` for `b = 1, 2, .. N-1`, row after row: each until the packet's last input is due.
    pub const fn arrival_table(&self) -> &'a [T] {
        self.tables.arrival.numbers()
    }

    /// What it is made of.
    pub(crate) const fn tables(&self) -> &Tables<'a, T> {
        &self.tables
    }

    /// Writes the control sequence `U = Lx xhat + M vbar` to `sequence`, one entry per cycle from the current one on.
    ///
    /// `posterior_mean`: estimate of the state given all that has arrived. `expected`: `vbar`, `n_v` inputs.
    /// Of a sequence longer than [`Gains::length`] the rest stays as it is.
    pub fn fill_sequence(
        &self,
        posterior_mean: &SVector<T, NX>,
        expected: &[SVector<T, NU>],
        sequence: &mut [SVector<T, NU>],
    ) {
        let rows = Rows {
            of_state: self.tables.lx.numbers().as_chunks().0,
            of_sent: self.tables.m.numbers().as_chunks().0,
            in_flight: self.in_flight(),
            posterior_mean,
            expected,
        };
        let count = sequence.len().min(self.length);
        rows.fill(sequence.split_at_mut(count).0);
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
    use crate::checked::{Finite, Probabilities};

    const LAW: Gains<'static, f64, 2, 1> = Gains::<f64, 2, 1>::new(
        2,
        DefaultInput::Zero,
        Tables {
            lx: Finite::<f64>::new(&[1.0, 2.0, 3.0, 4.0]),
            m: Finite::<f64>::new(&[10.0, 20.0]),
            arrival: Probabilities::<f64>::new(&[0.5]),
        },
    );

    #[test]
    fn the_law_is_state_gain_plus_in_flight_gain() {
        let mut sequence = [SVector::zeros(); 2];
        LAW.fill_sequence(&SVector::from([1.0, -1.0]), &[SVector::from([0.5])], &mut sequence);
        assert_eq!(sequence, [SVector::from([4.0]), SVector::from([9.0])]);
    }
}
