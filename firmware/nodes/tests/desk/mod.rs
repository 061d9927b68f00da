//! A board made of memory, and frames for its node.
#![allow(dead_code)]

use slqg::wire::{self, Clock, Kind};
use slqg::{Scalar as _, Tick};
use slqg_nodes::board::{Board, Node, Notice, Usage};
use slqg_nodes::design::Scalar;

/// Keeps what the node does.
#[derive(Debug, Default)]
pub(crate) struct Desk {
    pub(crate) sent: Vec<Vec<u8>>,
    pub(crate) notices: Vec<Notice>,
    pub(crate) restarts: u32,
}

impl Board for Desk {
    fn send(&mut self, frame: &[u8]) {
        self.sent.push(frame.to_vec());
    }

    fn restart_period(&mut self) {
        self.restarts += 1;
    }

    fn ticks(&self) -> u32 {
        0
    }

    fn elapsed(&self, _begin: u32) -> u32 {
        0
    }

    fn usage(&self) -> Usage {
        Usage { stack: 100, variables: 20, overruns: 3 }
    }

    fn note(&mut self, notice: Notice) {
        self.notices.push(notice);
    }
}

impl Desk {
    /// Kinds of the frames sent since the last call.
    pub(crate) fn kinds(&mut self) -> Vec<Kind> {
        self.sent.drain(..).map(|frame| Kind::of(&frame).expect("a frame of a known kind")).collect()
    }

    /// Tells `node` that a cycle begins, or comes next.
    pub(crate) fn clock(&mut self, node: &mut impl Node, tick: u32, clock: Clock) {
        let mut buffer = [0; wire::LONGEST_SERVICE];
        let frame =
            wire::encode_service::<Scalar, _>(Tick(tick), &clock, &mut buffer).expect("there is room");
        node.take(frame, self);
    }
}

/// Cycles follow each other in time.
pub(crate) const RUNNING: Clock = Clock { begins: true, period_us: 20_000 };
/// The node is to wait for each.
pub(crate) const STEPPED: Clock = Clock { begins: true, period_us: 0 };

/// Bytes of a number in the design that is tested.
pub(crate) const BYTES: u8 = Scalar::BYTES;
