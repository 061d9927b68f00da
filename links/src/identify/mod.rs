//! From logs of a link to the `delays` of a design file: `host-sim identify`.
//!
//! | room | what lives there |
//! |---|---|
//! | [`trace`] | packets of one log in the order sent, and what was odd about them |
//! | `time` | seconds in a file to whole nanoseconds |
//! | `table`, `candump`, `capture` | the three formats |
//! | [`logs`] | which of them a file is in |
//! | `pairing` | sightings at the sender and at the receiver become packets |
//! | [`sample`] | delays in cycles, losses, counts |
//! | [`chance`] | normal and chi-square probabilities, Wilson intervals |
//! | [`independence`] | whether what becomes of a packet depends on the one before |
//! | [`drift`] | whether the link stayed the same |
//! | [`figures`] | all of it in one struct, with the warnings |
//! | [`fragment`] | the figures as lines of a design file |
//!
//! Formats and formulas: docs/traces.md.

mod candump;
mod capture;
pub mod chance;
pub mod drift;
pub mod figures;
pub mod fragment;
pub mod independence;
pub mod logs;
mod pairing;
pub mod sample;
mod table;
mod time;
pub mod trace;
mod warnings;
