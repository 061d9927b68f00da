//! Sequence lengths: which ones are asked for, and which one to take where a design leaves it open.
//!
//! | file | what lives there |
//! |---|---|
//! | `list` | several lengths as the command line writes them: `1..=12`, `1,2,4,8` |
//! | `automatic` | the shortest length that is nearly as good as a very long one |

mod automatic;
mod list;

pub use crate::design::{LengthChoice, LongSequences};
pub use list::{Lengths, LengthsError};
