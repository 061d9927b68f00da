//! What a delay distribution says about packets that are under way.
//!
//! Everything the controller and the recursion need of a link is its survival function, truncated at the
//! sequence length: a packet that arrives when its last input is past is useless, however late it comes.

use crate::Number;

/// Survival function `g(d) = P(delay > d)` of a link for `d = 0..N-1`, written to `survival` (length `N`).
///
/// `delays[d]` is the probability of a delay of `d` cycles and `loss` that of never arriving. Tails are
/// summed from their small end, so that each value is accurate relative to itself: later inputs of a long
/// sequence are applied with tiny probabilities, and their gains live on these. They are divided by the whole,
/// so that `1 - g(d)` is zero, not a rounding error, where no packet can have arrived. THEORY 1: `g(d) = 1 - Q(d)`.
pub fn survival<T: Number>(delays: &[T], loss: T, survival: &mut [T]) {
    let length = survival.len();
    let mut tail = loss;
    for probability in delays.iter().skip(length).rev() {
        tail += *probability;
    }
    for d in (0..length).rev() {
        survival[d] = tail;
        tail += delays.get(d).copied().unwrap_or_else(T::zero);
    }
    // `tail` is now the whole: 1, up to rounding.
    for value in survival.iter_mut() {
        *value /= tail;
    }
}

/// `g(d)` under truncation: constant from `d = N-1` on.
pub(crate) fn truncated<T: Number>(survival: &[T], d: usize) -> T {
    survival.get(d).or(survival.last()).copied().unwrap_or_else(T::one)
}

/// `r(b, m)`: probability that a packet of age `b >= 1` arrives by cycle `k+m`, given that it had not by `k-1`.
///
/// `survival` as from [`survival`]. Zero where the condition itself has probability zero. THEORY 3.
pub fn conditional_arrival<T: Number>(survival: &[T], b: usize, m: usize) -> T {
    let before = truncated(survival, b - 1);
    if before > T::zero() { (before - truncated(survival, b + m)) / before } else { T::zero() }
}

/// How many conditional arrival probabilities a sequence length needs: `N (N-1) / 2`.
#[inline]
pub const fn table_len(length: usize) -> usize {
    length * length.saturating_sub(1) / 2
}

/// Where `r(b, m)` stands in the table: rows `b = 1..N-1` of `N-b` entries each, the last one repeating for larger `m`.
#[inline]
pub const fn table_index(length: usize, b: usize, m: usize) -> usize {
    let column = if m < length - 1 - b { m } else { length - 1 - b };
    (b - 1) * (2 * length - b) / 2 + column
}

/// Writes the table of [`conditional_arrival`] probabilities for sequences of `survival.len()` inputs.
///
/// `table` must have [`table_len`] entries.
pub fn fill_table<T: Number>(survival: &[T], table: &mut [T]) {
    let length = survival.len();
    for b in 1..length {
        for m in 0..length - b {
            table[table_index(length, b, m)] = conditional_arrival(survival, b, m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn survival_counts_losses_and_everything_later_than_the_last_input() {
        let mut g = [0.0; 3];
        survival(&[0.25, 0.25, 0.25, 0.125], 0.125, &mut g);
        assert_eq!(g, [0.75, 0.5, 0.25]);
    }

    #[test]
    fn the_table_is_dense_and_in_row_order() {
        let length = 5;
        let mut expected = 0;
        for b in 1..length {
            for m in 0..length - b {
                assert_eq!(table_index(length, b, m), expected);
                expected += 1;
            }
            assert_eq!(table_index(length, b, length), expected - 1, "beyond the row its last entry repeats");
        }
        assert_eq!(expected, table_len(length));
    }

    #[test]
    fn arrival_given_survival_is_a_ratio_of_tails() {
        let mut g = [0.0; 3];
        survival(&[0.25, 0.25, 0.25, 0.25], 0.0, &mut g);
        assert_eq!(conditional_arrival(&g, 1, 0), (0.75 - 0.5) / 0.75);
        assert_eq!(conditional_arrival(&g, 1, 1), (0.75 - 0.25) / 0.75);
        assert_eq!(
            conditional_arrival(&g, 1, 7),
            conditional_arrival(&g, 1, 1),
            "later than the last input is never"
        );
    }

    #[test]
    fn a_packet_that_must_have_arrived_does_not_arrive_again() {
        let mut g = [0.0; 3];
        survival(&[0.5, 0.5], 0.0, &mut g);
        assert_eq!(conditional_arrival(&g, 2, 0), 0.0);
    }
}
