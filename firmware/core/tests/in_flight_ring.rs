//! What was sent is remembered in a ring: for as many cycles as there is memory, and no longer, past the wrap of ticks and of
//! the ring.

#[path = "random/dice.rs"]
mod dice;
mod lent;

use dice::Dice;
use slqg::in_flight::InFlight;
use slqg::nalgebra::SVector;
use slqg::{Age, DefaultInput, Tick};

const LENGTH: usize = 3;
type Inputs = [SVector<f64, 1>; LENGTH];

/// Other inputs in every cycle.
fn inputs(cycle: usize) -> Inputs {
    core::array::from_fn(|entry| SVector::from([(cycle * LENGTH + entry) as f64]))
}

/// Compares with a list of all that was ever sent.
fn remembers(in_flight: &InFlight<'_, f64, 1>, start: Tick, sent: &[bool], cycles: usize) {
    let now = sent.len();
    let remembered = |made: usize| made < now && now - made <= cycles && sent[made];
    for made in now.saturating_sub(cycles + 3)..now + 3 {
        let found = in_flight.made_at(start + made as u32);
        let expected = remembered(made).then(|| inputs(made));
        assert_eq!(
            found.map(|sequence| sequence.inputs),
            expected.as_ref().map(|inputs| &inputs[..]),
            "{made} of {now}"
        );
        assert!(found.is_none_or(|sequence| sequence.tick == start + made as u32));
        for age in 0..LENGTH + 2 {
            let (tick, steps) = (start + (made + age) as u32, Age::Steps(age as u8));
            let found = in_flight.applied_input(DefaultInput::Zero, tick, steps, &SVector::zeros());
            let expected = expected.as_ref().and_then(|inputs| inputs.get(age)).copied();
            assert_eq!(found, expected, "age {age} of {made}");
        }
    }
}

#[test]
fn every_sequence_is_remembered_for_as_long_as_there_is_memory_past_the_wrap_of_ticks() {
    for cycles in [LENGTH, LENGTH + 1, 2 * LENGTH, 11] {
        for start in [Tick(0), Tick(u32::MAX), Tick(u32::MAX - 17), Tick(i32::MAX as u32 - 9)] {
            let mut dice = Dice(0xACE5 + cycles as u64);
            let mut in_flight = lent::in_flight(LENGTH, cycles, start);
            let mut sent = vec![];
            remembers(&in_flight, start, &sent, cycles);
            for cycle in 0..10 * cycles {
                assert_eq!(in_flight.proposed().tick, start + cycle as u32);
                in_flight.candidate().copy_from_slice(&inputs(cycle));
                sent.push(dice.roll() < 0.7);
                in_flight.push(sent[cycle]);
                remembers(&in_flight, start, &sent, cycles);
            }
        }
    }
}

#[test]
fn a_candidate_takes_nothing_from_what_was_sent_until_it_is() {
    let mut in_flight = lent::in_flight(LENGTH, LENGTH, Tick(0));
    let mut sent = vec![];
    for cycle in 0..20 {
        for attempt in [100, 200, cycle] {
            in_flight.candidate().copy_from_slice(&inputs(attempt));
            assert_eq!(in_flight.proposed().inputs, inputs(attempt));
            remembers(&in_flight, Tick(0), &sent, LENGTH);
        }
        sent.push(true);
        in_flight.push(true);
    }
}

#[test]
fn after_a_million_cycles_it_is_as_after_a_few() {
    let start = Tick(u32::MAX - 500_000);
    let mut in_flight = lent::in_flight(LENGTH, 5, start);
    let mut sent = vec![];
    for cycle in 0..1_000_000 {
        in_flight.candidate().copy_from_slice(&inputs(cycle));
        sent.push(cycle % 7 != 3);
        in_flight.push(sent[cycle]);
    }
    remembers(&in_flight, start, &sent, 5);
}

#[test]
fn memory_too_short_for_anything_remembers_nothing_and_breaks_nothing() {
    for (cycles, numbers) in [(0, 0), (1, 0), (0, 9), (1, 2), (4, 5)] {
        let mut in_flight =
            InFlight::<f64, 1>::new(LENGTH, Tick(0), lent::entries(true, cycles), lent::inputs(numbers));
        for cycle in 0..9_u32 {
            let candidate = in_flight.candidate();
            let written = candidate.len();
            candidate.copy_from_slice(&inputs(cycle as usize)[..written]);
            in_flight.push(true);
            for ago in 0..4 {
                let found = in_flight.made_at(Tick(cycle) - ago).map(|sequence| sequence.inputs.len());
                assert!(found.is_none_or(|found| found == 0 || found == LENGTH), "{found:?}");
            }
        }
    }
}
