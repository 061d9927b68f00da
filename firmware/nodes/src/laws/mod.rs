//! Where a controller's gains come from beside its design: [`Sent`] over the link, or `Tuned` on the device (feature `tuning`).

mod sent;
#[cfg(feature = "tuning")]
mod tuned;

use crate::design::{self, INPUTS, STATES, Scalar};
use slqg::{
    controller::Law,
    wire::{self, GainsAnswer, GainsPart},
};

pub use sent::{BANK_MEMORY, LARGEST_PART, Sent};
#[cfg(feature = "tuning")]
pub use tuned::Tuned;

/// What keeps a controller's law up to date.
pub trait Laws {
    /// The law in force; `None` while that of the design is.
    fn law(&self) -> Option<Law<'_, Scalar, STATES, INPUTS>>;
    /// Takes a part of a blob, and says what to answer.
    fn take(&mut self, part: &GainsPart<'_>) -> GainsAnswer;
    /// Takes what acknowledgements have told, before each cycle.
    fn observe(&mut self, _controller: &design::Controller<'_>) {}
    /// Looks whether the law in force is as it was put in force, up to `numbers` more of it: `false` if not.
    fn check_memory(&mut self, numbers: usize) -> bool;
    /// Does what there is time for once the frame is sent; tells of what has come of it.
    fn work(&mut self) -> Option<wire::Tuned> {
        None
    }
}
