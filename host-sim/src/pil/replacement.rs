//! Gains that are replaced while the loop runs: a blob on its way to the controller node.

use super::remote::Remote;
use slqg::Scalar;
use slqg::wire::{self, GainsAnswer, GainsPart, Verdict};

/// Bytes of a blob in one frame, as many as the node takes.
const PART: usize = 32;

/// A blob to be sent from some cycle on.
#[derive(Debug, Clone)]
pub struct Replacement {
    at: usize,
    blob: Vec<u8>,
    /// See [`Replacement::new`].
    pub(super) fits: bool,
}

/// Why a blob cannot be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Unsendable {
    /// It is too long.
    #[error("the gains have {0} bytes as a blob; over the link they may have up to {max}", max = u16::MAX)]
    TooLong(usize),
    /// The run ends before its last part.
    #[error("--gains-at: found {at}; the gains go in {parts} parts, one a cycle, and the run has {cycles} cycles: {}", allowed(*.parts, *.cycles))]
    TooLate {
        /// The cycle of the first part.
        at: usize,
        /// Parts.
        parts: usize,
        /// Cycles of the run.
        cycles: usize,
    },
}

fn allowed(parts: usize, cycles: usize) -> String {
    match cycles.checked_sub(parts) {
        Some(latest) => format!("give 0 to {latest}"),
        None => format!("give --cycles {parts} or more"),
    }
}

impl Replacement {
    /// A blob whose first part is sent in cycle `at` of `cycles`. `fits`: whether it is of the plant, and of the dimensions, that
    /// the node runs; one that is not must be refused by the node.
    ///
    /// # Errors
    /// If there is no way to send all of it.
    pub fn new(blob: Vec<u8>, fits: bool, at: usize, cycles: usize) -> Result<Self, Unsendable> {
        let parts = blob.len().div_ceil(PART);
        if blob.len() > usize::from(u16::MAX) {
            return Err(Unsendable::TooLong(blob.len()));
        }
        if at.saturating_add(parts) > cycles {
            return Err(Unsendable::TooLate { at, parts, cycles });
        }
        Ok(Self { at, blob, fits })
    }
}

/// How far a blob has come.
pub(super) struct Transfer<'r> {
    replacement: &'r Replacement,
    received: usize,
    /// What the node said in the end, and in which cycle.
    pub(super) verdict: Option<(Verdict, usize)>,
}

impl<'r> Transfer<'r> {
    pub(super) fn new(replacement: &'r Replacement) -> Self {
        Self { replacement, received: 0, verdict: None }
    }

    /// Sends the next part, one a cycle, if there is one to send. Whether it is the last one.
    pub(super) fn send<T: Scalar>(&mut self, cycle: usize, node: &mut Remote) -> bool {
        let Replacement { at, blob, .. } = self.replacement;
        if cycle < *at || self.verdict.is_some() {
            return false;
        }
        let end = (self.received + PART).min(blob.len());
        let bytes = &blob[self.received..end];
        let part = GainsPart {
            transfer: *at as u32 + 1,
            offset: self.received as u16,
            total: blob.len() as u16,
            bytes,
        };
        let mut buffer = vec![0; wire::gains_part_len(bytes.len())];
        node.send(wire::encode_gains_part::<T>(&part, &mut buffer).expect("it is as long as it says"));
        end == blob.len()
    }

    /// The node has lost the parts that it had: those of a blob that it has not judged are sent again.
    pub(super) fn restarted(&mut self) {
        self.received = 0;
    }

    /// Takes what the node answers in `cycle`.
    pub(super) fn answered(&mut self, answer: GainsAnswer, cycle: usize) {
        self.received = answer.received.into();
        if answer.verdict != Verdict::Incomplete {
            self.verdict = Some((answer.verdict, cycle));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_are_sent_only_if_the_run_has_a_cycle_for_every_part() {
        let new = |bytes, at| Replacement::new(vec![0; bytes], true, at, 100).map(|_| ());
        assert_eq!(new(65, 97), Ok(()));
        let late = new(65, 98).unwrap_err();
        assert_eq!(late, Unsendable::TooLate { at: 98, parts: 3, cycles: 100 });
        assert!(late.to_string().ends_with("the run has 100 cycles: give 0 to 97"), "{late}");
        let never = new(101 * PART, 0).unwrap_err().to_string();
        assert!(never.ends_with("give --cycles 101 or more"), "{never}");
        assert_eq!(new(1 << 16, 0), Err(Unsendable::TooLong(1 << 16)), "its length has 16 bits");
    }
}
