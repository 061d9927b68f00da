//! Self-tuning: the device learns the delays of its link, solves its own gains, and puts them in force.
//!
//! A design is made for the link that was measured before it. Where the link changes, the gains are no longer optimal, and
//! may be unstable. The in-flight recursion is small enough for the device to solve it again, and what it must know of the
//! link the acknowledgements tell. `docs/self-tuning.md` says how well that works, and where it ends.
//!
//! | file | what lives there |
//! |---|---|
//! | `delays` | from acknowledged ages to a delay distribution, and whether it differs from another |
//! | `solver` | gains for a delay distribution, in slices of one backward step |
//! | `certificate` | the proof that these gains stabilise the loop |
//! | `progress` | what a slice comes to |
//! | `tuner` | what is done when: the three together beside a controller, and the law in force |
//! | `parameters`, `event` | how it goes about it, and what it tells |
//!
//! What a law in force does is [`crate::controller`]'s business; the two sets of tables are [`crate::bank`]'s.

mod certificate;
mod delays;
mod event;
mod parameters;
mod progress;
mod solver;
mod tuner;

use crate::{played::DefaultInput, synthesis::Dimensions};

pub use delays::{Count, DelayEstimate, memory_len as delays_len, threshold};
pub use event::{Counts, Event, Kept};
pub use parameters::{InvalidTuner, Parameters};
pub use progress::{Progress, Solved, Unsolved};
pub use solver::Solver;
pub use tuner::{Tuner, tuner_len};

/// What gains were computed from, beside the plant: cost and link of the design. The generator writes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Basis<'a, T> {
    /// `Q`, `nx x nx` by rows, symmetric positive semidefinite.
    pub state_cost: &'a [T],
    /// `R`, `nu x nu` by rows, symmetric positive definite.
    pub input_cost: &'a [T],
    /// `P(delay > d)` of the link from controller to actuator for `d = 0..N-1`; its length is that of the sequences.
    pub survival: &'a [T],
    /// What the actuator applies when its buffer has run out.
    pub default_input: DefaultInput,
}

impl<T> Basis<'_, T> {
    /// Sizes of the problem for a plant of this many states and inputs.
    pub const fn dimensions(&self, states: usize, inputs: usize) -> Dimensions {
        Dimensions { states, inputs, length: self.survival.len(), default_input: self.default_input }
    }
}

/// Numbers that a [`Solver`] is lent as memory.
pub const fn workspace_len(dimensions: &Dimensions) -> usize {
    let (states, inputs) = (dimensions.states, dimensions.inputs);
    let weights = if states > inputs { states * states } else { inputs * inputs };
    dimensions.workspace_len()
        + dimensions.value_len()
        + certificate::scratch_len(dimensions)
        + dimensions.length
        + weights
}
