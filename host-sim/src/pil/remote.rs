//! A node on a board: frames to it, frames from it, and how long to wait for them.

use super::{
    emulator::{Emulator, Line, Setup},
    files::Files,
    sealed::{Came, Seals},
};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use slqg::{
    Scalar, Tick,
    authentication::HEAD_LEN,
    blob::DesignId,
    wire::{
        self, Clock, Kind, Question, Role, Status,
        serial::{Unstuffer, stuff, stuffed_len},
    },
};
use std::{
    collections::VecDeque,
    io::{self, Read, Write},
    path::PathBuf,
    time::{Duration, Instant},
};

/// Longest frame from a node.
const LONGEST: usize = 4096;
/// Seconds of silence after which a node is held for dead.
const PATIENCE_SECONDS: u64 = 30;
/// Time after which a silent node's emulator is looked after: a line of FIFOs does not tell that it has ended.
const LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 200_000_000 };

/// Why a node has stopped.
#[derive(Debug, thiserror::Error)]
pub enum NodeFailure {
    /// It does not start, or its line is gone.
    #[error("the {} node: {reason}; its log: {}", name(*role), log.display())]
    Line {
        /// Which node.
        role: Role,
        /// What went wrong.
        reason: io::Error,
        /// Where its log is.
        log: PathBuf,
    },
    /// It says nothing.
    #[error("the {} node has been silent for {PATIENCE_SECONDS} s in cycle {cycle}; its log: {}", name(*role), log.display())]
    Silent {
        /// Which node.
        role: Role,
        /// The cycle it was told.
        cycle: u32,
        /// Where its log is.
        log: PathBuf,
    },
    /// What it says cannot be read.
    #[error("the {} node in cycle {cycle}: {reason}; its log: {}", name(*role), log.display())]
    Frame {
        /// Which node.
        role: Role,
        /// The cycle it was told.
        cycle: u32,
        /// What is wrong.
        reason: String,
        /// Where its log is.
        log: PathBuf,
    },
}

/// As it is called on the command line.
pub fn name(role: Role) -> &'static str {
    match role {
        Role::Controller => "controller",
        Role::Actuator => "actuator",
    }
}

/// A node that runs.
pub(super) struct Remote {
    role: Role,
    emulator: Emulator,
    line: Line,
    unstuffer: Box<Unstuffer<LONGEST>>,
    /// Bytes for the node that have not been written.
    to_send: Vec<u8>,
    /// Frames from the node that have not been asked for.
    received: VecDeque<Vec<u8>>,
    /// The simulator's part, if frames are sealed.
    seals: Option<Seals>,
    /// Frames that the node has sealed, with what was before them.
    sealed: Vec<(Vec<u8>, [u8; HEAD_LEN])>,
    cycle: u32,
    log: PathBuf,
}

impl Remote {
    /// Starts the board and waits until its node says that it is there. `start`: which start of a node it is, counted from 1.
    pub(super) fn start<T: Scalar>(
        setup: &Setup,
        role: Role,
        files: &Files,
        start: u32,
        sealed: Option<DesignId>,
    ) -> Result<Self, NodeFailure> {
        let log = files.log(role);
        let (emulator, line) = Emulator::start(setup, files, role, start)
            .map_err(|reason| NodeFailure::Line { role, reason, log: log.clone() })?;
        let mut node = Self {
            role,
            emulator,
            line,
            unstuffer: Box::default(),
            to_send: vec![0],
            received: VecDeque::new(),
            seals: sealed.map(|design| Seals::new(design, start)),
            sealed: Vec::new(),
            cycle: 0,
            log,
        };
        let hello = node.wait_for(Kind::Status)?;
        let status = node.read(|frame| wire::decode_service::<T, Status>(frame), &hello)?.1;
        if status.role != role {
            return Err(node.damaged(format!("it says that it is the {}", name(status.role))));
        }
        Ok(node)
    }

    /// Tells the node that a cycle begins, or comes next.
    pub(super) fn clock<T: Scalar>(&mut self, tick: Tick, begins: bool) {
        let mut buffer = [0; wire::LONGEST_SERVICE];
        let clock = wire::encode_service::<T, _>(tick, &Clock { begins, period_us: 0 }, &mut buffer);
        self.send(clock.expect("there is room"));
    }

    /// Puts a frame in the queue for the node, sealed if it takes no other.
    pub(super) fn send(&mut self, frame: &[u8]) {
        match &mut self.seals {
            None => self.send_bytes(frame),
            // Without a session it is lost, as on a link that is down.
            Some(seals) => {
                if let Ok(mut head) = seals.head(frame) {
                    head.extend(frame);
                    self.send_bytes(&head);
                }
            }
        }
    }

    /// Hellos that the node has for the other one.
    pub(super) fn hellos(&mut self) -> Vec<Vec<u8>> {
        self.seals.as_mut().map(|seals| std::mem::take(&mut seals.passed_on)).unwrap_or_default()
    }

    /// Frames that the node has sealed since the last call, with what was before them.
    pub(super) fn sealed(&mut self) -> impl Iterator<Item = (Vec<u8>, [u8; HEAD_LEN])> + use<'_> {
        self.sealed.drain(..)
    }

    /// Whether something is to be sent.
    pub(super) fn is_waited_for(&self) -> bool {
        !self.to_send.is_empty()
    }

    /// Puts bytes in the queue for the node, as they are.
    pub(super) fn send_bytes(&mut self, frame: &[u8]) {
        let mut buffer = vec![0; stuffed_len(frame.len())];
        self.to_send.extend(stuff(frame, &mut buffer).expect("the buffer is as long as asked for"));
    }

    /// Tells the node that a cycle begins, for which it waits, and returns the frames that come of it: the last one is of
    /// kind `last`.
    pub(super) fn step<T: Scalar>(&mut self, tick: Tick, last: Kind) -> Result<Vec<Vec<u8>>, NodeFailure> {
        self.cycle = tick.0;
        self.clock::<T>(tick, true);
        let end = self.wait_for(last)?;
        let mut frames: Vec<_> = self.received.drain(..).collect();
        frames.push(end);
        Ok(frames)
    }

    /// Asks the node how it is.
    pub(super) fn status<T: Scalar>(&mut self) -> Result<Status, NodeFailure> {
        let mut buffer = [0; wire::LONGEST_SERVICE];
        let question = wire::encode_service::<T, _>(Tick(0), &Question {}, &mut buffer);
        self.send(question.expect("there is room"));
        let frame = self.wait_for(Kind::Status)?;
        Ok(self.read(|frame| wire::decode_service::<T, Status>(frame), &frame)?.1)
    }

    /// Writes what is queued, and waits for a frame of this kind; those before it are kept.
    fn wait_for(&mut self, kind: Kind) -> Result<Vec<u8>, NodeFailure> {
        if let Err(reason) = self.line.input.write_all(&self.to_send) {
            return Err(self.closed(reason));
        }
        self.to_send.clear();
        let mut chunk = [0; 1024];
        let deadline = Instant::now() + Duration::from_secs(PATIENCE_SECONDS);
        loop {
            let ready = poll(&mut [PollFd::new(&self.line.output, PollFlags::IN)], Some(&LOOK));
            if ready.map_err(|reason| self.broken(reason.into()))? == 0 {
                match self.emulator.last_words() {
                    Some(words) => return Err(self.broken(io::Error::other(words))),
                    None if Instant::now() < deadline => continue,
                    None => {
                        let Self { role, cycle, ref log, .. } = *self;
                        return Err(NodeFailure::Silent { role, cycle, log: log.clone() });
                    }
                }
            }
            let count = match self.line.output.read(&mut chunk) {
                Ok(0) => return Err(self.closed(io::Error::other("its line is closed"))),
                Ok(count) => count,
                Err(reason) => return Err(self.closed(reason)),
            };
            for byte in &chunk[..count] {
                let Some(bytes) = self.unstuffer.take(*byte) else { continue };
                let came = match &mut self.seals {
                    None => Came::Frame(bytes.to_vec(), None),
                    Some(seals) => seals.came(bytes),
                };
                match came {
                    Came::Frame(frame, head) => {
                        self.sealed.extend(head.map(|head| (frame.clone(), head)));
                        self.received.push_back(frame);
                    }
                    Came::Hello(None) => {}
                    Came::Hello(Some(answer)) => {
                        let mut buffer = vec![0; stuffed_len(answer.len())];
                        self.to_send
                            .extend(stuff(&answer, &mut buffer).expect("the buffer is as long as asked for"));
                    }
                }
            }
            if self.received.back().is_some_and(|frame| Kind::of(frame) == Some(kind)) {
                return Ok(self.received.pop_back().unwrap_or_default());
            }
        }
    }

    /// What `read` makes of a frame from this node.
    pub(super) fn read<V, E: std::fmt::Display>(
        &self,
        read: impl FnOnce(&[u8]) -> Result<V, E>,
        frame: &[u8],
    ) -> Result<V, NodeFailure> {
        read(frame).map_err(|error| self.damaged(error.to_string()))
    }

    /// A frame that cannot be right.
    pub(super) fn damaged(&self, reason: String) -> NodeFailure {
        NodeFailure::Frame { role: self.role, cycle: self.cycle, reason, log: self.log.clone() }
    }

    /// Its line is closed: what its emulator says is the better reason.
    fn closed(&mut self, reason: io::Error) -> NodeFailure {
        let words = self.emulator.wait_for_last_words();
        self.broken(words.map_or(reason, io::Error::other))
    }

    fn broken(&self, reason: io::Error) -> NodeFailure {
        NodeFailure::Line { role: self.role, reason, log: self.log.clone() }
    }
}
