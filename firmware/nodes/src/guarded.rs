//! A node behind a guard: what it takes has been opened, what it sends of the loop is sealed. The node is that of any loop.

use crate::board::{Board, Node, Notice, Usage};
use crate::design::{INPUTS, SEQUENCE_LENGTH, Scalar};
use slqg::{
    Scalar as _,
    actuator::Applied,
    authentication::{Alarm, Association, Guard, HEAD_LEN, Nonces, Opened},
    wire::{self, GainsAnswer, Kind, Status, Verdict},
};

/// Bytes of the longest frame that is sealed.
const ROOM: usize = {
    let control = wire::control_len(INPUTS, SEQUENCE_LENGTH, Scalar::BYTES);
    HEAD_LEN + if control > wire::LONGEST_ACKNOWLEDGEMENT { control } else { wire::LONGEST_ACKNOWLEDGEMENT }
};

/// What a guarded node needs of its board beside the rest: memory that outlives power.
pub trait Vault: Nonces {
    /// The newest version of gains that was kept; 0 if none was.
    fn gains_version(&self) -> u32;
    /// Keeps the version of gains that have just come into force.
    fn keep_gains_version(&mut self, version: u32);
}

/// A node and its guard of `S` sessions.
pub struct Guarded<'g, N, V, const S: usize> {
    node: N,
    // Lent: whoever moves the node does not move the sessions.
    guard: &'g mut Guard<S>,
    vault: V,
    /// What was told last.
    alarm: Option<Alarm>,
    buffer: [u8; ROOM],
}

impl<'g, N: Node, V: Vault, const S: usize> Guarded<'g, N, V, S> {
    /// `node` behind `guard`, which is told the version of gains that was kept.
    #[inline(never)]
    pub fn new(node: N, guard: &'g mut Guard<S>, vault: V) -> Self {
        guard.keep_version(vault.gains_version());
        Self { node, guard, vault, alarm: None, buffer: [0; ROOM] }
    }

    /// The node, and its board behind the guard.
    fn split<'s, B>(&'s mut self, board: &'s mut B) -> (&'s mut N, Sealing<'s, B, V, S>) {
        let Self { node, guard, vault, buffer, .. } = self;
        (node, Sealing { board, guard, vault, buffer })
    }

    /// Hellos that are due, and an alarm that has begun.
    fn say(&mut self, board: &mut impl Board) {
        while let Some(hello) = self.guard.due(&mut self.vault) {
            board.send(&hello);
        }
        let alarm = self.guard.alarm();
        if alarm != self.alarm
            && let Some(alarm) = alarm
        {
            board.note(Notice::Alarm(alarm));
        }
        self.alarm = alarm;
    }
}

impl<N: Node, V: Vault, const S: usize> Node for Guarded<'_, N, V, S> {
    fn start(&mut self, board: &mut impl Board) {
        let (node, mut sealing) = self.split(board);
        node.start(&mut sealing);
        self.say(board);
    }

    fn take(&mut self, frame: &[u8], board: &mut impl Board) {
        // Whoever asks how the node is learns nothing that drives a plant. What a sealed frame has in the place of a kind is a tag.
        let is_question = frame.first() == Some(&wire::VERSION) && Kind::of(frame) == Some(Kind::Question);
        let opened = match is_question {
            true => Ok(Opened::Frame(frame)),
            false => self.guard.open(frame, &mut self.vault),
        };
        let opened = match opened {
            Ok(Opened::Frame(plain)) => plain,
            Ok(Opened::Hello(answer)) => {
                if let Some(answer) = answer {
                    board.send(&answer);
                }
                return;
            }
            Err(_) => {
                let kind = frame.get(HEAD_LEN..).and_then(Kind::of);
                board.note(Notice::Rejected(kind.map_or(0, |kind| kind as u8)));
                return self.say(board);
            }
        };
        let begins = Kind::of(opened) == Some(Kind::Clock);
        if begins {
            self.guard.cycle();
        }
        let (node, mut sealing) = self.split(board);
        node.take(opened, &mut sealing);
        if begins {
            self.say(board);
        }
    }

    fn period_over(&mut self, board: &mut impl Board) {
        self.guard.cycle();
        let (node, mut sealing) = self.split(board);
        node.period_over(&mut sealing);
        self.say(board);
    }

    fn safe_frame<'b>(&mut self, buffer: &'b mut [u8]) -> &'b [u8] {
        self.node.safe_frame(buffer)
    }
}

/// A board whose node's frames are sealed on their way.
struct Sealing<'s, B, V, const S: usize> {
    board: &'s mut B,
    guard: &'s mut Guard<S>,
    vault: &'s mut V,
    buffer: &'s mut [u8; ROOM],
}

impl<B: Board, V: Vault, const S: usize> Board for Sealing<'_, B, V, S> {
    fn send(&mut self, frame: &[u8]) {
        match Kind::of(frame) {
            Some(kind) if Association::of(kind).is_some() => {
                // Without a session it is lost, as on a link that is down.
                if let Ok(sealed) = self.guard.seal(frame, self.buffer) {
                    self.board.send(sealed);
                }
            }
            Some(Kind::GainsAnswer) => {
                if let Ok((version, GainsAnswer { verdict: Verdict::InForce, .. })) =
                    wire::decode_service::<Scalar, GainsAnswer>(frame)
                {
                    self.guard.keep_version(version.0);
                    self.vault.keep_gains_version(version.0);
                }
                self.board.send(frame);
            }
            Some(Kind::Status) => self.send_status(frame),
            _ => self.board.send(frame),
        }
    }

    fn restart_period(&mut self) {
        self.board.restart_period();
    }

    fn apply(&mut self, applied: &Applied<Scalar, INPUTS>) {
        self.board.apply(applied);
    }

    fn ticks(&self) -> u32 {
        self.board.ticks()
    }

    fn elapsed(&self, begin: u32) -> u32 {
        self.board.elapsed(begin)
    }

    fn usage(&self) -> Usage {
        self.board.usage()
    }

    fn note(&mut self, notice: Notice) {
        self.board.note(notice);
    }
}

impl<B: Board, V: Vault, const S: usize> Sealing<'_, B, V, S> {
    /// A status counts what the guard has refused, too.
    #[inline(never)]
    fn send_status(&mut self, frame: &[u8]) {
        let Ok((tick, mut status)) = wire::decode_service::<Scalar, Status>(frame) else { return };
        status.rejected = status.rejected.saturating_add(self.guard.failures().all());
        let mut buffer = [0; wire::LONGEST_SERVICE];
        if let Ok(frame) = wire::encode_service::<Scalar, _>(tick, &status, &mut buffer) {
            self.board.send(frame);
        }
    }
}
