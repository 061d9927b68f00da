//! Gains that are replaced while the loop runs: a blob on its way to the controller node.

use super::remote::Remote;
use crate::size_class::SimScalar;
use slqg::wire::{self, GainsAnswer, GainsPart, Verdict};

/// Bytes of a blob in one frame, as many as the node takes.
const PART: usize = 32;

/// A blob to be sent from some cycle on.
#[derive(Debug, Clone)]
pub struct Replacement {
    /// The cycle in which its first part is sent.
    pub at: usize,
    /// The blob.
    pub blob: Vec<u8>,
    /// Whether it is of the plant, and of the dimensions, that the node runs: one that is not must be refused.
    pub fits: bool,
}

/// How far a blob has come.
pub(super) struct Transfer<'r> {
    replacement: &'r Replacement,
    received: usize,
    /// What the node said in the end.
    pub(super) verdict: Option<Verdict>,
    /// The first cycle after the whole blob was sent.
    pub(super) whole_in: Option<usize>,
}

impl<'r> Transfer<'r> {
    pub(super) fn new(replacement: &'r Replacement) -> Self {
        Self { replacement, received: 0, verdict: None, whole_in: None }
    }

    /// Sends the next part, one a cycle, if there is one to send. Whether it is the last one.
    pub(super) fn send<T: SimScalar>(&mut self, cycle: usize, node: &mut Remote) -> bool {
        let Replacement { at, blob, .. } = self.replacement;
        if cycle < *at || self.verdict.is_some() {
            return false;
        }
        let end = (self.received + PART).min(blob.len());
        let bytes = &blob[self.received..end];
        let part =
            GainsPart { transfer: *at as u32, offset: self.received as u16, total: blob.len() as u16, bytes };
        let mut buffer = vec![0; wire::gains_part_len(bytes.len())];
        node.send(wire::encode_gains_part::<T>(&part, &mut buffer).expect("it is as long as it says"));
        let is_last = end == blob.len();
        if is_last {
            self.whole_in = Some(cycle);
        }
        is_last
    }

    /// Takes what the node answers.
    pub(super) fn answered(&mut self, answer: GainsAnswer) {
        self.received = answer.received.into();
        if answer.verdict != Verdict::Incomplete {
            self.verdict = Some(answer.verdict);
        }
    }
}
