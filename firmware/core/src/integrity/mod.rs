//! Memory that changes by itself: what is kept twice, and what is compared with a checksum.
//!
//! A bit that flips in RAM or flash makes no noise. Two means find it here. [`Twice`] is for what decides in each cycle: both
//! copies are compared whenever it is read. `Round` is for tables and constants: a few numbers at a time are taken through a
//! checksum, and what comes of a whole round is compared with a value from before the program started, or from when the
//! numbers were written. What an end of the loop does about it is its own business: [`crate::controller`], [`crate::actuator`].
//!
//! A single bit is always found, as is every burst of up to 32 bits in a table, and any other damage but for 2^-32.
//! What changes and is used between two looks is not seen before the next one.

mod part;
mod round;
mod twice;

pub(crate) use crate::checksum::FIRST;
pub(crate) use part::{Part, checksum_of};
pub(crate) use round::Round;
pub use twice::Twice;

/// Where memory is that was lent, and how long it is: a reference that has changed by itself leads elsewhere. A single bit of
/// either makes another word.
pub(crate) fn place_of<E>(memory: &[E]) -> u32 {
    memory.as_ptr().addr() as u32 ^ memory.len() as u32
}
