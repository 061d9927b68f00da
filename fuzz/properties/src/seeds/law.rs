//! Blobs, and scripts of how they come to a bank, as [`crate::blob`] and [`crate::gains`] read them.

use super::Seed;
use crate::gains::DESIGN;
use slqg::blob::{self, Shape};
use slqg::gains::Tables;
use slqg::{DefaultInput, Scalar};

const LX: [f64; 4] = [-3.0, -2.5, -2.5, -2.25];
const M: [f64; 4] = [0.0, -0.5, 0.25, 0.125];

/// A law of two inputs a sequence for a plant of two states.
fn law<T: Scalar>(default_input: DefaultInput) -> Vec<u8> {
    let shape = Shape { length: 2, states: 2, inputs: 1, default_input };
    let all = |values: &[f64]| values.iter().map(|value| T::nearest(*value)).collect::<Vec<T>>();
    let (lx, m, chance) = (all(&LX), all(&M[..2 * default_input.in_flight(2)]), all(&[0.5]));
    let tables = Tables::check(&lx, &m, &chance).expect("finite");
    blob::encode(DESIGN, &shape, &tables, &mut [0; 128]).expect("there is room").to_vec()
}

pub(super) fn blobs() -> Vec<Seed> {
    let good = law::<f32>(DefaultInput::Zero);
    let mut cut = good.clone();
    cut.truncate(30);
    let mut infinite = good.clone();
    infinite[16..20].copy_from_slice(&f32::INFINITY.to_le_bytes());
    vec![
        ("zero_f32", good),
        ("hold_f64", law::<f64>(DefaultInput::Hold)),
        ("cut_off", cut),
        ("not_finite", infinite),
        // As a script: f64, hold, two inputs a sequence, three states, two inputs; then its id and numbers.
        ("script_of_three_states", vec![1, 1, 2, 3, 2, 1, 2, 3, 4, 110, 90, 105, 100, 95, 111, 130, 50, 104]),
        ("script_that_is_no_law", vec![0, 0, 2, 2, 1, 9, 9, 9, 9, 200, 201, 203, 100, 100, 100, 255, 0]),
    ]
}

pub(super) fn over_the_link() -> Vec<Seed> {
    // What happens, by its number in a script: a blob as bytes, one of the bank's own, the same in parts, a part, a number
    // written to the spare set, the switch, and the withdrawal.
    let [any, own, parts, part, write, switch, withdraw] = [0, 1, 2, 3, 4, 5, 6];
    // Seven numbers of a law, q(0) of 0.5 in tenths; a place and a change of a byte there; whether the checksum is made right.
    let numbers = [70, 75, 75, 78, 100, 95, 150];
    let sent = |kind: u8, changed: [u8; 3]| [&[kind][..], &numbers, &changed, &[150]].concat();
    let good = sent(own, [0, 0, 1]);
    let in_parts = |transfer: u8, most: u8| [sent(parts, [0, 0, 1]), vec![transfer, most]].concat();
    // Another plant, another length, a number that is none.
    let (plant, length) = (sent(own, [12, 1, 0]), sent(own, [7, 1, 0]));
    let not_finite = [&[own, 201][..], &numbers[1..], &[19, 255, 0], &[150]].concat();
    vec![
        ("a_law_and_refused_ones", [good.clone(), plant, length, not_finite].concat()),
        ("in_parts", [in_parts(1, 7), in_parts(2, 40)].concat()),
        (
            "parts_that_do_not_fit",
            [in_parts(1, 40), vec![part, 1, 5, 0, 9, 0, 2, 1, 2, part, 2, 0, 0, 200, 0, 1, 7]].concat(),
        ),
        (
            "written_and_switched",
            [good, vec![write, 6, 105, switch, 150, write, 0, 200, switch, 150, withdraw]].concat(),
        ),
        (
            "other_bytes",
            vec![any, 1, 8, 1, 2, 3, 4, 5, 6, 7, 8, 150, any, 0, 0, 0, 2, 2, 1, 1, 2, 3, 4, 100, 100],
        ),
    ]
}
