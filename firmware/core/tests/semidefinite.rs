//! Systems of every rank are solved, and as accurately for tiny unknowns as for large ones.

use proptest::prelude::*;
use slqg::synthesis::{SemidefiniteFactor, semidefinite_workspace_len};

const LARGEST: usize = 8;

/// `root root^T` of `size` rows and the rank of `root`'s columns, row-major.
fn gram(root: &[f64], size: usize, rank: usize) -> Vec<f64> {
    let entry = |row: usize, column: usize| -> f64 {
        (0..rank).map(|k| root[row * LARGEST + k] * root[column * LARGEST + k]).sum()
    };
    (0..size * size).map(|index| entry(index / size, index % size)).collect()
}

fn times(matrix: &[f64], vector: &[f64]) -> Vec<f64> {
    matrix.chunks(vector.len()).map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum()).collect()
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// Solution and numerical rank.
fn solve(matrix: &[f64], rhs: &[f64], columns: usize) -> (Vec<f64>, usize) {
    let size = rhs.len() / columns;
    let mut workspace = vec![f64::NAN; semidefinite_workspace_len(size)];
    let factor = SemidefiniteFactor::new(matrix, size, &mut workspace);
    let mut solution = rhs.to_vec();
    factor.solve(&mut solution, columns);
    (solution, factor.rank())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_consistent_system_of_any_rank_is_solved(
        size in 1..=LARGEST,
        rank in 0..=LARGEST,
        root in proptest::collection::vec(-1.0..1.0, LARGEST * LARGEST),
        x in proptest::collection::vec(-1.0..1.0, LARGEST),
    ) {
        let rank = rank.min(size);
        let matrix = gram(&root, size, rank);
        let rhs = times(&matrix, &x[..size]);
        let (solution, found) = solve(&matrix, &rhs, 1);
        prop_assert!(found <= rank, "rank {found} instead of {rank}");
        let back = times(&matrix, &solution);
        let residual: Vec<f64> = back.iter().zip(&rhs).map(|(back, rhs)| back - rhs).collect();
        prop_assert!(norm(&residual) <= 1e-11 * norm(&matrix) * norm(&x[..size]), "{residual:?}");
        let unused = solution.iter().filter(|value| **value == 0.0).count();
        prop_assert!(unused >= size - found, "unknowns beyond the rank are zero");
    }

    #[test]
    fn accuracy_does_not_depend_on_the_scale_of_an_unknown(
        size in 1..=LARGEST,
        root in proptest::collection::vec(-1.0..1.0, LARGEST * LARGEST),
        x in proptest::collection::vec(prop_oneof![-1.0..-0.1, 0.1..1.0], LARGEST),
        exponents in proptest::collection::vec(-10i32..=10, LARGEST),
    ) {
        let mut matrix = gram(&root, size, size);
        (0..size).for_each(|row| matrix[row * size + row] += 1.0);
        let rhs = times(&matrix, &x[..size]);
        let scale: Vec<f64> = exponents.iter().map(|exponent| 10f64.powi(*exponent)).collect();
        let scaled = |index: usize| matrix[index] * scale[index / size] * scale[index % size];
        let scaled_matrix: Vec<f64> = (0..size * size).map(scaled).collect();
        let scaled_rhs: Vec<f64> = rhs.iter().zip(&scale).map(|(value, scale)| value * scale).collect();
        let (solution, rank) = solve(&scaled_matrix, &scaled_rhs, 1);
        prop_assert_eq!(rank, size);
        for ((found, expected), scale) in solution.iter().zip(&x).zip(&scale) {
            let error = (found * scale - expected).abs();
            prop_assert!(error < 1e-12, "{error:e} at scale {scale:e}");
        }
    }

    #[test]
    fn only_the_upper_triangle_counts_and_columns_are_solved_alike(
        size in 1..=LARGEST,
        root in proptest::collection::vec(-1.0..1.0, LARGEST * LARGEST),
        rhs in proptest::collection::vec(-1.0..1.0, LARGEST),
    ) {
        let mut matrix = gram(&root, size, size);
        let (expected, _) = solve(&matrix, &rhs[..size], 1);
        for row in 0..size {
            matrix[row * size..row * size + row].fill(f64::NAN);
        }
        let doubled: Vec<f64> = rhs[..size].iter().flat_map(|value| [*value, 2.0 * value]).collect();
        let (found, _) = solve(&matrix, &doubled, 2);
        for (pair, expected) in found.chunks(2).zip(&expected) {
            prop_assert_eq!(pair, [*expected, 2.0 * expected]);
        }
    }
}

#[test]
fn an_unknown_without_effect_is_exactly_zero() {
    let matrix = [4.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 4.0];
    let (solution, rank) = solve(&matrix, &[8.0, 5.0, 10.0], 1);
    assert_eq!(rank, 2);
    assert_eq!(solution[1], 0.0);
    assert!((solution[0] - 1.0).abs() < 1e-14 && (solution[2] - 2.0).abs() < 1e-14, "{solution:?}");
}

#[test]
fn a_zero_matrix_gives_zero() {
    assert_eq!(solve(&[0.0; 9], &[1.0, -1.0, f64::MAX], 1), (vec![0.0; 3], 0));
}
