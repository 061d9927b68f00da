//! What a controller makes of acknowledgements that come, come late, or do not come.

mod by_hand;
#[path = "random/dice.rs"]
mod dice;
mod double_integrator;
mod exercise;
mod lent;

use by_hand::{acknowledge, acknowledge_all, after_five_cycles, cycle, measure, workshop};
use double_integrator::{DELAYS, LENGTH, Node};
use exercise::Exercise;
use slqg::controller::{Counts, Design, RejectedFrame};
use slqg::estimator::Merging;
use slqg::nalgebra::SVector;
use slqg::wire;
use slqg::{Age, DefaultInput, Tick};

const START: Tick = Tick(u32::MAX - 100);

fn inputs_believed(controller: &Node<'_, f32>) -> Vec<f32> {
    (0..5).map(|tick| controller.expected_input(Tick(tick)).expect("remembered")[0]).collect()
}

/// `found` is `expected` but for rounding.
fn assert_near(found: f32, expected: f32) {
    assert!((found - expected).abs() < 1e-5 * (1.0 + expected.abs()), "{found} instead of {expected}");
}

/// Probability that a sequence has arrived within `age` cycles.
fn arrived(age: usize) -> f32 {
    DELAYS[..=age].iter().sum::<f64>() as f32
}

#[test]
fn a_missing_acknowledgement_is_counted_once_for_its_cycle() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = lent::controller(workshop.design(), Tick(0)).expect("a fitting design");
    cycle(&mut controller);
    assert_eq!(
        controller.counts(),
        Counts::default(),
        "before the first cycle there is nothing to acknowledge"
    );
    acknowledge(&mut controller, 0, Age::Steps(0)).expect("of use");
    cycle(&mut controller);
    cycle(&mut controller);
    acknowledge(&mut controller, 1, Age::Steps(0)).expect("late, but of use");
    cycle(&mut controller);
    assert_eq!(controller.counts(), Counts { unacknowledged: 2, ..Counts::default() });
}

#[test]
fn without_acknowledgement_what_was_played_is_as_likely_as_the_link_makes_it() {
    let workshop = workshop(DefaultInput::Zero);
    let (mut controller, sent) = after_five_cycles(&workshop);
    cycle(&mut controller);
    for (now, found) in inputs_believed(&controller).into_iter().enumerate() {
        let (mut expected, mut none_newer) = (0.0, 1.0);
        for age in 0..LENGTH.min(now + 1) {
            expected += none_newer * arrived(age) * sent[now - age][age];
            none_newer *= 1.0 - arrived(age);
        }
        assert_near(found, expected);
    }
}

#[test]
fn a_late_acknowledgement_corrects_its_cycle_and_what_is_likely_after_it() {
    let workshop = workshop(DefaultInput::Zero);
    let (mut controller, sent) = after_five_cycles(&workshop);
    acknowledge(&mut controller, 3, Age::Steps(0)).expect("late, but of use");
    acknowledge(&mut controller, 1, Age::Steps(1)).expect("late, but of use");
    cycle(&mut controller);
    let found = inputs_believed(&controller);
    assert_eq!((found[1], found[3]), (sent[0][1], sent[3][0]));
    assert_near(found[0], arrived(0) * sent[0][0]);
    // The sequence of cycle 0 plays on unless that of cycle 2 arrives at once, or that of cycle 1 then.
    let under_way = (arrived(1) - arrived(0)) / (1.0 - arrived(0));
    let older = under_way * sent[1][1] + (1.0 - under_way) * sent[0][2];
    assert_near(found[2], arrived(0) * sent[2][0] + (1.0 - arrived(0)) * older);
    assert_near(found[4], arrived(0) * sent[4][0] + (1.0 - arrived(0)) * sent[3][1]);
}

#[test]
fn a_late_acknowledgement_corrects_what_is_held_after_it() {
    let workshop = workshop(DefaultInput::Hold);
    let (mut controller, sent) = after_five_cycles(&workshop);
    acknowledge(&mut controller, 4, Age::Empty).expect("of use");
    acknowledge(&mut controller, 3, Age::Steps(3)).expect("late, but of use");
    cycle(&mut controller);
    assert_eq!(inputs_believed(&controller)[3..], [sent[0][3], sent[0][3]]);
}

/// What five cycles were acknowledged with, all of which may be true.
const PLAYED: [Age; 5] = [Age::Empty, Age::Steps(1), Age::Steps(0), Age::Steps(1), Age::Steps(1)];

#[test]
fn late_acknowledgements_in_any_order_give_the_same_bits() {
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        let workshop = workshop(default_input);
        let outcome = |order: [u32; 5]| {
            let (mut controller, _) = after_five_cycles(&workshop);
            for tick in order {
                acknowledge(&mut controller, tick, PLAYED[tick as usize]).expect("of use");
            }
            cycle(&mut controller);
            format!("{controller:?}")
        };
        let in_order = outcome([0, 1, 2, 3, 4]);
        assert_eq!(outcome([4, 3, 2, 1, 0]), in_order);
        assert_eq!(outcome([2, 0, 4, 1, 3]), in_order);
    }
}

#[test]
fn one_frame_of_several_ages_makes_good_the_loss_of_those_before() {
    let workshop = workshop(DefaultInput::Zero);
    let (mut one_by_one, _) = after_five_cycles(&workshop);
    let (mut at_once, _) = after_five_cycles(&workshop);
    for (tick, age) in (0..).zip(PLAYED) {
        acknowledge(&mut one_by_one, tick, age).expect("of use");
    }
    let newest_first: Vec<Age> = PLAYED.into_iter().rev().collect();
    acknowledge_all(&mut at_once, 4, &newest_first).expect("of use");
    cycle(&mut one_by_one);
    cycle(&mut at_once);
    assert_eq!(format!("{at_once:?}"), format!("{one_by_one:?}"));
}

#[test]
fn ages_of_cycles_before_the_first_or_forgotten_do_not_spoil_a_frame() {
    let workshop = workshop(DefaultInput::Zero);
    let (mut controller, sent) = after_five_cycles(&workshop);
    let ages = [Age::Steps(0), Age::Steps(0), Age::Steps(99), Age::Steps(99)];
    acknowledge_all(&mut controller, 1, &ages).expect("of use");
    cycle(&mut controller);
    assert_eq!(inputs_believed(&controller)[..2], [sent[0][0], sent[1][0]]);
}

#[test]
fn an_acknowledgement_is_of_use_as_long_as_the_estimator_remembers_its_cycle() {
    let workshop = workshop(DefaultInput::Zero);
    let (mut controller, sent) = after_five_cycles(&workshop);
    cycle(&mut controller);
    for _ in 0..3 {
        cycle(&mut controller);
    }
    // Now is cycle 9: the oldest remembered is 3, in which the sequence of cycle 0 still had an input.
    acknowledge(&mut controller, 3, Age::Steps(3)).expect("late, but of use");
    assert_eq!(acknowledge(&mut controller, 2, Age::Steps(1)), Err(RejectedFrame::Acknowledgement));
    cycle(&mut controller);
    assert_eq!(controller.expected_input(Tick(3)).expect("remembered")[0], sent[0][3]);
}

#[test]
fn a_repeated_acknowledgement_changes_nothing() {
    let workshop = workshop(DefaultInput::Hold);
    let (mut controller, _) = after_five_cycles(&workshop);
    acknowledge(&mut controller, 3, Age::Steps(1)).expect("of use");
    let before = format!("{controller:?}");
    acknowledge(&mut controller, 3, Age::Steps(1)).expect("of use");
    assert_eq!(format!("{controller:?}"), before);
}

#[test]
fn frames_that_come_again_and_again_in_any_order_give_the_same_bits() {
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        for merging in [Merging::Single, Merging::Imm, Merging::Gpb2] {
            let workshop = workshop(default_input);
            let design = Design { merging, ..workshop.design() };
            let mut link = Exercise::new(design, START, 6);
            let [mut once, mut often] =
                [(); 2].map(|()| lent::controller(design, START).expect("a fitting design"));
            let mut repeated = 0;
            for cycle in 0..200 {
                let heard = link.heard();
                for frame in &heard {
                    // What is too old is refused.
                    let _ = once.receive(frame);
                }
                for frame in heard.iter().chain(heard.iter().rev()).chain(&heard) {
                    let is_acknowledgement = wire::decode_acknowledgement::<f32>(frame).is_ok();
                    repeated += u32::from(often.receive(frame).is_ok() && is_acknowledgement);
                }
                let (mut sent, mut expected) = ([0; 64], [0; 64]);
                let frame = once.cycle(&mut expected).expect("there is room");
                assert_eq!(often.cycle(&mut sent).expect("there is room"), frame, "cycle {cycle}");
                link.finish(frame);
            }
            assert_eq!(often.counts().unacknowledged, once.counts().unacknowledged);
            assert!(repeated > 300, "a repeated acknowledgement is no error: {repeated}");
        }
    }
}

#[test]
fn an_acknowledgement_that_cannot_be_true_is_rejected() {
    let workshop = workshop(DefaultInput::Zero);
    let (mut controller, _) = after_five_cycles(&workshop);
    let before = format!("{:?}", controller.estimator());
    let rejected = Err(RejectedFrame::Acknowledgement);
    assert_eq!(acknowledge(&mut controller, 5, Age::Empty), rejected, "not over");
    assert_eq!(acknowledge(&mut controller, 2, Age::Steps(3)), rejected, "before the first sequence");
    assert_eq!(acknowledge(&mut controller, 4, Age::Steps(LENGTH as u8)), rejected, "run out by then");
    assert_eq!(acknowledge(&mut controller, u32::MAX, Age::Empty), rejected, "before the first cycle");
    let one_of_many = [Age::Steps(1), Age::Steps(0), Age::Steps(3), Age::Steps(0)];
    assert_eq!(acknowledge_all(&mut controller, 4, &one_of_many), rejected, "one of several");
    assert_eq!(controller.counts().rejected_frames, 5);
    assert_eq!(format!("{:?}", controller.estimator()), before);
}

#[test]
fn the_memory_is_as_long_as_measurements_or_acknowledgements_need_it() {
    let workshop = workshop(DefaultInput::Zero);
    for (measurement_buffer, acknowledgement_buffer) in [(1, 5), (5, 1)] {
        let design = Design { measurement_buffer, acknowledgement_buffer, ..workshop.design() };
        let mut controller = lent::controller(design, Tick(0)).expect("a fitting design");
        measure(&mut controller, 0, 1.0);
        let sent: Vec<_> = (0..9).map(|_| cycle(&mut controller)).collect();
        // Now is cycle 9.
        let too_long_ago = acknowledge(&mut controller, 3, Age::Steps(0));
        assert_eq!(too_long_ago, Err(RejectedFrame::Acknowledgement));
        acknowledge(&mut controller, 4, Age::Steps(0)).expect("remembered");
        cycle(&mut controller);
        assert_eq!(controller.expected_input(Tick(4)), Some(SVector::from([sent[4][0]])));
        assert_eq!(controller.expected_input(Tick(3)), None, "forgotten");
    }
}
