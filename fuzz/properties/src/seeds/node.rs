//! Scripts of both boards on one line, as [`crate::node`] reads them.

use super::Seed;

/// What happens, by its number in a script.
const CYCLE: u8 = 0;
const CLOCK: u8 = 3;
const PERIOD: u8 = 4;
const MEASURED: u8 = 5;
const CONTROL: u8 = 6;
const GAINS: u8 = 7;
const OTHER: u8 = 8;
const QUESTION: u8 = 9;

/// An entry of 1.0, and one that is no number.
const ONE: u8 = 110;
const NAN: u8 = 200;
/// One cycle before the tick that is spoken of.
const BEFORE: u8 = (-1_i8) as u8;

pub(super) fn seeds() -> Vec<Seed> {
    // Where the clock begins; then what comes.
    let script = |events: &[&[u8]]| [&[BEFORE], &events.concat()[..]].concat();
    let cycle = |output: u8| [MEASURED, output, 100, 0, CYCLE, 1];
    let jumps = |from: u8| [CLOCK, from, 1, CLOCK, from + 1, 1, CLOCK, from + 2, 1, CLOCK, from + 3, 1];
    let gains = |transfer: u8, wrong: [u8; 2]| [&[GAINS, ONE, transfer][..], &wrong].concat();
    vec![
        ("cycles", script(&[&cycle(101), &cycle(102), &[CYCLE, 0], &cycle(99), &[PERIOD], &cycle(100)])),
        (
            "a_clock_that_jumps",
            script(&[&cycle(101), &jumps(20), &[PERIOD, CLOCK, 90, 1], &cycle(100), &jumps(60)]),
        ),
        ("a_clock_that_stops", script(&[&cycle(101), &[CLOCK, 0, 1], &[PERIOD].repeat(60), &cycle(100)])),
        (
            "gains_and_refused_ones",
            script(&[&cycle(101), &gains(1, [255, 0]), &cycle(101), &gains(2, [40, 1]), &cycle(99)]),
        ),
        (
            "frames_of_others",
            script(&[
                &cycle(101),
                &[CONTROL, ONE, 1, CONTROL, NAN, 1, OTHER, 2, 0, 2, ONE, ONE],
                &cycle(101),
            ]),
        ),
        (
            "questions",
            script(&[
                &[QUESTION, 0],
                &cycle(101),
                &[QUESTION, 4, 1, 2, 3, 4, OTHER, 0, 1, 4, 4, 0, 5, 1, 0, 0, 0, 0],
            ]),
        ),
    ]
}
