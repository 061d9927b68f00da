//! Scripts of an actuator, as [`crate::actuator`] reads them.

use super::Seed;

/// What happens, by its number in a script.
const STEP: u8 = 0;
const FRAME: u8 = 3;
const ANY_FRAME: u8 = 5;
const OFFER: u8 = 7;
const RESTART: u8 = 8;

/// An entry of 1.0, one of 0.5, and one that is no number.
const ONE: u8 = 110;
const HALF: u8 = 105;
const NAN: u8 = 200;
/// One cycle before the tick that is spoken of.
const BEFORE: u8 = (-1_i8) as u8;

pub(super) fn seeds() -> Vec<Seed> {
    // f32 and one input; then the settings; then where ticks begin.
    let plain = [0, 0, BEFORE];
    // Hold, limits -1..1 with a rate of 0.5, the safe input 0.5 after 2 cycles.
    let limited = [0, 0b1111, 90, ONE, HALF, HALF, 2, 0];
    // f64 and two inputs, limits without rates.
    let wide = [1, 0b10, 90, 90, ONE, ONE, 0];
    let script = |settings: &[u8], events: &[&[u8]]| [settings, &events.concat()].concat();
    let sequence = |age: u8, inputs: &[u8]| [&[FRAME, age, inputs.len() as u8], inputs].concat();
    let three = sequence(0, &[ONE, HALF, 100]);
    let late = sequence(BEFORE, &[ONE, HALF]);
    let bad = sequence(0, &[ONE, NAN]);
    let steps = [STEP; 6];
    vec![
        ("newer_sequences_over_the_wrap", script(&plain, &[&three, &steps[..2], &three, &steps[..2], &late])),
        ("runs_out_and_is_safe", script(&limited, &[&three, &steps, &late, &steps])),
        ("numbers_that_are_none", script(&plain, &[&bad, &steps[..1], &three, &bad, &steps])),
        ("two_inputs_within_limits", script(&wide, &[&[FRAME, 0, 2, 150, 50, 120, 99], &steps])),
        (
            "frames_of_other_kinds",
            script(&plain, &[&[ANY_FRAME, 1, 2, 4, 0, 6, 1, 1, 0, 0, 128, 63], &steps]),
        ),
        (
            "offered_and_begun_anew",
            script(&plain, &[&[OFFER, 0, 2, ONE, HALF], &steps[..1], &[RESTART, 5], &three, &steps]),
        ),
    ]
}
