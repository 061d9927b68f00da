//! The Markov chain of the actuator's age: thesis Lemma 3.1, with its third case corrected.

use nalgebra::DMatrix;
use slqg::arrival;

use crate::design::DelayDistribution;

/// Transition probabilities `p(i, j)` of the age `theta`, `(N+1) x (N+1)`, `N` standing for an empty buffer.
///
/// `p(i, i+1) = P(delay > i)`, `p(i, j) = q(j)` for `j <= i < N`, and in row `N`: `q(j)` for `j < N`, the rest for `N`.
/// (The thesis prints the third case as `j < i <= N`.)
pub fn age_transitions(link: &DelayDistribution, length: usize) -> DMatrix<f64> {
    let mut survival = vec![0.0; length];
    arrival::survival(link.probabilities(), link.loss(), &mut survival);
    DMatrix::from_fn(length + 1, length + 1, |from, to| {
        if to < length && to <= from {
            link.probability(to)
        } else if to == from + 1 || (to == length && from == length) {
            // Row N keeps what row N-1 passes on: the newest useful packet is N-1 cycles old.
            survival[from.min(length - 1)]
        } else {
            0.0
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_a_distribution() {
        let link = DelayDistribution::new(vec![0.1, 0.3, 0.0, 0.2]).expect("a distribution");
        for length in 1..7 {
            let chain = age_transitions(&link, length);
            for row in chain.row_iter() {
                assert!((row.sum() - 1.0).abs() < 1e-14, "{row}");
                assert!(row.iter().all(|&p| p >= 0.0));
            }
        }
    }

    #[test]
    fn the_uniform_link_of_the_thesis_gives_its_chain() {
        let link = DelayDistribution::new(vec![0.25; 4]).expect("a distribution");
        let expected = DMatrix::from_row_slice(
            4,
            4,
            &[0.25, 0.75, 0.0, 0.0, 0.25, 0.25, 0.5, 0.0, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25],
        );
        assert_eq!(age_transitions(&link, 3), expected);
    }
}
