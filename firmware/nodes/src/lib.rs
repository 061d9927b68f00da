//! The closed loop that runs on the reference board and, unchanged, on the host.
#![no_std]
#![deny(unsafe_code)]

#[cfg(target_os = "none")]
pub mod board;

/// What a run of the loop leaves behind, to be compared between host and board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// CRC-32 over all applied inputs and the final state.
    pub digest: u32,
    /// Plant state after the last cycle.
    pub state: [f32; 4],
    /// The last input that the actuator applied.
    pub applied: f32,
}

/// Runs the loop from its fixed start to its fixed end.
pub fn run() -> Outcome {
    let mut state = [1.0f32, 0.0, 0.1, 0.0];
    let mut applied = 0.0;
    let mut digest = 0u32;
    for _ in 0..500 {
        applied = -0.3 * state[0] - 0.7 * state[1];
        state = [state[0] + 0.02 * state[1], state[1] + 0.02 * applied, 0.99 * state[2], state[2] / 3.0];
        for value in [applied, state[0], state[1], state[2], state[3]] {
            digest = digest.rotate_left(5) ^ value.to_bits();
        }
    }
    Outcome { digest, state, applied }
}
