//! The expected inputs are expectations: over every way the packets in flight may still arrive.
//!
//! The comparison enumerates those ways and plays each through an actuator. It shares no formula with the
//! core: a packet's delay is conditioned on the acknowledged age by leaving out the delays that contradict it.

use nalgebra::SVector;
use proptest::prelude::*;
use slqg::actuator::{Actuator, Age, Settings};
use slqg::gains::{Gains, Tables};
use slqg::in_flight::InFlight;
use slqg::{DefaultInput, Tick, arrival, nalgebra, sequence::ControlSequence};

const CAPACITY: usize = 5;
type Sequence<const NU: usize> = ControlSequence<f64, NU, CAPACITY>;

/// The cycle in which the controller decides.
const NOW: Tick = Tick(2);

/// What is known at the beginning of cycle `NOW`.
#[derive(Debug, Clone)]
struct Situation {
    length: usize,
    default_input: DefaultInput,
    /// Probability of each delay.
    delays: Vec<f64>,
    loss: f64,
    /// Whether a packet was sent `1 + index` cycles ago.
    sent: Vec<bool>,
    /// Age acknowledged for the cycle before.
    age: Age,
    /// Entry by entry; packets of different ages have nothing in common.
    numbers: Vec<f64>,
}

impl Situation {
    /// The packet sent `b >= 1` cycles ago.
    fn packet<const NU: usize>(&self, b: usize) -> Sequence<NU> {
        let number = |entry: usize, row: usize| self.numbers[(b * CAPACITY + entry) * 2 + row];
        let inputs = (0..self.length).map(|entry| SVector::from_fn(|row, _| number(entry, row))).collect();
        Sequence { tick: NOW - b as u32, inputs }
    }

    fn settings<const NU: usize>(&self) -> Settings<f64, NU> {
        Settings { default_input: self.default_input, limits: None }
    }

    /// The actuator at the beginning of `NOW`, and what it played in the cycle before.
    fn actuator<const NU: usize>(&self) -> (Actuator<f64, NU, CAPACITY>, SVector<f64, NU>) {
        let mut actuator = Actuator::new(self.settings(), NOW - 2);
        if self.age == Age::Empty {
            // Its last input is for the cycle before the last: the default input follows it. It is older than
            // any packet that may still be of use.
            let inputs = (0..CAPACITY).map(|entry| SVector::repeat(self.numbers[entry])).collect();
            let before = Sequence { tick: NOW - 1 - CAPACITY as u32, inputs };
            actuator.offer(before).expect("it has an input left");
        }
        actuator.step();
        if let Some(steps) = self.age.steps() {
            actuator.offer(self.packet(steps + 1)).expect("acknowledged");
        }
        let played = actuator.step();
        assert_eq!(played.age, self.age);
        (actuator, played.input)
    }

    /// Every delay that packet `b` may have, with its probability, given that it had not arrived in the cycle
    /// before `NOW`; `None` is loss. Empty if it must have arrived by then.
    fn delays_under_way(&self, b: usize) -> Vec<(Option<usize>, f64)> {
        let mut possible: Vec<_> =
            self.delays.iter().enumerate().map(|(d, p)| (Some(d), *p)).skip(b).collect();
        possible.push((None, self.loss));
        possible.retain(|(_, p)| *p > 0.0);
        let total: f64 = possible.iter().map(|(_, p)| p).sum();
        possible.iter().map(|(delay, p)| (*delay, p / total)).collect()
    }

    /// Packets that are under way: sent after the one acknowledged, and of use if they arrive.
    fn under_way(&self) -> Vec<usize> {
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

    /// The expectation, by enumeration.
    fn expected_by_enumeration<const NU: usize>(&self, count: usize) -> Vec<SVector<f64, NU>> {
        let mut expected = vec![SVector::zeros(); count];
        // (probability, packet and delay for each packet looked at so far)
        let mut ways = vec![(1.0, vec![])];
        for b in self.under_way() {
            let delays = self.delays_under_way(b);
            let one_way = |(so_far, known): &(f64, Vec<(usize, usize)>)| {
                let (so_far, known) = (*so_far, known.clone());
                let next = |&(delay, p): &(Option<usize>, f64)| {
                    (so_far * p, known.iter().copied().chain(delay.map(|delay| (b, delay))).collect())
                };
                delays.iter().map(next).collect::<Vec<_>>()
            };
            ways = ways.iter().flat_map(one_way).collect();
        }
        let (actuator, _) = self.actuator::<NU>();
        for (probability, packets) in ways {
            let mut actuator = actuator.clone();
            for (m, value) in expected.iter_mut().enumerate() {
                for (b, delay) in &packets {
                    if *delay == b + m {
                        // Run out or past ones are the actuator's to reject.
                        let _ = actuator.offer(self.packet(*b));
                    }
                }
                *value += actuator.step().input * probability;
            }
        }
        expected
    }

    /// The expectation, by the core.
    fn expected_by_core<const NU: usize>(&self) -> Vec<SVector<f64, NU>> {
        let length = self.length;
        let mut survival = vec![0.0; length];
        arrival::survival(&self.delays, self.loss, &mut survival);
        let mut table = vec![0.0; arrival::table_len(length)];
        arrival::fill_table(&survival, &mut table);
        let (lx, m) =
            (vec![0.0; length * NU], vec![0.0; length * NU * self.default_input.in_flight(length) * NU]);
        let tables = Tables { lx: &lx, m: &m, arrival: &table };
        let gains = Gains::<f64, 1, NU>::check(length, self.default_input, tables).expect("valid tables");
        let mut in_flight = InFlight::<f64, NU, CAPACITY, 1>::default();
        for b in (1..=CAPACITY).rev() {
            in_flight.push(self.sent[b - 1].then(|| self.packet(b)));
        }
        in_flight.acknowledge(self.age, self.actuator().1);
        in_flight.expected_inputs(&gains).to_vec()
    }

    fn agrees<const NU: usize>(&self) {
        let found = self.expected_by_core::<NU>();
        assert_eq!(found.len(), self.default_input.in_flight(self.length));
        let expected = self.expected_by_enumeration::<NU>(found.len());
        for (m, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let difference = (found - expected).amax();
            assert!(difference < 1e-12, "input {m}: {found} instead of {expected}, in {self:?}");
        }
    }
}

fn situations() -> impl Strategy<Value = Situation> {
    // Weights, many of them zero: delays that never occur, also at the beginning and at the end.
    let weight = || prop_oneof![1 => Just(0u32), 2 => 1u32..100];
    let link = (proptest::collection::vec(weight(), 1..8), weight());
    let sent = proptest::collection::vec(proptest::bool::weighted(0.8), CAPACITY);
    let numbers = proptest::collection::vec(-1.0..1.0, (CAPACITY + 1) * CAPACITY * 2);
    (1..=CAPACITY, any::<bool>(), link, sent, 0..=CAPACITY, numbers)
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

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn expected_inputs_are_the_mean_over_all_ways_to_arrive(situation in situations()) {
        situation.agrees::<1>();
        situation.agrees::<2>();
    }
}

/// Three inputs a cycle from cycle 0 on, but none in cycle 3; cycle 5 is next, and cycle 0 is forgotten.
fn sent_for_five_cycles() -> InFlight<f64, 1, 3, 1> {
    let mut in_flight = InFlight::default();
    for made in 0..5 {
        let inputs = (0..3).map(|entry| SVector::from([f64::from(10 * made + entry)])).collect();
        in_flight.push((made != 3).then_some(ControlSequence { tick: Tick(made as u32), inputs }));
    }
    in_flight
}

#[test]
fn an_acknowledged_age_names_the_input_that_was_applied() {
    let in_flight = sent_for_five_cycles();
    let held = SVector::from([7.0]);
    let applied =
        |tick, age| in_flight.applied_input(DefaultInput::Hold, Tick(tick), age, &held).map(|input| input[0]);
    assert_eq!(applied(4, Age::Steps(0)), Some(40.0));
    assert_eq!(applied(4, Age::Steps(2)), Some(22.0));
    assert_eq!(applied(3, Age::Steps(1)), Some(21.0));
    assert_eq!(applied(3, Age::Steps(2)), Some(12.0), "run out by now, but not in cycle 3");
    assert_eq!(applied(4, Age::Empty), Some(7.0));
    assert_eq!(
        in_flight.applied_input(DefaultInput::Zero, Tick(4), Age::Empty, &held),
        Some(SVector::zeros())
    );
}

#[test]
fn an_age_that_no_sent_sequence_can_have_names_no_input() {
    let in_flight = sent_for_five_cycles();
    let applied = |tick, age| in_flight.applied_input(DefaultInput::Zero, Tick(tick), age, &SVector::zeros());
    assert_eq!(applied(4, Age::Steps(1)), None, "nothing was sent in cycle 3");
    assert_eq!(applied(2, Age::Steps(2)), None, "forgotten");
    assert_eq!(applied(4, Age::Steps(3)), None, "run out");
    assert_eq!(applied(0, Age::Steps(255)), None, "before the first");
}
