//! The law is the matrix product it claims to be, for more than one input too.

mod lent;

use proptest::prelude::*;
use slqg::DefaultInput;
use slqg::gains::{Gains, Tables};
use slqg::nalgebra::{SMatrix, SVector};

const LENGTH: usize = 3;
const NX: usize = 2;
const NU: usize = 2;
const ROWS: usize = LENGTH * NU;

/// Compares `Lx x + M vbar` entry by entry for `V / NU` in-flight inputs.
fn law_is_the_product<const V: usize>(default_input: DefaultInput, numbers: &[f64]) {
    let (lx, rest) = numbers.split_at(ROWS * NX);
    let (m, rest) = rest.split_at(ROWS * V);
    let tables = Tables::check(lx, m, &[0.5; 3]).expect("finite, and probabilities");
    let gains =
        Gains::<f64, NX, NU>::check(LENGTH, default_input, tables).expect("tables of the right shape");
    let state = SVector::<f64, NX>::from_column_slice(&rest[..NX]);
    let expected = SVector::<f64, V>::from_column_slice(&rest[NX..NX + V]);
    let blocks: Vec<SVector<f64, NU>> =
        expected.as_slice().chunks(NU).map(SVector::from_column_slice).collect();
    let product = SMatrix::<f64, ROWS, NX>::from_row_slice(lx) * state
        + SMatrix::<f64, ROWS, V>::from_row_slice(m) * expected;
    let sequence = lent::sequence(&gains, &state, &blocks);
    assert_eq!(sequence.len(), LENGTH);
    for (row, found) in sequence.iter().flat_map(|input| input.iter()).enumerate() {
        assert!((found - product[row]).abs() < 1e-14, "row {row}: {found} instead of {}", product[row]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn each_input_is_a_row_of_both_tables(numbers in proptest::collection::vec(-1.0..1.0, ROWS * (NX + ROWS) + NX + ROWS)) {
        law_is_the_product::<{ ROWS - NU }>(DefaultInput::Zero, &numbers);
        law_is_the_product::<ROWS>(DefaultInput::Hold, &numbers);
    }
}
