//! Scripts of a controller, alone and behind a guard, as [`crate::controller`] and [`crate::sealed`] read them.

use super::Seed;

/// What happens to a controller, by its number in a script.
const CYCLE: u8 = 0;
const TOLD: u8 = 3;
const MEASURED: u8 = 4;
const IN_TIME: u8 = 5;
const ACKNOWLEDGED: u8 = 6;
const DECIDED: u8 = 9;

/// One cycle before the tick that is spoken of.
const BEFORE: u8 = (-1_i8) as u8;
/// A number of 1.0, one of 10, and some that are none or too large to compute with.
const ONE: u8 = 110;
const TEN: u8 = 199;
const NAN: u8 = 200;
const LARGEST: u8 = 205;

pub(super) fn seeds() -> Vec<Seed> {
    // Scalar, choices, merging, how late measurements and acknowledgements may be; then where ticks begin.
    let plain = [0, 0, 0, 3, 4, BEFORE - 2];
    let limited = [1, 0b1_0111, 0, 2, 8, 0];
    let wary = [0, 0b1010, 1, 4, 4, BEFORE];
    let mixed = [1, 0b0001, 2, 6, 9, 0];
    let script = |form: &[u8], events: &[&[u8]]| [form, &events.concat()].concat();
    // In time, delivered, and acknowledged.
    let good = |output: u8| [IN_TIME, output, CYCLE, 0, TOLD, 1];
    let lost = [CYCLE, 1, TOLD, 2];
    let late = [MEASURED, BEFORE - 1, ONE];
    let told_late = [ACKNOWLEDGED, BEFORE - 1, 2, 0, 1, 2];
    let odd = [MEASURED, 0, NAN, MEASURED, BEFORE, LARGEST];
    let decided = [DECIDED, 0, ONE, DECIDED, 1, ONE, DECIDED, 0x83, ONE, DECIDED, 2, TEN];
    vec![
        (
            "a_loop",
            script(&plain, &[&good(16), &good(12), &lost, &good(8), &late, &good(250), &told_late, &good(0)]),
        ),
        (
            "limits_rates_and_grid",
            script(&limited, &[&good(100), &good(90), &odd, &lost, &lost, &good(40), &good(3)]),
        ),
        (
            "wary_and_lost",
            script(
                &wary,
                &[&good(1), &good(200), &good(1), &good(1), &good(1), &good(1), &lost.repeat(10), &good(1)],
            ),
        ),
        (
            "ages_kept_apart",
            script(&mixed, &[&good(16), &lost, &lost, &late, &told_late, &good(5), &lost, &odd, &good(2)]),
        ),
        ("decided_by_others", script(&plain, &[&good(16), &decided, &good(3), &decided[..9], &good(5)])),
        (
            "too_large_to_compute_with",
            script(&plain, &[&[MEASURED, 0, LARGEST, CYCLE, 0].repeat(6), &good(1)]),
        ),
    ]
}

/// What happens on the line of a sealed loop, by its number in a script.
const OF_ALL: u8 = 0;
const DELIVERED: u8 = 2;
const CHANGED: u8 = 4;
const FORGED: u8 = 5;
const BEGUN: u8 = 6;
const HELLO: u8 = 7;
const SHAKE: u8 = 8;
const BARE: u8 = 9;

pub(super) fn sealed() -> Vec<Seed> {
    let form = [0, 0, 3, 4];
    let script = |events: &[&[u8]]| [&form, &events.concat()[..]].concat();
    // Three frames a cycle, and each is delivered.
    let cycle = |output: u8| [OF_ALL, output, DELIVERED, 2, DELIVERED, 1, DELIVERED, 0];
    let again = [DELIVERED, 5, DELIVERED, 4, DELIVERED, 0];
    let changed = [CHANGED, 1, 12, 1, 0, 1, CHANGED, 1, 3, 4, 1, 1, CHANGED, 0, 0, 0, 1, 1];
    let forged = [&[FORGED, 1][..], &[7; 8], &[1, 2, 4, 0, 6, 1, 1, 0, 0, 128, 63]].concat();
    vec![
        ("a_session", script(&[&[SHAKE], &cycle(16), &cycle(12), &cycle(8)])),
        ("repeated_and_changed", script(&[&[SHAKE], &cycle(16), &again, &changed, &cycle(3), &again])),
        (
            "forged_and_bare",
            script(&[&[SHAKE], &cycle(16), &forged, &[BARE, 1, BEGUN, 1, 1, 5, 1, 2, 3, 4, 5], &cycle(1)]),
        ),
        (
            "hellos",
            script(&[
                &[HELLO, 1],
                &[9; 27],
                &[OF_ALL, 1, DELIVERED, 0, DELIVERED, 1, DELIVERED, 2, SHAKE],
                &cycle(2),
            ]),
        ),
        ("no_session_yet", script(&[&cycle(1), &cycle(2), &[OF_ALL, 0].repeat(20), &[SHAKE], &cycle(3)])),
    ]
}
