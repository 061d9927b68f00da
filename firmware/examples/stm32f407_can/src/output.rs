//! The input of the plant as a voltage: 12 bits of DAC over the range of the design's largest input and its negative.

use slqg::actuator::Applied;
use slqg_nodes::design::{INPUT_GRID, INPUTS, Scalar};
use stm32f4xx_hal::dac::{C1, DacOut, DacPin};

const _: () = assert!(INPUTS == 1, "the board's output is one voltage");

/// Half of the range: zero.
const REST: u16 = 2048;
/// From there to the largest input.
const SPAN: Scalar = 2047.0;

/// Turns the output on, at rest.
pub(crate) fn start(output: &mut C1) {
    output.set_value(REST);
    output.enable();
}

/// Puts an input out; the actuator has limited it to the design's range.
pub(crate) fn put(output: &mut C1, applied: &Applied<Scalar, INPUTS>) {
    let largest = INPUT_GRID.step[0] * Scalar::from(INPUT_GRID.largest_count);
    let code = Scalar::from(REST) + applied.input[0] / largest * SPAN;
    // The cast saturates at 0; what is not a number never leaves the actuator.
    output.set_value((code as u16).min(REST + SPAN as u16));
}

/// Puts zero out when the program has failed: whoever had the output will not use it any more.
pub(crate) fn rest() {
    C1.set_value(REST);
}
