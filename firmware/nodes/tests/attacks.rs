//! Which attacks a node takes, plain and sealed: the table of `docs/safety.md`.

use slqg::actuator::Settings;
use slqg::authentication::{
    AlarmSettings, Association, Guard, Identity, Key, Keys, Nonces, Opened, Session, Side,
};
use slqg::blob::{DesignId, Shape, encode, encoded_len};
use slqg::gains::Tables;
use slqg::nalgebra::SVector;
use slqg::sequence::ControlSequence;
use slqg::wire::{self, Acknowledgement, Clock, GainsPart, Kind, Measurement};
use slqg::{Age, Tick};
use slqg_nodes::board::Node;
use slqg_nodes::design::{
    ACTUATOR, ACTUATOR_MEMORY, INPUTS, Memory, OUTPUTS, SEQUENCE_LENGTH, STATES, Scalar,
};
use slqg_nodes::dimensions::DESIGN_ID;
use slqg_nodes::guarded::{Guarded, Vault};
use slqg_nodes::laws::{BANK_MEMORY, LARGEST_PART, Sent};
use slqg_nodes::{actuator, controller};
use std::num::NonZeroU64;

mod desk;
use desk::{BYTES, Desk, STEPPED};

const PAGE: &str = include_str!("../../../docs/safety.md");
/// The cycle in which attacks begin.
const BEGIN: u32 = 20;
const IDENTITY: Identity = Identity { loop_id: 1, design: DESIGN_ID };

struct Counter(u64);

impl Nonces for Counter {
    fn next(&mut self) -> NonZeroU64 {
        self.0 += 1;
        NonZeroU64::MIN.saturating_add(self.0)
    }
}

impl Vault for Counter {
    fn gains_version(&self) -> u32 {
        0
    }

    fn keep_gains_version(&mut self, _version: u32) {}
}

fn session(identity: Identity, association: Association, side: Side, key: u8) -> Session {
    let key = |of: u8| Key::new([key + 16 * association as u8 + of; 16]);
    Session::new(association, side, identity, Keys { downstream: key(0), upstream: key(1) })
}

/// Who speaks with a node.
fn peer(identity: Identity, role: Role, key: u8) -> Guard<4> {
    let of_loop = if role == Role::Controller { Side::Downstream } else { Side::Upstream };
    Guard::new(
        [
            session(identity, Association::Timing, Side::Upstream, key),
            session(identity, Association::Sensing, Side::Upstream, key),
            session(identity, Association::Service, Side::Upstream, key),
            session(identity, Association::Loop, of_loop, key),
        ],
        AlarmSettings::default(),
    )
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Controller,
    Actuator,
}

/// A node on a desk, who speaks with it, and all that has been said to it.
struct Station<N> {
    node: N,
    role: Role,
    desk: Desk,
    peer: Option<Guard<4>>,
    nonces: Counter,
    tick: u32,
    /// Whether acknowledgements of who is entitled arrive.
    is_acknowledged: bool,
    recording: Vec<Vec<u8>>,
    /// What it did: the plain frames that it has sent.
    done: Vec<Vec<u8>>,
}

impl<N: Node> Station<N> {
    fn new(node: N, role: Role, peer: Option<Guard<4>>) -> Self {
        let (desk, nonces) = (Desk::default(), Counter(1 << 40));
        let mut station = Self {
            node,
            role,
            desk,
            peer,
            nonces,
            tick: 0,
            is_acknowledged: true,
            recording: Vec::new(),
            done: Vec::new(),
        };
        station.node.start(&mut station.desk);
        station.settle();
        station
    }

    /// Sorts what the node has sent, and says hello back.
    fn settle(&mut self) {
        for _ in 0..8 {
            for bytes in std::mem::take(&mut self.desk.sent) {
                match (bytes[0], &mut self.peer) {
                    (slqg::authentication::SEALED, _) => self.done.push(bytes[9..].to_vec()),
                    (slqg::authentication::HELLO, Some(peer)) => {
                        if let Ok(Opened::Hello(Some(answer))) = peer.open(&bytes, &mut self.nonces) {
                            self.hear(&answer);
                        }
                    }
                    (slqg::authentication::HELLO, None) => {}
                    _ => self.done.push(bytes),
                }
            }
            let Some(peer) = &mut self.peer else { return };
            if let Some(hello) = peer.due(&mut self.nonces) {
                self.hear(&hello);
            }
        }
    }

    /// Bytes on the line, whoever sends them.
    fn hear(&mut self, bytes: &[u8]) {
        self.recording.push(bytes.to_vec());
        self.node.take(bytes, &mut self.desk);
    }

    /// A frame of who is entitled to send it.
    fn give(&mut self, frame: &[u8]) {
        let mut buffer = [0; 256];
        let bytes = match &mut self.peer {
            None => Some(frame),
            Some(peer) => peer.seal(frame, &mut buffer).ok(),
        };
        if let Some(bytes) = bytes {
            self.hear(bytes);
        }
        self.settle();
    }

    /// A frame of an attacker, who knows everything but the keys.
    fn forge(&mut self, frame: &[u8]) {
        if self.peer.is_none() {
            self.hear(frame);
        } else {
            for tag in 0..64_u8 {
                self.hear(&[&[slqg::authentication::SEALED; 1][..], &[tag; 8], frame].concat());
            }
            self.hear(frame);
        }
        self.settle();
    }

    /// A cycle of the undisturbed loop.
    fn cycle(&mut self) {
        self.cycle_with(|_| ());
    }

    /// A cycle in which something happens between its begin and its frames.
    fn cycle_with(&mut self, between: impl FnOnce(&mut Self)) {
        self.give(&clock(self.tick));
        between(self);
        let tick = Tick(self.tick);
        match self.role {
            Role::Controller => {
                self.give(&measurement(tick + 1, 0.01));
                if self.is_acknowledged {
                    self.give(&acknowledgement(tick, Age::Steps(0)));
                }
            }
            Role::Actuator => self.give(&control(tick + 1, 1.0)),
        }
        self.tick = self.tick.wrapping_add(1);
        if let Some(peer) = &mut self.peer {
            peer.cycle();
        }
        self.settle();
    }
}

fn encoded(len: usize, encode: impl FnOnce(&mut [u8]) -> usize) -> Vec<u8> {
    let mut buffer = vec![0; len];
    let len = encode(&mut buffer);
    buffer.truncate(len);
    buffer
}

fn measurement(tick: Tick, value: Scalar) -> Vec<u8> {
    let output = SVector::<Scalar, OUTPUTS>::repeat(value);
    encoded(256, |buffer| {
        wire::encode_measurement(&Measurement { tick, output }, buffer).expect("room").len()
    })
}

fn control(tick: Tick, value: Scalar) -> Vec<u8> {
    let inputs = [SVector::<Scalar, INPUTS>::repeat(value); SEQUENCE_LENGTH];
    let sequence = ControlSequence { tick, inputs: &inputs };
    encoded(256, |buffer| wire::encode_control(&sequence, buffer).expect("room").len())
}

fn acknowledgement(tick: Tick, age: Age) -> Vec<u8> {
    let told = Acknowledgement::of(tick, age);
    encoded(64, |buffer| wire::encode_acknowledgement::<Scalar>(&told, buffer).expect("room").len())
}

fn clock(tick: u32) -> Vec<u8> {
    let clock: Clock = STEPPED;
    encoded(64, |buffer| wire::encode_service::<Scalar, _>(Tick(tick), &clock, buffer).expect("room").len())
}

/// All parts of a blob of another law for the node's plant.
fn gains(transfer: u32) -> Vec<Vec<u8>> {
    let Settings { default_input, .. } = ACTUATOR;
    let shape = Shape { length: SEQUENCE_LENGTH, states: STATES, inputs: INPUTS, default_input };
    let rows = SEQUENCE_LENGTH * INPUTS;
    let (lx, m) =
        (vec![-1.0; rows * STATES], vec![0.0; rows * default_input.in_flight(SEQUENCE_LENGTH) * INPUTS]);
    let arrival = vec![0.5; SEQUENCE_LENGTH * (SEQUENCE_LENGTH - 1) / 2];
    let mut buffer = vec![0; encoded_len(&shape, BYTES)];
    let tables = Tables::check(&lx, &m, &arrival).expect("numbers");
    let blob = encode::<Scalar>(DESIGN_ID, &shape, &tables, &mut buffer).expect("gains");
    let total = blob.len() as u16;
    let parts = blob.chunks(LARGEST_PART).zip((0..).step_by(LARGEST_PART));
    parts
        .map(|(bytes, offset)| {
            let part = GainsPart { transfer, offset, total, bytes };
            encoded(128, |buffer| wire::encode_gains_part::<Scalar>(&part, buffer).expect("room").len())
        })
        .collect()
}

/// What an attacker does in cycle [`BEGIN`], between its begin and the frames of who is entitled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Attack {
    ForgedControl,
    NextControl,
    ForgedMeasurement,
    ForgedAcknowledgement,
    ForgedClock,
    ForgedGains,
    RepeatedControl,
    RepeatedClock,
    WrappedControl,
    Recording,
    OtherLoop,
    OtherPlant,
    Damaged,
    Late,
}

/// The rows of the table.
const ATTACKS: [(Attack, Role, &str); 14] = [
    (Attack::ForgedControl, Role::Actuator, "a control frame, forged"),
    (Attack::NextControl, Role::Actuator, "a control frame of the next cycle, forged and sent early"),
    (Attack::ForgedMeasurement, Role::Controller, "a measurement, forged"),
    (Attack::ForgedAcknowledgement, Role::Controller, "an acknowledgement, forged"),
    (Attack::ForgedClock, Role::Actuator, "twenty clock frames of a far cycle, forged"),
    (Attack::ForgedGains, Role::Controller, "gains, forged"),
    (Attack::RepeatedControl, Role::Actuator, "a control frame, repeated in its session"),
    (Attack::RepeatedClock, Role::Actuator, "all clock frames so far, repeated in their session"),
    (Attack::WrappedControl, Role::Actuator, "a control frame, held back for 2^32 cycles"),
    (Attack::Recording, Role::Actuator, "a whole session, recorded and played to the node after a restart"),
    (Attack::OtherLoop, Role::Actuator, "a control frame of another loop of the same plant and keys"),
    (Attack::OtherPlant, Role::Actuator, "a control frame of another plant's controller with the same keys"),
    (Attack::Damaged, Role::Actuator, "a control frame with a bit changed on the way"),
    (Attack::Late, Role::Actuator, "a control frame, held back until it has run out"),
];

impl Attack {
    fn run<N: Node>(self, station: &mut Station<N>, held_back: &[u8]) {
        let (now, tick) = (Tick(station.tick + 1), station.tick);
        match self {
            Self::ForgedControl => station.forge(&control(now, 9.0)),
            Self::NextControl => station.forge(&control(now + 1, 9.0)),
            Self::ForgedMeasurement => station.forge(&measurement(now, 5.0)),
            Self::ForgedAcknowledgement => station.forge(&acknowledgement(Tick(tick), Age::Empty)),
            Self::ForgedClock => (0..20).for_each(|ahead| station.forge(&clock(100_000 + ahead))),
            Self::ForgedGains => gains(9).iter().for_each(|part| station.forge(part)),
            Self::RepeatedControl | Self::RepeatedClock => {
                let kind = if self == Self::RepeatedControl { Kind::Control } else { Kind::Clock };
                for bytes in station.recording.clone() {
                    if [Some(&bytes[..]), bytes.get(9..)]
                        .into_iter()
                        .flatten()
                        .any(|frame| Kind::of(frame) == Some(kind))
                    {
                        station.hear(&bytes);
                    }
                }
                station.settle();
            }
            Self::WrappedControl | Self::Late => station.hear(held_back),
            Self::OtherLoop => station.foreign(Identity { loop_id: 2, ..IDENTITY }),
            Self::OtherPlant => station.foreign(Identity { design: DesignId(!DESIGN_ID.0), ..IDENTITY }),
            Self::Damaged => {
                let mut bytes = held_back.to_vec();
                let place = bytes.len() - 8;
                bytes[place] ^= 0x10;
                station.hear(&bytes);
            }
            Self::Recording => unreachable!("it is played to another node"),
        }
    }
}

impl<N: Node> Station<N> {
    /// A frame as who is entitled would send it.
    fn sealed(&mut self, frame: &[u8]) -> Vec<u8> {
        let mut buffer = [0; 256];
        match &mut self.peer {
            None => frame.to_vec(),
            Some(peer) => peer.seal(frame, &mut buffer).expect("there is a session").to_vec(),
        }
    }

    /// A control frame of a controller that has the keys, in a session with its own actuator.
    fn foreign(&mut self, identity: Identity) {
        let frame = control(Tick(self.tick + 1), 9.0);
        if self.peer.is_none() {
            return self.hear(&frame);
        }
        let of = |side| Guard::new([session(identity, Association::Loop, side, 0)], AlarmSettings::default());
        let (mut controller, mut actuator) = (of(Side::Upstream), of(Side::Downstream));
        let mut nonces = [Counter(7 << 40), Counter(8 << 40)];
        let mut hello = controller.due(&mut nonces[0]);
        while let Some(bytes) = hello {
            self.hear(&bytes);
            let Ok(Opened::Hello(Some(answer))) = actuator.open(&bytes, &mut nonces[1]) else { break };
            let Ok(Opened::Hello(next)) = controller.open(&answer, &mut nonces[0]) else { break };
            hello = next;
        }
        let mut buffer = [0; 256];
        let bytes = controller.seal(&frame, &mut buffer).expect("it has a session").to_vec();
        self.hear(&bytes);
        self.settle();
    }
}

/// Whether the attack has changed anything that the node does in the next cycles. `station` makes one, started for the n-th time.
fn is_taken<N: Node>(attack: Attack, station: impl Fn(u64) -> Station<N>) -> bool {
    if attack == Attack::Recording {
        let mut first = station(1);
        (0..BEGIN).for_each(|_| first.cycle());
        let mut second = station(2);
        second.peer = None;
        first.recording.iter().for_each(|bytes| second.hear(bytes));
        second.settle();
        return second.done.iter().any(|frame| Kind::of(frame) == Some(Kind::Applied));
    }
    let [left, attacked] = [false, true].map(|is_attacked| {
        let mut station = station(1);
        (0..BEGIN).for_each(|_| station.cycle());
        assert!(station.done.iter().any(|frame| Kind::of(frame) != Some(Kind::Status)), "the node works");
        let mut held_back = Vec::new();
        if [Attack::WrappedControl, Attack::Late, Attack::Damaged].contains(&attack) {
            held_back = station.sealed(&control(Tick(station.tick + 1), 9.0));
        }
        if [Attack::WrappedControl, Attack::Late].contains(&attack) {
            (0..2 * SEQUENCE_LENGTH).for_each(|_| station.cycle());
        }
        if attack == Attack::WrappedControl {
            for _ in 0..15 {
                station.tick = station.tick.wrapping_add(1 << 28);
                // Long enough for a session to be renewed.
                (0..40).for_each(|_| station.cycle());
            }
            station.tick = BEGIN.wrapping_sub(40);
            (0..40).for_each(|_| station.cycle());
        }
        station.done.clear();
        station.is_acknowledged = attack != Attack::ForgedAcknowledgement;
        station.cycle_with(|station| {
            if is_attacked {
                attack.run(station, &held_back);
            }
        });
        (0..5).for_each(|_| station.cycle());
        assert!(!station.done.is_empty(), "the node goes on");
        // Answers to what was asked drive nothing.
        station.done.retain(|frame| {
            matches!(Kind::of(frame), Some(Kind::Control | Kind::Applied | Kind::Acknowledgement))
        });
        station.done
    });
    left != attacked
}

fn controller() -> controller::Node<'static, impl slqg_nodes::laws::Laws> {
    let (memory, bank) = (Box::leak(Box::new(Memory::new())), Box::leak(Box::new([0.0; BANK_MEMORY])));
    controller::Node::new(memory, Box::leak(Box::new(Sent::new(bank))))
}

fn actuator() -> actuator::Node<'static> {
    actuator::Node::new(Box::leak(Box::new(ACTUATOR_MEMORY)))
}

fn guard<const S: usize>(of: [(Association, Side); S]) -> &'static mut Guard<S> {
    let sessions = of.map(|(association, side)| session(IDENTITY, association, side, 0));
    Box::leak(Box::new(Guard::new(sessions, AlarmSettings::default())))
}

fn is_taken_by(attack: Attack, role: Role, is_sealed: bool) -> bool {
    let nonces = |start: u64| Counter(start << 32);
    let (down, up) = (Side::Downstream, Side::Upstream);
    match (role, is_sealed) {
        (Role::Controller, false) => is_taken(attack, |_| Station::new(controller(), role, None)),
        (Role::Actuator, false) => is_taken(attack, |_| Station::new(actuator(), role, None)),
        (Role::Controller, true) => is_taken(attack, |start| {
            let of = [Association::Timing, Association::Sensing, Association::Service].map(|of| (of, down));
            let [timing, sensing, service] = of;
            let guard = guard([timing, sensing, service, (Association::Loop, up)]);
            Station::new(
                Guarded::new(controller(), guard, nonces(start)),
                role,
                Some(peer(IDENTITY, role, 0)),
            )
        }),
        (Role::Actuator, true) => is_taken(attack, |start| {
            let guard = guard([Association::Timing, Association::Loop].map(|of| (of, down)));
            Station::new(Guarded::new(actuator(), guard, nonces(start)), role, Some(peer(IDENTITY, role, 0)))
        }),
    }
}

#[test]
fn attacks_are_taken_and_refused_as_the_safety_page_says_and_none_is_taken_by_a_sealed_node() {
    let mut wrong = Vec::new();
    for (attack, role, what) in ATTACKS {
        let told = |is_sealed| if is_taken_by(attack, role, is_sealed) { "taken" } else { "changes nothing" };
        let (plain, sealed) = (told(false), told(true));
        assert_eq!(sealed, "changes nothing", "{what}");
        let row = format!("| {what} | {plain} | {sealed} |");
        if !PAGE.contains(&row) {
            wrong.push(row);
        }
    }
    assert!(wrong.is_empty(), "docs/safety.md lacks:\n{}", wrong.join("\n"));
}

#[test]
fn a_sealed_node_does_what_the_plain_one_does() {
    let of_plain = {
        let mut station = Station::new(controller(), Role::Controller, None);
        (0..1000).for_each(|_| station.cycle());
        station.done
    };
    let guard = guard([
        (Association::Timing, Side::Downstream),
        (Association::Sensing, Side::Downstream),
        (Association::Service, Side::Downstream),
        (Association::Loop, Side::Upstream),
    ]);
    let node = Guarded::new(controller(), guard, Counter(0));
    let mut station = Station::new(node, Role::Controller, Some(peer(IDENTITY, Role::Controller, 0)));
    (0..1000).for_each(|_| station.cycle());
    assert_eq!(station.done, of_plain);
}
