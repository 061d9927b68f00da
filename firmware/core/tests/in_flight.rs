//! The expected inputs are expectations: over every way the packets in flight may still arrive.
//!
//! The comparison enumerates those ways and plays each through an actuator.

mod lent;
mod situation;

use proptest::prelude::*;
use situation::{CAPACITY, Situation, situations};
use slqg::in_flight::InFlight;
use slqg::nalgebra::SVector;
use slqg::{Age, DefaultInput, Tick};

/// One way for the packets in flight to arrive.
struct Played<const NU: usize> {
    probability: f64,
    /// What is applied from `NOW` on.
    inputs: Vec<SVector<f64, NU>>,
    /// The age of the newest packet that has arrived by each of these cycles, as of `NOW`; `None` if none did since.
    newest: Vec<Option<usize>>,
}

/// Everything that may be applied in `count` cycles from `NOW` on.
fn everything<const NU: usize>(situation: &Situation, count: usize) -> Vec<Played<NU>> {
    let play = |(probability, packets): (f64, Vec<(usize, usize)>)| {
        let (mut actuator, _) = situation.actuator::<NU>();
        let mut inputs = vec![];
        for m in 0..count {
            for (b, _) in packets.iter().filter(|(b, delay)| *delay == b + m) {
                situation.arrives(*b, &mut actuator);
            }
            inputs.push(actuator.step().input);
        }
        let arrived = |m| packets.iter().filter(move |(b, delay)| *delay <= b + m).map(|(b, _)| *b);
        // What is run out when it comes is of no use, and told by no acknowledgement.
        let of_use =
            |m| arrived(m).filter(|b| packets.iter().any(|(age, d)| age == b && *d < situation.length));
        Played { probability, inputs, newest: (0..count).map(|m| of_use(m).min()).collect() }
    };
    situation.ways(&situation.under_way()).into_iter().map(play).collect()
}

/// The mean of the inputs in `of`, and how likely it is altogether.
fn mean<'p, const NU: usize>(of: impl Iterator<Item = &'p Played<NU>>, m: usize) -> (SVector<f64, NU>, f64) {
    let (sum, total) = of.fold((SVector::zeros(), 0.0), |(sum, total), played| {
        (sum + played.inputs[m] * played.probability, total + played.probability)
    });
    (sum / total, total)
}

/// Gains that matter to no expectation.
fn no_gains<const NU: usize>(situation: &Situation) -> Vec<f64> {
    vec![0.0; situation.length * NU * (1 + situation.default_input.in_flight(situation.length) * NU)]
}

fn the_mean_agrees<const NU: usize>(situation: &Situation) {
    let found = situation.with_law::<1, NU, _>(&no_gains::<NU>(situation), |gains, in_flight, played| {
        lent::expected(in_flight, gains, &played)
    });
    assert_eq!(found.len(), situation.default_input.in_flight(situation.length));
    let all = everything::<NU>(situation, found.len());
    for (m, found) in found.iter().enumerate() {
        let (expected, _) = mean(all.iter(), m);
        let difference = (found - expected).amax();
        assert!(difference < 1e-12, "input {m}: {found} instead of {expected}, in {situation:?}");
    }
}

/// Given the newest packet that has arrived by `NOW + told`, the inputs from then on are its conditional means.
fn what_is_told_agrees<const NU: usize>(situation: &Situation) {
    situation.with_law::<1, NU, _>(&no_gains::<NU>(situation), |gains, in_flight, played| {
        let count = gains.in_flight();
        let all = everything::<NU>(situation, count);
        let unconditional = lent::expected(in_flight, gains, &played);
        let mut room = vec![SVector::zeros(); count];
        for told in 0..count {
            let mut found: Vec<(f64, Vec<SVector<f64, NU>>)> = vec![];
            in_flight.for_each_newest(gains, &played, told, &mut room, |probability, expected| {
                found.push((probability, expected.to_vec()));
            });
            let total: f64 = found.iter().map(|(probability, _)| probability).sum();
            assert!((total - 1.0).abs() < 1e-12, "{total} in {situation:?}");
            for (m, unconditional) in unconditional.iter().enumerate().skip(told) {
                let sum = found.iter().fold(SVector::zeros(), |sum, (p, expected)| sum + expected[m] * *p);
                let difference = (sum - unconditional).amax();
                assert!(difference < 1e-12, "the mean of all means is the mean, in {situation:?}");
            }
            // Newest first, and last that nothing newer has come.
            let newest: Vec<Option<usize>> = (1..=CAPACITY).map(Some).chain([None]).collect();
            let groups =
                newest.iter().map(|age| all.iter().filter(move |played| played.newest[told] == *age));
            let groups: Vec<_> =
                groups.filter(|group| group.clone().any(|played| played.probability > 0.0)).collect();
            found.retain(|(probability, _)| *probability > 0.0);
            assert_eq!(found.len(), groups.len(), "told {told} in {situation:?}");
            for ((probability, inputs), group) in found.iter().zip(groups) {
                for m in told..count {
                    let (expected, total) = mean(group.clone(), m);
                    assert!(
                        (probability - total).abs() < 1e-12,
                        "{probability} for {total} in {situation:?}"
                    );
                    let difference = (inputs[m] - expected).amax();
                    assert!(difference < 1e-10, "told {told}, input {m} in {situation:?}");
                }
            }
        }
    });
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn expected_inputs_are_the_mean_over_all_ways_to_arrive(situation in situations(CAPACITY)) {
        the_mean_agrees::<1>(&situation);
        the_mean_agrees::<2>(&situation);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_told_of_the_newest_packet_leaves_its_conditional_mean(situation in situations(CAPACITY)) {
        what_is_told_agrees::<1>(&situation);
        what_is_told_agrees::<2>(&situation);
    }
}

/// Three inputs a cycle from cycle 0 on, but none in cycle 3; cycle 5 is next, and cycle 0 is forgotten.
fn sent_for_five_cycles() -> InFlight<'static, f64, 1> {
    let mut in_flight = lent::in_flight(3, 4, Tick(0));
    for made in 0..5 {
        let inputs: Vec<_> = (0..3).map(|entry| SVector::from([f64::from(10 * made + entry)])).collect();
        lent::push(&mut in_flight, (made != 3).then_some(&inputs));
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
