//! `U = Lx xhat + M vbar`, several rows at a time: a number that all of them take is loaded once for so many.
//!
//! Every row is a sum of its own, in index order, whatever stands beside it.

use crate::Scalar;
use nalgebra::SVector;

/// Rows that are computed together. More would not fit the registers of a Cortex-M4F beside the other numbers.
const TOGETHER: usize = 4;

/// Rows of `Lx` and of `M` that are still to be computed, with what they multiply.
pub(super) struct Rows<'a, T: Scalar, const NX: usize, const NU: usize> {
    pub(super) of_state: &'a [[T; NX]],
    /// `in_flight` entries for each row.
    pub(super) of_sent: &'a [[T; NU]],
    pub(super) in_flight: usize,
    pub(super) posterior_mean: &'a SVector<T, NX>,
    pub(super) expected: &'a [SVector<T, NU>],
}

impl<T: Scalar, const NX: usize, const NU: usize> Rows<'_, T, NX, NU> {
    /// Writes the inputs of a sequence, one row for each entry.
    pub(super) fn fill(mut self, sequence: &mut [SVector<T, NU>]) {
        let rows = self.of_state.get(..sequence.len() * NU).unwrap_or_default();
        let (together, rest) = rows.as_chunks::<TOGETHER>();
        let mut row = 0;
        let mut put = |entries: &[T]| {
            for entry in entries {
                if let Some(input) = sequence.get_mut(row / NU) {
                    input[row % NU] = *entry;
                }
                row += 1;
            }
        };
        for gains in together {
            let Some(entries) = self.next(gains) else { return };
            put(&entries);
        }
        for gains in rest {
            let Some(entries) = self.next(core::array::from_ref(gains)) else { return };
            put(&entries);
        }
    }

    /// The next entries, for these rows of `Lx`.
    #[inline(always)]
    fn next<const ROWS: usize>(&mut self, of_state: &[[T; NX]; ROWS]) -> Option<[T; ROWS]> {
        let mut of_sent = [&[][..]; ROWS];
        for row in &mut of_sent {
            (*row, self.of_sent) = self.of_sent.split_at_checked(self.in_flight)?;
        }
        let mut from_state = [T::zero(); ROWS];
        for state in 0..NX {
            let value = self.posterior_mean[state];
            for row in 0..ROWS {
                from_state[row] += of_state[row][state] * value;
            }
        }
        let mut from_sent = [T::zero(); ROWS];
        // All rows are that long: none of their entries is looked up with a check.
        for place in 0..self.in_flight {
            let Some(input) = self.expected.get(place) else { break };
            for entry in 0..NU {
                let value = input[entry];
                for row in 0..ROWS {
                    from_sent[row] += of_sent[row][place][entry] * value;
                }
            }
        }
        Some(core::array::from_fn(|row| from_state[row] + from_sent[row]))
    }
}
