//! What a node tells of itself: cycles, refused frames, memory.

use crate::board::{Board, Notice, Usage};
use crate::clock::Count;
use crate::design::Scalar;
use slqg::{
    Tick,
    wire::{self, Kind, Question, Role, Status},
};

/// A node's counts since its start; all saturate.
#[derive(Debug, Default)]
pub(crate) struct Health {
    /// Cycles run.
    cycles: u32,
    realigned: u32,
    rejected: u32,
    /// Of the end of the loop on this node.
    end: slqg::Health,
}

impl Health {
    /// The end of the loop on this node is in this health.
    pub(crate) fn is(&mut self, end: slqg::Health, board: &mut impl Board) {
        if core::mem::replace(&mut self.end, end) != end {
            board.note(Notice::Health(end));
        }
    }

    /// A cycle has been run.
    pub(crate) fn ran(&mut self) {
        self.cycles = self.cycles.saturating_add(1);
    }

    /// The node begins with cycle `tick`, for the first time or anew.
    pub(crate) fn aligned(&mut self, is_first: bool, tick: Tick, board: &mut impl Board) {
        if is_first {
            board.note(Notice::Aligned(tick));
        } else {
            self.realigned = self.realigned.saturating_add(1);
            board.note(Notice::Realigned(tick));
        }
    }

    /// A clock frame has told of cycle `tick`, which nothing confirms: it has changed nothing.
    pub(crate) fn clock_refused(&mut self, tick: Tick, board: &mut impl Board) {
        self.rejected = self.rejected.saturating_add(1);
        board.note(Notice::ClockRefused(tick));
    }

    /// A frame has changed nothing.
    pub(crate) fn rejected(&mut self, frame: &[u8], board: &mut impl Board) {
        self.rejected = self.rejected.saturating_add(1);
        board.note(Notice::Rejected(Kind::of(frame).map_or(0, |kind| kind as u8)));
    }

    /// Whether a frame asks how the node is.
    pub(crate) fn is_asked(frame: &[u8]) -> bool {
        wire::decode_service::<Scalar, Question>(frame).is_ok()
    }

    /// Tells the host how the node is. `buffer` holds [`wire::LONGEST_SERVICE`] bytes.
    pub(crate) fn tell(&self, role: Role, count: &Count, buffer: &mut [u8], board: &mut impl Board) {
        let Usage { overruns, stack, variables } = board.usage();
        let Self { cycles, realigned, rejected, .. } = *self;
        let status = Status { role, cycles, realigned, rejected, overruns, stack, variables };
        let tick = count.next().unwrap_or_default();
        if let Ok(frame) = wire::encode_service::<Scalar, _>(tick, &status, buffer) {
            board.send(frame);
        }
    }
}
