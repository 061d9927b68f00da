//! From logs of a link to the `delays` of a design file: `host-sim identify`.
//!
//! | room | what lives there |
//! |---|---|
//! | [`logs`] | logs of one link, whatever their format, to traces |
//! | `source` | the bytes of a log, unpacked, and its lines |
//! | `time` | seconds in a file to whole nanoseconds |
//! | [`formats`] | which formats there are, and a reader for each |
//! | `collector`, `early`, `choice` | which frames are packets of the link, at which end, and by which number they are told apart |
//! | [`counters`] | counters in payloads, and how they go on when they wrap |
//! | `bytes`, `column`, `packets` | tens of millions of packets in a few bytes each |
//! | `join`, `pairing` | sightings at the sender and at the receiver become packets |
//! | [`clocks`] | the clocks of two ends: offset, drift, steps |
//! | [`trace`], [`about`] | packets of one log in the order sent, what was odd about them, and where they come from |
//! | [`sample`] | delays in cycles, losses, counts |
//! | [`chance`] | normal and chi-square probabilities, Wilson intervals |
//! | [`independence`] | whether what becomes of a packet depends on the one before |
//! | [`channel`] | the channel that losses in bursts come from |
//! | [`drift`] | whether the link stayed the same |
//! | [`figures`] | all of it in one struct, with the warnings |
//! | [`fragment`] | the figures as lines of a design file |
//!
//! Formats and formulas: docs/traces.md.

pub mod about;
mod bytes;
pub mod chance;
pub mod channel;
mod choice;
pub mod clocks;
mod collector;
mod column;
pub mod counters;
pub mod drift;
mod early;
pub mod figures;
pub mod formats;
pub mod fragment;
pub mod independence;
mod join;
pub mod logs;
mod packets;
mod pairing;
pub mod sample;
mod source;
mod time;
pub mod trace;
mod warnings;
