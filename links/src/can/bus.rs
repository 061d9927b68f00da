//! [`Bus`]: the state of a bus, what callers do with it, and in which order things happen. How frames reach their queues is
//! `arrival`, what they meet on the bus is `transmission`.

use super::{
    errors::ErrorProcess,
    event::{Event, Fate, Origin},
    frame::{Format, Frame},
    id::Id,
    log::Log,
    node::{Entry, Node},
    settings::{Recovery, Settings, SettingsError, Stuffing},
    source::{NodeId, Releases},
    statistics::{Message, Statistics},
    time::{Rates, Time},
    transmission::Transmission,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::{
    cmp::Reverse,
    collections::{BTreeMap, BinaryHeap, HashMap},
};

/// A CAN bus with its nodes, their queues and their traffic.
#[derive(Debug, Clone)]
pub struct Bus {
    pub(super) rates: Rates,
    pub(super) stuffing: Stuffing,
    pub(super) recovery: Recovery,
    data_bit_rate: bool,
    pub(super) nodes: Vec<Node>,
    /// Nodes that are bus-off.
    pub(super) off: usize,
    pub(super) sending: Option<Transmission>,
    pub(super) now: Time,
    /// End of the last intermission.
    pub(super) free: Time,
    pub(super) sources: Vec<Releases>,
    pub(super) releases: BinaryHeap<Reverse<(Time, usize)>>,
    /// By time and order of the calls.
    offers: BTreeMap<(Time, u64), (NodeId, Entry)>,
    pub(super) arrivals: u64,
    owners: HashMap<Id, NodeId>,
    /// Rows of the statistics of what the caller offers.
    rows: HashMap<Id, usize>,
    pub(super) errors: ErrorProcess,
    pub(super) statistics: Statistics,
    pub(super) log: Option<Log>,
    pub(super) events: Vec<Event>,
}

/// What can happen next; of things at the same time, the first in this list does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Step {
    /// A frame ends, well or disturbed.
    Completion,
    /// A frame of the caller reaches its node.
    Offer,
    /// A source hands a frame to its node.
    Release,
    /// A node returns from bus-off.
    Recovery,
    /// A frame begins.
    Arbitration,
}

/// A frame that this bus cannot take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum OfferError {
    /// Earlier than the bus has run already.
    #[error("offered for {at} ns, but the bus has run to {now} ns: offer frames before running past them")]
    Past {
        /// Asked for, in nanoseconds.
        at: Time,
        /// Where the bus is, in nanoseconds.
        now: Time,
    },
    /// A node that does not exist.
    #[error("offered by node {}, but nodes are 0 to {}", node.0, nodes - 1)]
    NoSuchNode {
        /// The node.
        node: NodeId,
        /// How many there are.
        nodes: usize,
    },
    /// An identifier of another node: both could win the same arbitration.
    #[error("identifier {id} offered by node {}, but it belongs to node {}", node.0, owner.0)]
    ForeignIdentifier {
        /// Which.
        id: Id,
        /// Who offers it.
        node: NodeId,
        /// Whose it is.
        owner: NodeId,
    },
    /// A frame with a switch on a bus without a second bit rate.
    #[error("the frame switches the bit rate, but the bus has no data bit rate: send it without a switch")]
    NoDataBitRate,
}

impl Bus {
    /// An idle bus at time 0. Every source, and the errors, draw random numbers of their own from `random`: what one of
    /// them draws shifts no other.
    ///
    /// # Errors
    /// Settings with which no bus can run, two nodes with one identifier among them.
    pub fn new(settings: Settings, mut random: ChaCha8Rng) -> Result<Self, SettingsError> {
        let (rates, owners) = settings.check()?;
        let errors = ErrorProcess::new(settings.errors, ChaCha8Rng::from_rng(&mut random));
        let messages = settings.sources.iter().enumerate();
        let messages = messages.map(|(index, source)| Message::new(Some(index), source.id, source.node));
        let statistics =
            Statistics { time: 0, error_time: 0, error_frames: 0, bus_offs: 0, messages: messages.collect() };
        let mut releases = BinaryHeap::new();
        let mut sources = Vec::new();
        for (index, source) in settings.sources.into_iter().enumerate() {
            let (source, first) = Releases::new(source, ChaCha8Rng::from_rng(&mut random));
            releases.push(Reverse((first, index)));
            sources.push(source);
        }
        Ok(Bus {
            rates,
            stuffing: settings.stuffing,
            recovery: settings.recovery,
            data_bit_rate: settings.data_bit_rate.is_some(),
            nodes: vec![Node::new(settings.queue); usize::from(settings.nodes)],
            off: 0,
            sending: None,
            now: 0,
            free: 0,
            sources,
            releases,
            offers: BTreeMap::new(),
            arrivals: 0,
            owners,
            rows: HashMap::new(),
            errors,
            statistics,
            log: settings.log.then(Log::default),
            events: Vec::new(),
        })
    }

    /// Hands a frame to the queue of `node` at the time `at` (ns): it competes in every arbitration from then on, one
    /// that starts at `at` included. Events call it by `tag`; tags are the caller's and should be unique.
    ///
    /// # Errors
    /// A time the bus has run past, a node that does not exist, an identifier of another node, a bit rate switch on a
    /// bus without a data bit rate.
    pub fn offer(&mut self, at: Time, node: NodeId, frame: Frame, tag: u64) -> Result<(), OfferError> {
        if at < self.now {
            return Err(OfferError::Past { at, now: self.now });
        }
        if usize::from(node.0) >= self.nodes.len() {
            return Err(OfferError::NoSuchNode { node, nodes: self.nodes.len() });
        }
        if !self.data_bit_rate && frame.format() == (Format::Fd { bit_rate_switch: true }) {
            return Err(OfferError::NoDataBitRate);
        }
        let id = frame.id();
        let owner = *self.owners.entry(id).or_insert(node);
        if owner != node {
            return Err(OfferError::ForeignIdentifier { id, node, owner });
        }
        let messages = &mut self.statistics.messages;
        let row = *self.rows.entry(id).or_insert_with(|| {
            messages.push(Message::new(None, id, node));
            messages.len() - 1
        });
        let entry = self.entry(&frame, Origin::Offered(tag), row, at);
        self.offers.insert((at, entry.urgency.1), (node, entry));
        Ok(())
    }

    /// Takes a frame back that still waits in its queue, or that was offered for later. True if so: its fate is then
    /// [`Fate::Withdrawn`], decided now, and no event tells of it. A frame that is on the bus stays. A frame that was
    /// delivered and waits for its repetition is not sent again, but stays delivered: false.
    pub fn withdraw(&mut self, tag: u64) -> bool {
        let origin = Origin::Offered(tag);
        let waiting = self.nodes.iter_mut().find_map(|node| node.remove(origin));
        let later = |offers: &mut BTreeMap<_, (NodeId, Entry)>| {
            let key = *offers.iter().find(|(_, (_, entry))| entry.origin == origin)?.0;
            offers.remove(&key).map(|(_, entry)| entry)
        };
        let entry = match waiting {
            Some(entry) => entry,
            None => match later(&mut self.offers) {
                Some(entry) => {
                    self.statistics.messages[entry.row].offered += 1;
                    entry
                }
                None => return false,
            },
        };
        if entry.delivered {
            return false;
        }
        self.record(&entry, Fate::Withdrawn);
        true
    }

    /// Runs the bus to the time `until` (ns) and returns what happened, in order of time.
    ///
    /// Frames that end at `until` have ended; an arbitration that would start at `until` is still open, so that frames
    /// offered for this very time take part in it. A time that has passed already does nothing.
    pub fn run_until(&mut self, until: Time) -> Vec<Event> {
        while let Some((at, step)) = self.next_step() {
            if at > until || at == until && step == Step::Arbitration {
                break;
            }
            self.now = at;
            match step {
                Step::Completion => self.complete(),
                Step::Offer => {
                    if let Some((_, (node, entry))) = self.offers.pop_first() {
                        self.arrive(node, entry);
                    }
                }
                Step::Release => self.release(),
                Step::Recovery => self.recover(),
                Step::Arbitration => self.arbitrate(),
            }
        }
        self.now = self.now.max(until);
        std::mem::take(&mut self.events)
    }

    /// How far the bus has run, in nanoseconds.
    pub fn now(&self) -> Time {
        self.now
    }

    /// How long bits last.
    pub fn rates(&self) -> Rates {
        self.rates
    }

    /// Figures so far.
    pub fn statistics(&self) -> Statistics {
        Statistics { time: self.now, ..self.statistics.clone() }
    }

    /// All frames whose fates are decided; none unless the settings ask for a log.
    pub fn log(&self) -> Option<&Log> {
        self.log.as_ref()
    }

    fn next_step(&self) -> Option<(Time, Step)> {
        let completion = self.sending.as_ref().map(|frame| (frame.end, Step::Completion));
        let offer = self.offers.first_key_value().map(|(&(at, _), _)| (at, Step::Offer));
        let release = self.releases.peek().map(|&Reverse((at, _))| (at, Step::Release));
        let recovery = self.next_recovery().map(|at| (at, Step::Recovery));
        let arbitration = self.next_arbitration().map(|at| (at, Step::Arbitration));
        [completion, offer, release, recovery, arbitration].into_iter().flatten().min()
    }
}
