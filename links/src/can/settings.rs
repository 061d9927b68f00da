//! [`Settings`]: all that stays as it is while a bus runs, checked before it does.

use super::{
    errors::{Errors, ErrorsError},
    frame::Format,
    id::Id,
    source::{NodeId, Source, SourceError},
    time::{RateError, Rates},
};
use std::collections::HashMap;

/// How a bus is set up.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Nominal bit rate, in bit/s.
    pub bit_rate: u32,
    /// Bit rate of the data phase of CAN FD frames with a switch, in bit/s.
    pub data_bit_rate: Option<u32>,
    /// Nodes on the bus, at least 2: a sender needs a receiver that acknowledges.
    pub nodes: u16,
    /// Frames that wait in each node, the one on the bus included.
    pub queue: usize,
    /// How long frames are.
    pub stuffing: Stuffing,
    /// Messages that nodes send by themselves.
    pub sources: Vec<Source>,
    /// Identifiers of the frames that the caller will offer, and the nodes they belong to. What is not listed belongs to
    /// the node that offers it first.
    pub identifiers: Vec<(Id, NodeId)>,
    /// Disturbed bits.
    pub errors: Errors,
    /// What follows bus-off.
    pub recovery: Recovery,
    /// Whether the bus keeps a log of all frames.
    pub log: bool,
}

/// How many stuff bits a frame has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stuffing {
    /// As many as its bits ask for.
    #[default]
    Actual,
    /// As many as any frame of its size can have; error flags are as long as they can be.
    Worst,
}

/// What a node does after bus-off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Recovery {
    /// Waits for 128 sequences of 11 recessive bits, then takes part again.
    #[default]
    Automatic,
    /// Stays off.
    Never,
}

/// Settings with which no bus can run.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// A bit rate.
    #[error(transparent)]
    Rate(#[from] RateError),
    /// Bit errors.
    #[error(transparent)]
    Errors(#[from] ErrorsError),
    /// Fewer than two nodes.
    #[error("found {0} nodes: a bus needs at least 2, one to send and one to acknowledge")]
    Nodes(u16),
    /// No room in the queues.
    #[error("found queues for 0 frames: a node needs room for at least 1")]
    Queue,
    /// A source.
    #[error("source {index}: {problem}")]
    Source {
        /// Index in the settings.
        index: usize,
        /// What is wrong with it.
        problem: SourceError,
    },
    /// A node that does not exist.
    #[error("identifier {id} belongs to node {}, but nodes are 0 to {}", node.0, nodes - 1)]
    NoSuchNode {
        /// Whose.
        id: Id,
        /// The node.
        node: NodeId,
        /// How many there are.
        nodes: u16,
    },
    /// Two nodes with one identifier: both could win the same arbitration.
    #[error(
        "identifier {id} belongs to node {} and to node {}: every identifier must belong to one node alone",
        first.0, second.0
    )]
    SharedIdentifier {
        /// Which.
        id: Id,
        /// A node.
        first: NodeId,
        /// Another one.
        second: NodeId,
    },
    /// A frame with a switch on a bus without a second bit rate.
    #[error(
        "source {index} switches the bit rate, but there is no data_bit_rate: give one, or send without a switch"
    )]
    NoDataBitRate {
        /// Index in the settings.
        index: usize,
    },
}

impl Settings {
    /// A bus of `nodes` nodes with queues of 32 frames, without a data bit rate, traffic or errors.
    pub fn new(bit_rate: u32, nodes: u16) -> Self {
        Settings {
            bit_rate,
            data_bit_rate: None,
            nodes,
            queue: 32,
            stuffing: Stuffing::default(),
            sources: Vec::new(),
            identifiers: Vec::new(),
            errors: Errors::default(),
            recovery: Recovery::default(),
            log: false,
        }
    }

    /// Bit times and the owners of the known identifiers.
    pub(super) fn check(&self) -> Result<(Rates, HashMap<Id, NodeId>), SettingsError> {
        let rates = Rates::new(self.bit_rate, self.data_bit_rate)?;
        self.errors.check()?;
        if self.nodes < 2 {
            return Err(SettingsError::Nodes(self.nodes));
        }
        if self.queue == 0 {
            return Err(SettingsError::Queue);
        }
        for (index, source) in self.sources.iter().enumerate() {
            source.check().map_err(|problem| SettingsError::Source { index, problem })?;
            if self.data_bit_rate.is_none() && source.format == (Format::Fd { bit_rate_switch: true }) {
                return Err(SettingsError::NoDataBitRate { index });
            }
        }
        let mut owners = HashMap::new();
        let sources = self.sources.iter().map(|source| (source.id, source.node));
        for (id, node) in sources.chain(self.identifiers.iter().copied()) {
            if node.0 >= self.nodes {
                return Err(SettingsError::NoSuchNode { id, node, nodes: self.nodes });
            }
            match owners.insert(id, node) {
                Some(first) if first != node => {
                    return Err(SettingsError::SharedIdentifier { id, first, second: node });
                }
                _ => {}
            }
        }
        Ok((rates, owners))
    }
}
