//! Sensor, clock and host of nodes whose frames are sealed: what the simulator says to a node, and hellos.
//!
//! Keys are those for tests. Frames of the two nodes for each other pass as the nodes have sealed them.

use gain_gen::keys::KeyFile;
use slqg::authentication::{
    AlarmSettings, Association, Guard, HEAD_LEN, HELLO, Nonces, NotSealed, Opened, SEALED, Side,
};
use slqg::blob::DesignId;
use slqg::wire::Kind;
use std::num::NonZeroU64;

/// The simulator's ends of a node's sessions. It says as much to both, though an actuator takes nothing but the clock.
pub(super) struct Seals {
    guard: Guard<3>,
    nonces: Counter,
    /// Hellos for the other node.
    pub(super) passed_on: Vec<Vec<u8>>,
}

/// Nonces by counting, which begins elsewhere whenever a node is started. A run's end is the end of all its sessions.
struct Counter(u64);

impl Nonces for Counter {
    fn next(&mut self) -> NonZeroU64 {
        self.0 += 1;
        NonZeroU64::MIN.saturating_add(self.0)
    }
}

/// What came from a node.
pub(super) enum Came {
    /// A frame as plain nodes send it, and what was before it if it was sealed.
    Frame(Vec<u8>, Option<[u8; HEAD_LEN]>),
    /// A hello, and what is to be answered.
    Hello(Option<Vec<u8>>),
}

impl Seals {
    /// For a node of the plant `design`, the `start`-th that the run has started.
    pub(super) fn new(design: DesignId, start: u32) -> Self {
        let keys = KeyFile::of_tests();
        let session = |association| keys.session(association, Side::Upstream, design);
        let sessions = [Association::Timing, Association::Sensing, Association::Service].map(session);
        let nonces = Counter(u64::from(start) << 32);
        Self { guard: Guard::new(sessions, AlarmSettings::default()), nonces, passed_on: Vec::new() }
    }

    /// What goes before a frame for the node; nothing before one that is never sealed.
    pub(super) fn head(&mut self, frame: &[u8]) -> Result<Vec<u8>, NotSealed> {
        match Kind::of(frame).and_then(Association::of) {
            Some(_) => self.guard.head(frame).map(Vec::from),
            None => Ok(Vec::new()),
        }
    }

    /// Sorts what came from the node. Hellos of the loop are the other node's.
    pub(super) fn came(&mut self, bytes: &[u8]) -> Came {
        match bytes.split_first_chunk::<HEAD_LEN>() {
            Some((head, frame)) if head[0] == SEALED => Came::Frame(frame.to_vec(), Some(*head)),
            _ if bytes.first() == Some(&HELLO) => {
                if bytes.get(1) == Some(&(Association::Loop as u8)) {
                    self.passed_on.push(bytes.to_vec());
                    return Came::Hello(None);
                }
                match self.guard.open(bytes, &mut self.nonces) {
                    Ok(Opened::Hello(answer)) => Came::Hello(answer.map(Vec::from)),
                    // The node says it again if it matters.
                    _ => Came::Hello(None),
                }
            }
            _ => Came::Frame(bytes.to_vec(), None),
        }
    }
}
