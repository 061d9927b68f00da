//! [`About`]: where packets come from: the format of the log, the number they were told apart by, and what was skipped.

use super::clocks::Told;
use serde::{Serialize, Serializer, ser::SerializeMap};

/// What is no packet of the link, and so is not counted as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Skip {
    /// CAN error frames and error messages of a logger.
    Error,
    /// CAN remote frames: they carry no data.
    Remote,
    /// Frames with another identifier, or to another port.
    Identifier,
    /// Frames on another interface.
    Interface,
    /// Frames of another kind than `--link` carries.
    Kind,
    /// What is neither CAN data nor UDP.
    Protocol,
    /// Too short for the number.
    Short,
    /// Comments, statistics and events of a logger.
    Comment,
    /// CAN XL frames.
    Xl,
    /// The last line or record, which is not whole.
    Cut,
}

const KINDS: [(Skip, &str, &str); 10] = [
    (Skip::Error, "error_frames", "error frames"),
    (Skip::Remote, "remote_frames", "remote frames"),
    (Skip::Identifier, "other_identifiers", "frames with other identifiers or ports"),
    (Skip::Interface, "other_interfaces", "frames on other interfaces"),
    (Skip::Kind, "other_kinds", "frames of other kinds"),
    (Skip::Protocol, "other_protocols", "packets of other protocols"),
    (Skip::Short, "too_short", "frames too short for the number"),
    (Skip::Comment, "comments", "comments and events"),
    (Skip::Xl, "can_xl", "CAN XL frames"),
    (Skip::Cut, "cut_off", "cut off at the end"),
];

/// How much was skipped, by kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Skipped([u64; KINDS.len()]);

impl Skipped {
    /// Counts one.
    pub(super) fn add(&mut self, skip: Skip) {
        self.0[skip as usize] += 1;
    }

    /// How many of a kind.
    pub fn of(&self, skip: Skip) -> u64 {
        self.0[skip as usize]
    }

    /// Counts all of another log too.
    pub(super) fn join(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(count, other)| *count += other);
    }

    fn found(&self) -> impl Iterator<Item = (u64, &'static str, &'static str)> + '_ {
        KINDS.iter().map(|&(skip, key, words)| (self.of(skip), key, words)).filter(|(count, ..)| *count > 0)
    }

    /// For a reader: counts and what they are of; nothing if nothing was skipped.
    pub fn words(&self) -> Option<String> {
        let found: Vec<String> = self.found().map(|(count, _, words)| format!("{count} {words}")).collect();
        (!found.is_empty()).then(|| found.join(", "))
    }
}

impl Serialize for Skipped {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (count, key, _) in self.found() {
            map.serialize_entry(key, &count)?;
        }
        map.end()
    }
}

/// Where packets come from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct About {
    /// Name of the format.
    pub format: &'static str,
    /// By which number packets were told apart.
    pub number: Option<String>,
    /// What was skipped.
    pub skipped: Skipped,
    /// Frames that the logger itself says it has missed.
    pub dropped: u64,
    /// Jumps of the sender's counter that are against the time.
    pub restarts: u64,
    /// How the clocks of the ends are to each other, where times were corrected.
    pub clock: Option<Told>,
    /// What was assumed or done to the times, in words.
    pub notes: Vec<String>,
}

impl About {
    /// Of all logs together: each note once.
    pub(super) fn of<'a>(logs: impl Iterator<Item = &'a Self>) -> Self {
        let mut all = Self::default();
        for about in logs {
            all.format = about.format;
            all.number = all.number.or_else(|| about.number.clone());
            all.clock = match (all.clock, about.clock) {
                (Some(one), Some(other)) if one.margin >= other.margin => Some(one),
                (one, other) => other.or(one),
            };
            all.skipped.join(&about.skipped);
            all.dropped += about.dropped;
            all.restarts += about.restarts;
            for note in &about.notes {
                if !all.notes.contains(note) {
                    all.notes.push(note.clone());
                }
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_skipped_is_told_by_name() {
        let mut skipped = Skipped::default();
        assert_eq!(skipped.words(), None);
        for (skip, ..) in KINDS {
            skipped.add(skip);
        }
        skipped.add(Skip::Error);
        assert!(KINDS.iter().enumerate().all(|(index, (skip, ..))| *skip as usize == index));
        assert!(skipped.words().expect("words").starts_with("2 error frames, 1 remote frames"));
    }
}
