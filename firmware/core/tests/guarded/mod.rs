//! Ends behind guards and what they say to each other; keys of the tests' own.
#![allow(dead_code)]

use core::num::NonZeroU64;
use slqg::authentication::{
    AlarmSettings, Association, Guard, Identity, Key, Keys, Nonces, Opened, Refused, Session, Side,
};
use slqg::blob::DesignId;
use slqg::nalgebra::SVector;
use slqg::sequence::ControlSequence;
use slqg::wire::{self, Acknowledgement, Clock, GainsPart, Measurement};
use slqg::{Age, Tick};

pub(crate) const IDENTITY: Identity = Identity { loop_id: 7, design: DesignId(0x1234_5678) };

/// Nonces by counting: each end counts from elsewhere.
pub(crate) struct Counter(pub(crate) u64);

impl Nonces for Counter {
    fn next(&mut self) -> NonZeroU64 {
        self.0 += 1;
        NonZeroU64::new(self.0).expect("far from the end")
    }
}

/// Keys whose bytes are all `first`, or one more.
pub(crate) fn keys(first: u8) -> Keys {
    Keys { downstream: Key::new([first; 16]), upstream: Key::new([first + 1; 16]) }
}

/// One end of an association, with the key of the loop.
pub(crate) fn end(association: Association, side: Side) -> Guard<1> {
    end_of(IDENTITY, keys(10 * association as u8), association, side)
}

pub(crate) fn end_of(identity: Identity, keys: Keys, association: Association, side: Side) -> Guard<1> {
    Guard::new([Session::new(association, side, identity, keys)], AlarmSettings::default())
}

/// Two ends and what goes between them, all of it on record.
pub(crate) struct Pair {
    pub(crate) upstream: Guard<1>,
    pub(crate) downstream: Guard<1>,
    pub(crate) nonces: [Counter; 2],
    /// Everything that was sent, with the side that has sent it.
    pub(crate) record: Vec<(Side, Vec<u8>)>,
}

impl Pair {
    pub(crate) fn new(association: Association) -> Self {
        Self {
            upstream: end(association, Side::Upstream),
            downstream: end(association, Side::Downstream),
            nonces: [Counter(1000), Counter(2000)],
            record: Vec::new(),
        }
    }

    /// Two ends that agree on a session.
    pub(crate) fn standing(association: Association) -> Self {
        let mut pair = Self::new(association);
        pair.shake();
        assert!(pair.upstream.stands() && pair.downstream.stands());
        pair
    }

    /// Hellos that are due, and what comes of them, until nobody has anything to say.
    pub(crate) fn shake(&mut self) {
        let mut under_way: Vec<_> = self.due().into_iter().collect();
        while let Some((sender, hello)) = under_way.pop() {
            self.record.push((sender, hello.clone()));
            if let Ok(Opened::Hello(Some(answer))) = self.give(sender, &hello) {
                under_way.push((sender.other(), answer.to_vec()));
            }
        }
    }

    pub(crate) fn due(&mut self) -> Vec<(Side, Vec<u8>)> {
        let mut due = Vec::new();
        while let Some(hello) = self.upstream.due(&mut self.nonces[0]) {
            due.push((Side::Upstream, hello.to_vec()));
        }
        while let Some(hello) = self.downstream.due(&mut self.nonces[1]) {
            due.push((Side::Downstream, hello.to_vec()));
        }
        due
    }

    /// Hands bytes that come from `sender`, or seem to, to the other side.
    pub(crate) fn give<'f>(&mut self, sender: Side, bytes: &'f [u8]) -> Result<Opened<'f>, Refused> {
        match sender {
            Side::Upstream => self.downstream.open(bytes, &mut self.nonces[1]),
            Side::Downstream => self.upstream.open(bytes, &mut self.nonces[0]),
        }
    }

    /// A frame, sealed by `sender`, on record.
    pub(crate) fn seal(&mut self, sender: Side, frame: &[u8]) -> Vec<u8> {
        let mut buffer = [0; 128];
        let guard = match sender {
            Side::Upstream => &mut self.upstream,
            Side::Downstream => &mut self.downstream,
        };
        let sealed = guard.seal(frame, &mut buffer).expect("it can be sealed").to_vec();
        self.record.push((sender, sealed.clone()));
        sealed
    }
}

/// A frame of each kind that is sealed, of cycle `tick`, and who sends it.
pub(crate) fn frames(tick: u32) -> [(&'static str, Association, Side, Vec<u8>); 6] {
    let tick = Tick(tick);
    let (up, down) = (Side::Upstream, Side::Downstream);
    [
        ("measurement", Association::Sensing, up, measurement(tick, 1.0)),
        ("control", Association::Loop, up, control(tick, 2.0)),
        ("acknowledgement", Association::Loop, down, acknowledgement(tick)),
        ("clock", Association::Timing, up, clock(tick, true)),
        ("gains", Association::Service, up, gains(tick.0, 0)),
        ("reference", Association::Service, up, reference(tick)),
    ]
}

pub(crate) fn measurement(tick: Tick, value: f32) -> Vec<u8> {
    let mut buffer = [0; 64];
    let output = SVector::from([value, -value]);
    wire::encode_measurement(&Measurement { tick, output }, &mut buffer).expect("there is room").to_vec()
}

pub(crate) fn control(tick: Tick, value: f32) -> Vec<u8> {
    let mut buffer = [0; 64];
    let inputs = [value, 0.5, 0.25].map(|input| SVector::from([input]));
    wire::encode_control(&ControlSequence { tick, inputs: &inputs }, &mut buffer)
        .expect("there is room")
        .to_vec()
}

pub(crate) fn acknowledgement(tick: Tick) -> Vec<u8> {
    let mut buffer = [0; 64];
    let told = Acknowledgement::of(tick, Age::Steps(0));
    wire::encode_acknowledgement::<f32>(&told, &mut buffer).expect("there is room").to_vec()
}

pub(crate) fn clock(tick: Tick, begins: bool) -> Vec<u8> {
    let mut buffer = [0; 64];
    let clock = Clock { begins, period_us: 20_000 };
    wire::encode_service::<f32, _>(tick, &clock, &mut buffer).expect("there is room").to_vec()
}

pub(crate) fn gains(transfer: u32, offset: u16) -> Vec<u8> {
    let mut buffer = [0; 64];
    let part = GainsPart { transfer, offset, total: 8, bytes: &[1, 2, 3, 4] };
    wire::encode_gains_part::<f32>(&part, &mut buffer).expect("there is room").to_vec()
}

pub(crate) fn reference(tick: Tick) -> Vec<u8> {
    let mut buffer = [0; 64];
    let mut samples = slqg::wire::Reference::<f32, 1, 2> { tick, samples: Default::default() };
    samples.samples.push(SVector::from([1.0])).expect("there is room");
    wire::encode_reference(&samples, &mut buffer).expect("there is room").to_vec()
}
