//! Frames on a CAN bus, in either of two forms; `docs/wire-format.md` is the normative page.
//!
//! | form | carries | file |
//! |---|---|---|
//! | CAN FD | a frame of up to 64 bytes as it is, with zeros up to the next length that CAN FD has | `fd` |
//! | compact | what one classic frame of 8 bytes can say: values as counts of a step, and a check of where and when they are from | `compact`, `counts`, `check` |
//!
//! Values that are counted lie on a [`Grid`]. The controller rounds its inputs to it before it remembers them
//! ([`crate::controller::Design::grid`]), so that nothing is lost on the bus and both ends know the same inputs.
//!
//! Controller and actuator know of none of this: they take and give full frames. Drivers, filters and priorities are the
//! bus' business, errors are in `error`.

mod check;
mod compact;
mod counts;
mod error;
mod fd;
mod grid;

pub use check::{Check, FORM};
pub use compact::{
    Compact, Identifiers, MOST_CYCLES, MOST_VALUES, compact_acknowledgement_len, compact_len, nearest_tick,
};
pub use error::{InvalidCompact, PackError, UnpackError};
pub use fd::{FD_CAPACITY, fd_len, pad, unpad};
pub use grid::{Grid, LARGEST_COUNT, LARGEST_OF_FULL_FRAME, largest_count};
