//! [`Early`]: the first frames of logs with their payload, until it is decided what tells packets apart.

use super::{
    collector::End,
    formats::message::{Message, Stream},
    time::Nanoseconds,
};
use std::collections::BTreeMap;

/// Frames with their payload, until it is decided what to do with them.
#[derive(Debug, Default)]
pub(super) struct Early {
    frames: Vec<(Nanoseconds, End, Stream, u32)>,
    payloads: Vec<u8>,
}

/// Most bytes of a payload that are kept.
const PREFIX: usize = 72;

impl Early {
    pub(super) fn push(&mut self, message: &Message<'_>, end: End) {
        let data = &message.data[..message.data.len().min(PREFIX)];
        self.frames.push((message.time, end, message.stream, data.len() as u32));
        self.payloads.extend_from_slice(data);
    }

    pub(super) fn len(&self) -> usize {
        self.frames.len()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    pub(super) fn has_none(&self, end: End) -> bool {
        self.frames.iter().all(|(_, of, ..)| *of != end)
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (Nanoseconds, End, Stream, &[u8])> + Clone {
        let mut at = 0;
        self.frames.iter().map(move |&(time, end, stream, len)| {
            let from = at;
            at += len as usize;
            (time, end, stream, &self.payloads[from..at])
        })
    }

    pub(super) fn each(&self, mut take: impl FnMut(&Message<'_>, End)) {
        for (time, end, stream, data) in self.iter() {
            take(&Message { time, interface: b"", direction: None, stream, data }, end);
        }
    }

    /// Payloads of each stream at an end, in the order of time.
    pub(super) fn payloads(&self, at: End) -> BTreeMap<Stream, Vec<&[u8]>> {
        let mut seen: Vec<_> = self.iter().filter(|(_, end, ..)| *end == at).collect();
        seen.sort_by_key(|(time, ..)| *time);
        let mut payloads: BTreeMap<Stream, Vec<&[u8]>> = BTreeMap::new();
        for (_, _, stream, payload) in seen {
            payloads.entry(stream).or_default().push(payload);
        }
        payloads
    }
}
