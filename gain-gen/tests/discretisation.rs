//! Discretisation against arithmetic of 1500 bits, entry by entry, in any units.
//!
//! `data/discretised.toml` has continuous plants from practice and the `f64` nearest to each entry of their A and B: the
//! exponential of `[a b; 0 0] T` by its series, with a, b and T taken as the exact values of their `f64`.

use gain_gen::discretise::zero_order_hold;
use nalgebra::DMatrix;
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{RngCore, SeedableRng},
};

#[derive(serde::Deserialize)]
struct References {
    plant: Vec<Reference>,
}

#[derive(serde::Deserialize)]
struct Reference {
    name: String,
    sample_time: f64,
    a: Vec<Vec<f64>>,
    b: Vec<Vec<f64>>,
    discrete_a: Vec<Vec<f64>>,
    discrete_b: Vec<Vec<f64>>,
}

type Pair = (DMatrix<f64>, DMatrix<f64>);

impl Reference {
    fn all() -> Vec<Self> {
        toml::from_str::<References>(include_str!("data/discretised.toml")).expect("references").plant
    }

    fn continuous(&self) -> Pair {
        (matrix(&self.a), matrix(&self.b))
    }

    fn discrete(&self) -> Pair {
        (matrix(&self.discrete_a), matrix(&self.discrete_b))
    }
}

fn matrix(rows: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

/// Largest relative error of an entry, with the error of an entry that should be 0 as it is.
fn error(found: &DMatrix<f64>, expected: &DMatrix<f64>) -> f64 {
    let of = |(&found, &expected): (&f64, &f64)| {
        let difference = (found - expected).abs();
        if expected == 0.0 { difference } else { difference / expected.abs() }
    };
    found.iter().zip(expected.iter()).map(of).fold(0.0, f64::max)
}

/// The plant with each state and input in a unit that is `states[i]` or `inputs[j]` times smaller.
fn in_other_units((a, b): &Pair, states: &[f64], inputs: &[f64]) -> Pair {
    (
        DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * states[i] / states[j]),
        DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| b[(i, j)] * states[i] / inputs[j]),
    )
}

/// Powers of `base` between `-range` and `range`.
fn units(count: usize, base: f64, range: i32, random: &mut ChaCha8Rng) -> Vec<f64> {
    let exponent = |random: &mut ChaCha8Rng| (random.next_u32() % (2 * range as u32 + 1)) as i32 - range;
    (0..count).map(|_| base.powi(exponent(random))).collect()
}

#[test]
fn every_entry_is_right_to_its_last_digit() {
    for reference in Reference::all() {
        let (a, b) = reference.continuous();
        let (found_a, found_b) = zero_order_hold(&a, &b, reference.sample_time).expect("in range");
        let (expected_a, expected_b) = reference.discrete();
        let (of_a, of_b) = (error(&found_a, &expected_a), error(&found_b, &expected_b));
        assert!(of_a < 2.3e-16 && of_b < 2.3e-16, "{}: {of_a:e}, {of_b:e}", reference.name);
    }
}

#[test]
fn other_units_change_no_digit_if_they_are_powers_of_two() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for reference in Reference::all() {
        let plant = reference.continuous();
        let expected = zero_order_hold(&plant.0, &plant.1, reference.sample_time).expect("in range");
        for _ in 0..4 {
            let states = units(plant.0.nrows(), 2.0, 30, &mut random);
            let inputs = units(plant.1.ncols(), 2.0, 30, &mut random);
            let (a, b) = in_other_units(&plant, &states, &inputs);
            let found = zero_order_hold(&a, &b, reference.sample_time).expect("in range");
            let expected = in_other_units(&expected, &states, &inputs);
            assert!(error(&found.0, &expected.0) < 2.3e-16, "A of {}, {states:?}", reference.name);
            assert!(error(&found.1, &expected.1) < 2.3e-16, "B of {}, {states:?}", reference.name);
        }
    }
}

/// Powers of ten round the plant itself, in the last digit of each entry, which these two amplify.
const SENSITIVE: [&str; 2] = ["stiff_exponential_1s", "spin_resonance_7_states"];

#[test]
fn powers_of_ten_from_1e_9_to_1e9_on_any_state_and_input_only_scale_the_entries() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    for reference in Reference::all().iter().filter(|plant| !SENSITIVE.contains(&&*plant.name)) {
        let plant = reference.continuous();
        let expected = reference.discrete();
        for _ in 0..4 {
            let states = units(plant.0.nrows(), 10.0, 9, &mut random);
            let inputs = units(plant.1.ncols(), 10.0, 9, &mut random);
            let (a, b) = in_other_units(&plant, &states, &inputs);
            let found = zero_order_hold(&a, &b, reference.sample_time).expect("in range");
            let expected = in_other_units(&expected, &states, &inputs);
            let (of_a, of_b) = (error(&found.0, &expected.0), error(&found.1, &expected.1));
            assert!(of_a < 1e-13 && of_b < 1e-13, "{}: {of_a:e}, {of_b:e}", reference.name);
        }
    }
}

#[test]
fn two_steps_of_a_chain_of_integrators_are_one_of_double_length_in_every_entry() {
    // All entries are positive, so that products in f64 keep their relative accuracy.
    for reference in Reference::all().iter().filter(|plant| plant.name.contains("integrators")) {
        let (a, b) = reference.continuous();
        let (a1, b1) = zero_order_hold(&a, &b, reference.sample_time).expect("in range");
        let (a2, b2) = zero_order_hold(&a, &b, 2.0 * reference.sample_time).expect("in range");
        assert!(error(&(&a1 * &a1), &a2) < 1e-14, "{}", reference.name);
        assert!(error(&(&a1 * &b1 + &b1), &b2) < 1e-14, "{}", reference.name);
    }
}
