//! Sweeps: designs x controllers x lengths, each with the same runs, as rows of one file.
//!
//! Every case meets the same noise and the same packet fates in the run of the same number, so controllers are compared run
//! by run. The file is described in `docs/sweep.md`: rows in one order, whatever the threads, shards or interruptions.
//! Gains are computed before a sweep begins, by whoever asks for it; statistics are [`crate::monte_carlo`]'s.
//!
//! | file | what lives there |
//! |---|---|
//! | [`experiment`] | [`Experiment`]: what is simulated, as the head of a file tells it |
//! | [`layout`] | [`Shard`]: which rows are in a file, in which order |
//! | [`row`] | one run as a row |
//! | [`file`](mod@file) | reading a file, complete or not |
//! | [`part`] | the file that grows: continued, then moved into its place |
//! | [`simulate`](mod@simulate) | the rows that are missing, in parallel |
//! | [`merge`](mod@merge) | shards to the file that one sweep would have written |
//! | [`paired`] | differences to a baseline |
//! | [`summary`] | table and JSON |

pub mod experiment;
pub mod file;
pub mod layout;
mod lock;
pub mod merge;
pub mod paired;
pub mod part;
pub mod row;
pub mod simulate;
pub mod summary;

pub use experiment::{Case, Experiment, Studied};
pub use file::{FileError, Results};
pub use layout::Shard;
pub use merge::merge;
pub use part::Part;
pub use row::Entry;
pub use simulate::{Prepared, simulate};
pub use summary::SweepSummary;
