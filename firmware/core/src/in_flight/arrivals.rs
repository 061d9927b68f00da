//! What may yet arrive, packet by packet: the recursion that expected inputs come from.
//!
//! Which packets there are, and what is known of them, the module above says. Inputs may be vectors, or plain numbers where the
//! weights themselves are wanted.

use crate::{Scalar, played::DefaultInput};
use core::ops::{Add, Mul};

/// Takes one more packet into account, newer than all before: `expected` is what to expect in the cycles `k, k+1, ..` if
/// nothing newer arrives. THEORY 3.
///
/// `inputs` are the packet's for the same cycles until they run out, and `arrivals` are `r(a, 0), r(a, 1), ..` for as many.
/// `share` makes of `m` and `r(a, m)` what the packet's input counts in cycle `k+m`, and what counts that was expected
/// before: `r` and `1 - r` where it is under way for certain.
#[inline(always)]
pub fn add_newer<T, B>(
    expected: &mut [B],
    default_input: DefaultInput,
    inputs: &[B],
    arrivals: &[T],
    share: impl Fn(usize, T) -> (T, T),
) where
    T: Scalar,
    B: Copy + Add<Output = B> + Mul<T, Output = B>,
{
    // The packet may end before what is expected does.
    for m in 0..expected.len() {
        let (Some(input), Some(arrives)) = (inputs.get(m), arrivals.get(m)) else { break };
        let (arrived, missing) = share(m, *arrives);
        expected[m] = *input * arrived + expected[m] * missing;
    }
    if default_input == DefaultInput::Zero {
        // They are zero as they are: older packets have run out before.
        return;
    }
    if let (Some(held), Some(arrives)) = (inputs.last(), arrivals.last()) {
        // Later than for its last input it does not arrive.
        for m in 0..expected.len() {
            if m >= inputs.len() {
                let (arrived, missing) = share(m, *arrives);
                expected[m] = *held * arrived + expected[m] * missing;
            }
        }
    }
}
