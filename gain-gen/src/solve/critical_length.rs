//! The shortest sequences with which a loop is stable.

use super::{LoopProblem, Outcome, Solution, Start};
use crate::{design::LONGEST_SEQUENCE, stability::shortest_admissible_length};
use slqg::DefaultInput;

/// Lengths tried beyond the design's own when looking for one that stabilises.
const LENGTHS_BEYOND: usize = 16;

/// Shortest length whose recursion converges to stabilising gains, `N_crit`, for weights that see every mode that does not decay.
///
/// Looks from `N_min` to some lengths beyond the problem's own; `None` if none of them stabilises. `start` is
/// the problem made ready, and `own` the solution for its own length, which is not sought again.
pub(crate) fn critical_length(problem: &LoopProblem, start: &Start, own: &Solution) -> Option<usize> {
    let shortest = shortest_admissible_length(problem)?;
    if problem.default_input == DefaultInput::Zero && start.open_loop_modulus() < 1.0 {
        // Sending zeros stabilises a plant that decays.
        return Some(shortest);
    }
    let longest = (shortest.max(problem.length) + LENGTHS_BEYOND).min(LONGEST_SEQUENCE);
    // With zero default input a longer sequence can end in zeros: where it does not stabilise, no shorter one does.
    let is_monotone = problem.default_input == DefaultInput::Zero;
    let first = if is_monotone && own.outcome == Outcome::Unstable { problem.length + 1 } else { 1 };
    (shortest.max(first)..=longest).find(|&length| {
        if length == problem.length {
            return own.is_stabilising();
        }
        start.with_length(length).converges()
    })
}
