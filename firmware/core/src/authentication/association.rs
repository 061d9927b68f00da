//! Who speaks with whom, which kinds of frame, and under which keys.

use super::{Key, mac::derive};
use crate::{blob::DesignId, wire::Kind};

/// Two ends that speak with each other. Its number is on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Association {
    /// A sensor and the controller: measurements.
    Sensing = 1,
    /// The controller and the actuator: control frames one way, acknowledgements the other.
    Loop = 2,
    /// The clock and a node: clock frames. Each node has an association of its own with the clock.
    Timing = 4,
    /// A host and the controller: gains and references.
    Service = 7,
}

/// Which end of an association.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Side {
    /// The sensor, the clock, the host; of the loop, the controller.
    Upstream = 0,
    /// The controller, a node; of the loop, the actuator.
    Downstream = 1,
}

impl Side {
    /// The other end.
    pub const fn other(self) -> Self {
        match self {
            Self::Upstream => Self::Downstream,
            Self::Downstream => Self::Upstream,
        }
    }
}

impl Association {
    /// Between whom frames of a kind go, and from which side; `None` for what is not sealed.
    pub const fn of(kind: Kind) -> Option<(Self, Side)> {
        Some(match kind {
            Kind::Measurement => (Self::Sensing, Side::Upstream),
            Kind::Control => (Self::Loop, Side::Upstream),
            Kind::Acknowledgement => (Self::Loop, Side::Downstream),
            Kind::Clock => (Self::Timing, Side::Upstream),
            Kind::GainsPart | Kind::Reference => (Self::Service, Side::Upstream),
            Kind::Applied | Kind::Ran | Kind::GainsAnswer | Kind::Question | Kind::Status | Kind::Tuned => {
                return None;
            }
        })
    }

    /// Whether `side` hears frames of it in every cycle, so that silence means that the session is of no use.
    pub(super) const fn is_heard_by(self, side: Side) -> bool {
        match self {
            Self::Sensing | Self::Timing => matches!(side, Side::Downstream),
            Self::Loop => true,
            Self::Service => false,
        }
    }
}

/// Which loop frames belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// Number of the loop among those that share keys, given by whoever installs it.
    pub loop_id: u32,
    /// The plant that the gains are for.
    pub design: DesignId,
}

/// The keys of an association. They may be one where frames go one way only; directions are told apart all the same.
#[derive(Debug, Clone)]
pub struct Keys {
    /// Of what the upstream end sends.
    pub downstream: Key,
    /// Of what the downstream end sends; if it sends no frames, of its part of the handshake.
    pub upstream: Key,
}

impl Keys {
    /// Of an association whose frames go one way.
    pub fn one_way(key: Key) -> Self {
        Self { downstream: key.clone(), upstream: key }
    }

    /// The key of what `side` sends.
    pub(super) fn of_sender(&self, side: Side) -> &Key {
        match side {
            Side::Upstream => &self.downstream,
            Side::Downstream => &self.upstream,
        }
    }
}

/// What a derived key is bound to: association, sender, loop and plant.
#[derive(Clone, Copy)]
pub(super) struct Binding {
    pub(super) association: Association,
    pub(super) identity: Identity,
}

impl Binding {
    /// The key of hellos that `sender` sends.
    pub(super) fn hello(&self, keys: &Keys, sender: Side) -> Key {
        self.derive(keys, sender, b"slqg hello 1", &[])
    }

    /// The key of frames that `sender` sends in the session of its own nonce and its peer's.
    pub(super) fn frames(&self, keys: &Keys, sender: Side, own: u64, peer: u64) -> Key {
        let mut nonces = [0; 16];
        nonces[..8].copy_from_slice(&own.to_le_bytes());
        nonces[8..].copy_from_slice(&peer.to_le_bytes());
        self.derive(keys, sender, b"slqg frame 1", &nonces)
    }

    fn derive(&self, keys: &Keys, sender: Side, label: &[u8], nonces: &[u8]) -> Key {
        let Identity { loop_id, design } = self.identity;
        let ends = [self.association as u8, sender as u8];
        let context = [&ends[..], &loop_id.to_le_bytes(), &design.0.to_le_bytes(), nonces];
        derive(keys.of_sender(sender), label, &context)
    }
}
