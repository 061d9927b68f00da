//! A board made of memory, which looks at everything that its node does.

use slqg::Tick;
use slqg::actuator::Applied;
use slqg::nalgebra::SVector;
use slqg::wire::{self, GainsAnswer, Kind, Ran, Status};
use slqg_nodes::board::{Board, Notice, Usage};
use slqg_nodes::clock::CONFIRMING;
use slqg_nodes::design::{INPUTS, SEQUENCE_LENGTH, Scalar};

/// Frames that a node sends for one that it takes, at most: an answer, or those of a cycle.
const MOST_AT_ONCE: usize = 2;

/// Keeps what the node has sent since the last look.
#[derive(Debug, Default)]
pub(super) struct Desk {
    sent: Vec<Vec<u8>>,
    /// The cycle that is to be applied next, since the clock has told one.
    next: Option<Tick>,
    /// Times that the clock was refused since the node has taken its time.
    refused: u8,
    /// Whether what is applied next is the safe input, which is no cycle.
    is_safe: bool,
}

impl Desk {
    /// What was sent for one frame or period that was taken: each a frame of the loop, and not many.
    pub(super) fn sent(&mut self) -> Vec<Vec<u8>> {
        assert!(self.sent.len() <= MOST_AT_ONCE, "{} frames at once", self.sent.len());
        for frame in &self.sent {
            let is_right = match Kind::of(frame) {
                Some(Kind::Control) => {
                    let mut room = [SVector::<Scalar, INPUTS>::zeros(); SEQUENCE_LENGTH];
                    wire::decode_control(frame, &mut room)
                        .is_ok_and(|sent| sent.inputs.len() == SEQUENCE_LENGTH)
                }
                Some(Kind::Applied) => wire::decode_applied::<Scalar, INPUTS>(frame).is_ok(),
                Some(Kind::Acknowledgement) => wire::decode_acknowledgement::<Scalar>(frame).is_ok(),
                Some(Kind::Status) => wire::decode_service::<Scalar, Status>(frame).is_ok(),
                Some(Kind::Ran) => wire::decode_service::<Scalar, Ran>(frame).is_ok(),
                Some(Kind::GainsAnswer) => wire::decode_service::<Scalar, GainsAnswer>(frame).is_ok(),
                _ => false,
            };
            assert!(is_right, "{frame:?}");
        }
        std::mem::take(&mut self.sent)
    }
}

impl Board for Desk {
    fn send(&mut self, frame: &[u8]) {
        self.sent.push(frame.to_vec());
    }

    fn restart_period(&mut self) {}

    fn apply(&mut self, applied: &Applied<Scalar, INPUTS>) {
        assert!(applied.input.iter().all(|value| value.is_finite()), "what is applied is finite");
        if std::mem::take(&mut self.is_safe) {
            return;
        }
        assert!(self.next.is_none_or(|next| next == applied.tick), "each cycle is applied once, in order");
        self.next = Some(applied.tick + 1);
    }

    fn ticks(&self) -> u32 {
        0
    }

    fn elapsed(&self, _begin: u32) -> u32 {
        0
    }

    fn usage(&self) -> Usage {
        Usage::default()
    }

    fn note(&mut self, notice: Notice) {
        match notice {
            Notice::Aligned(_) => (self.next, self.refused) = (None, 0),
            Notice::Realigned(tick) => {
                assert!(self.refused >= CONFIRMING - 1, "{tick:?}: a clock that jumps is confirmed");
                (self.next, self.refused) = (Some(tick), 0);
            }
            Notice::ClockRefused(_) => self.refused = self.refused.saturating_add(1),
            Notice::Safe => self.is_safe = true,
            _ => {}
        }
    }
}
