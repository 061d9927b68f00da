//! Scripts of a CAN bus, as [`crate::can`] reads them, and data of CAN FD frames.

use super::{Seed, frames};
use slqg::wire::can::{FD_CAPACITY, pad};
use slqg::{Age, Tick};

/// What happens, by its number in a script.
const ARRIVES: u8 = 0;
const ANY_FRAME: u8 = 2;
const MEASUREMENT: u8 = 3;
const CONTROL: u8 = 4;

/// Entries of 0.5, 1.0 and -1.0, and one that is no number.
const HALF: u8 = 105;
const ONE: u8 = 110;
const MINUS_ONE: u8 = 90;
const NAN: u8 = 200;

pub(super) fn seeds() -> Vec<Seed> {
    // One input and two outputs of f32: their steps, and their largest counts, little-endian; then where the receiver is.
    let small = [0, ONE, 100, 0, HALF, ONE, 255, 127, 3];
    // Three inputs and three outputs, whose counts have 13 bits.
    let full = [2, HALF, ONE, HALF, 255, 15, ONE, ONE, ONE, 255, 15, 0];
    let script = |form: &[u8], events: &[&[u8]]| [form, &events.concat()].concat();
    // Identifier, number of bytes, the lower half of the tick, counts or ages, and a check that is made right.
    let measurement = [ARRIVES, 0, 7, 3, 0, 1, 0, 255, 255, 0];
    let control = [ARRIVES, 1, 5, 2, 0, 99, 0, 0];
    let beyond = [ARRIVES, 1, 5, 2, 0, 101, 0, 0];
    let acknowledgement = [ARRIVES, 2, 5, 2, 0, 0, 255, 0];
    let unchecked = [ARRIVES, 0x41, 5, 2, 0, 99, 0, 7];
    let remote = [ARRIVES, 0x82, 5, 2, 0, 0, 255, 0];
    let in_flexible = |frame: &[u8]| pad(frame, &mut [0; FD_CAPACITY]).expect("it fits").to_vec();
    vec![
        ("taken_from_the_bus", script(&small, &[&measurement, &control, &acknowledgement])),
        ("not_taken", script(&small, &[&beyond, &unchecked, &remote])),
        ("put_on_the_bus", script(&small, &[&[MEASUREMENT, 0, 111, 130], &[CONTROL, 255, 1, MINUS_ONE]])),
        ("no_numbers", script(&small, &[&[MEASUREMENT, 0, NAN, NAN + 1], &[CONTROL, 0, 1, NAN]])),
        ("full_frames", script(&full, &[&[CONTROL, 0, 1, 0, 199, 101], &[MEASUREMENT, 1, 0, 1, 2]])),
        (
            "frames_of_other_kinds",
            script(&small, &[&[ANY_FRAME, 1, 3, 4, 0, 2, 0, 255], &[ANY_FRAME, 1, 9, 4, 0, 0]]),
        ),
        ("flexible_control", in_flexible(&frames::control::<f32, 1>(Tick(8), &[[1.0], [0.5]]))),
        (
            "flexible_acknowledgement",
            in_flexible(&frames::acknowledgement::<f32>(Tick(8), &[Age::Empty, Age::Steps(1)])),
        ),
    ]
}
