//! What a controller may know when it decides, and every way in which the packets in flight may still arrive.
//!
//! It shares no formula with the core: a packet's delay is conditioned on the acknowledged age by leaving out the delays
//! that contradict it, and what is played is an actuator's doing.

use crate::lent;
use proptest::prelude::*;
use slqg::actuator::{Actuator, Settings};
use slqg::gains::{Gains, Tables};
use slqg::in_flight::InFlight;
use slqg::nalgebra::SVector;
use slqg::played::Played;
use slqg::{Age, DefaultInput, Tick, arrival, sequence::ControlSequence};

/// The longest sequence.
pub(crate) const CAPACITY: usize = 5;

/// The cycle in which the controller decides.
pub(crate) const NOW: Tick = Tick(2);

/// One way for packets to arrive: its probability, and the delay of each packet that does, by age.
pub(crate) type Way = (f64, Vec<(usize, usize)>);

/// What is known at the beginning of cycle `NOW`.
#[derive(Debug, Clone)]
pub(crate) struct Situation {
    pub(crate) length: usize,
    pub(crate) default_input: DefaultInput,
    /// Probability of each delay.
    pub(crate) delays: Vec<f64>,
    pub(crate) loss: f64,
    /// Whether a packet was sent `1 + index` cycles ago.
    pub(crate) sent: Vec<bool>,
    /// Age acknowledged for the cycle before.
    pub(crate) age: Age,
    /// Entry by entry; packets of different ages have nothing in common.
    pub(crate) numbers: Vec<f64>,
}

impl Situation {
    /// The inputs of the packet sent `b >= 1` cycles ago.
    pub(crate) fn packet<const NU: usize>(&self, b: usize) -> Vec<SVector<f64, NU>> {
        let number = |entry: usize, row: usize| self.numbers[(b * CAPACITY + entry) * 2 + row];
        (0..self.length).map(|entry| SVector::from_fn(|row, _| number(entry, row))).collect()
    }

    /// Offers the packet sent `b >= 1` cycles ago to `actuator`, which refuses run out and past ones.
    pub(crate) fn arrives<const NU: usize>(&self, b: usize, actuator: &mut Actuator<'_, f64, NU>) -> bool {
        let inputs = self.packet(b);
        actuator.offer(&ControlSequence { tick: NOW - b as u32, inputs: &inputs }).is_ok()
    }

    /// The actuator at the beginning of `NOW`, and what it played in the cycle before.
    pub(crate) fn actuator<const NU: usize>(&self) -> (Actuator<'static, f64, NU>, SVector<f64, NU>) {
        let settings = Settings { default_input: self.default_input, limits: None, safe: None };
        let mut actuator = lent::actuator(settings, NOW - 2, CAPACITY);
        if self.age == Age::Empty {
            // Its last input is for the cycle before the last: the default input follows it. It is older than
            // any packet that may still be of use.
            let inputs: Vec<_> = (0..CAPACITY).map(|entry| SVector::repeat(self.numbers[entry])).collect();
            let before = ControlSequence { tick: NOW - 1 - CAPACITY as u32, inputs: &inputs };
            actuator.offer(&before).expect("it has an input left");
        }
        actuator.step();
        if let Some(steps) = self.age.steps() {
            assert!(self.arrives(steps + 1, &mut actuator), "acknowledged");
        }
        let played = actuator.step();
        assert_eq!(played.age, self.age);
        (actuator, played.input)
    }

    /// Every delay that packet `b` may have, with its probability, given that it had not arrived in the cycle
    /// before `NOW`; `None` is loss. Empty if it must have arrived by then.
    pub(crate) fn delays_under_way(&self, b: usize) -> Vec<(Option<usize>, f64)> {
        let mut possible: Vec<_> =
            self.delays.iter().enumerate().map(|(d, p)| (Some(d), *p)).skip(b).collect();
        possible.push((None, self.loss));
        possible.retain(|(_, p)| *p > 0.0);
        let total: f64 = possible.iter().map(|(_, p)| p).sum();
        possible.iter().map(|(delay, p)| (*delay, p / total)).collect()
    }

    /// Packets that are under way: sent after the one acknowledged, and of use if they arrive.
    pub(crate) fn under_way(&self) -> Vec<usize> {
        let newest_unknown = self.age.steps().unwrap_or(self.length).min(self.length - 1);
        (1..=newest_unknown).filter(|b| self.sent[b - 1]).collect()
    }

    /// Whether the acknowledged age can have come about.
    fn possible(&self) -> bool {
        let arrived: f64 = self.age.steps().map_or(1.0, |steps| self.delays.iter().take(steps + 1).sum());
        let newer = self.age.steps().unwrap_or(self.length);
        let not_arrived = |b: usize| !self.sent[b - 1] || !self.delays_under_way(b).is_empty();
        arrived > 0.0 && (1..=newer).all(not_arrived)
    }

    /// Every way in which `packets` may arrive, given that they had not in the cycle before.
    pub(crate) fn ways(&self, packets: &[usize]) -> Vec<Way> {
        let mut ways = vec![(1.0, vec![])];
        for &b in packets {
            let delays = self.delays_under_way(b);
            let one_way = |(so_far, known): &Way| {
                let (so_far, known) = (*so_far, known.clone());
                let next = |&(delay, p): &(Option<usize>, f64)| {
                    (so_far * p, known.iter().copied().chain(delay.map(|delay| (b, delay))).collect())
                };
                delays.iter().map(next).collect::<Vec<_>>()
            };
            ways = ways.iter().flat_map(one_way).collect();
        }
        ways
    }

    /// `g(0..N-1)`.
    pub(crate) fn survival(&self) -> Vec<f64> {
        let mut survival = vec![0.0; self.length];
        arrival::survival(&self.delays, self.loss, &mut survival);
        survival
    }

    /// Calls `look` with the law `gains` (`[Lx M]`, by rows), which knows the link, with what was sent, and with what was
    /// played in the last cycle.
    pub(crate) fn with_law<const NX: usize, const NU: usize, Out>(
        &self,
        gains: &[f64],
        look: impl FnOnce(&Gains<'_, f64, NX, NU>, &InFlight<'_, f64, NU>, Played<'static, f64, NU>) -> Out,
    ) -> Out {
        let mut table = vec![0.0; arrival::table_len(self.length)];
        arrival::fill_table(&self.survival(), &mut table);
        let rows = || gains.chunks(NX + self.default_input.in_flight(self.length) * NU);
        let lx: Vec<f64> = rows().flat_map(|row| &row[..NX]).copied().collect();
        let m: Vec<f64> = rows().flat_map(|row| &row[NX..]).copied().collect();
        let tables = Tables::check(&lx, &m, &table).expect("finite, and probabilities");
        let gains = Gains::<f64, NX, NU>::check(self.length, self.default_input, tables).expect("valid");
        let mut in_flight = lent::in_flight(self.length, CAPACITY, NOW - CAPACITY as u32);
        for b in (1..=CAPACITY).rev() {
            in_flight.candidate().copy_from_slice(&self.packet(b));
            in_flight.push(self.sent[b - 1]);
        }
        look(&gains, &in_flight, Played::Known(self.age, self.actuator().1))
    }
}

/// Situations with sequences of up to `longest` inputs.
pub(crate) fn situations(longest: usize) -> impl Strategy<Value = Situation> {
    // Weights, many of them zero: delays that never occur, also at the beginning and at the end.
    let weight = || prop_oneof![1 => Just(0u32), 2 => 1u32..100];
    let link = (proptest::collection::vec(weight(), 1..8), weight());
    let sent = proptest::collection::vec(proptest::bool::weighted(0.8), CAPACITY);
    let numbers = proptest::collection::vec(-1.0..1.0, (CAPACITY + 1) * CAPACITY * 2);
    (1..=longest, any::<bool>(), link, sent, 0..=CAPACITY, numbers)
        .prop_map(|(length, hold, (weights, loss), mut sent, age, numbers)| {
            let total = f64::from(weights.iter().sum::<u32>() + loss).max(1.0);
            let age = if age < length { Age::Steps(age as u8) } else { Age::Empty };
            if let Some(steps) = age.steps() {
                sent[steps] = true;
            }
            Situation {
                length,
                default_input: if hold { DefaultInput::Hold } else { DefaultInput::Zero },
                delays: weights.iter().map(|weight| f64::from(*weight) / total).collect(),
                loss: f64::from(loss) / total,
                sent,
                age,
                numbers,
            }
        })
        .prop_filter("an age that cannot have come about", Situation::possible)
}
