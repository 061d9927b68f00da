//! A cycle in two steps is the cycle in one; and what is sent instead of the law's sequence is what the estimator goes by.

#[path = "random/dice.rs"]
mod dice;
mod double_integrator;
mod exercise;
mod lent;

use double_integrator::{LENGTH, Node, Workshop};
use exercise::{Exercise, known};
use slqg::actuator::Settings;
use slqg::controller::{Counts, Design, RejectedFrame, RejectedInputs};
use slqg::estimator::Merging;
use slqg::nalgebra::SVector;
use slqg::tracking::{Preview, RejectedReference, Tables};
use slqg::wire::can::Grid;
use slqg::wire::{self, Acknowledgement, EncodeError};
use slqg::{Age, DefaultInput, Tick};

type Inputs = [SVector<f32, 1>; LENGTH];

const START: Tick = Tick(u32::MAX - 20);
const CYCLES: usize = 60;
const GRID: Grid<f32, 1> = Grid { step: SVector::<f32, 1>::new(0.25), largest_count: 8 };
const OTHER: Inputs = [
    SVector::<f32, 1>::new(0.5),
    SVector::<f32, 1>::new(-0.75),
    SVector::<f32, 1>::new(1.0),
    SVector::<f32, 1>::new(0.25),
];

fn workshop(default_input: DefaultInput) -> Workshop<f32> {
    Workshop::double_integrator(Settings { default_input, limits: None, safe: None })
}

/// Calls `check` with every design there is.
fn every_design(check: impl Fn(Design<'_, f32, 2, 1, 1>)) {
    for default_input in [DefaultInput::Zero, DefaultInput::Hold] {
        for merging in [Merging::Single, Merging::Imm, Merging::Gpb2] {
            for grid in [None, Some(GRID)] {
                check(Design { merging, grid, ..workshop(default_input).design() });
            }
        }
    }
}

/// Proposes, and returns the frame and the inputs proposed.
fn propose(controller: &mut Node<'_, f32>) -> (Vec<u8>, Vec<SVector<f32, 1>>) {
    let mut buffer = [0; 64];
    let proposal = controller.propose();
    let frame = wire::encode_control(&proposal.sequence, &mut buffer).expect("there is room");
    (frame.to_vec(), proposal.sequence.inputs.to_vec())
}

fn acknowledge(controller: &mut Node<'_, f32>, tick: Tick, age: Age) -> Result<(), RejectedFrame> {
    controller.acknowledged(&Acknowledgement::of(tick, age))
}

/// The inputs of the sequence sent in cycle `made`, the last one: what its acknowledgements mean, one after the other.
fn played_out(controller: &mut Node<'_, f32>, made: Tick) -> Vec<SVector<f32, 1>> {
    let mut play = |age: u8| {
        let tick = made + age.into();
        acknowledge(controller, tick, Age::Steps(age)).expect("it was sent");
        controller.propose();
        let input = controller.expected_input(tick).expect("it is over");
        controller.commit(false);
        input
    };
    (0..LENGTH as u8).map(&mut play).collect()
}

/// Runs one controller by cycles and another one by `steps`, which is told what comes and may return what it sends, over the
/// same link: they must know the same, to the bit.
fn as_by_cycles(steps: impl Fn(&mut Node<'_, f32>, &[Vec<u8>]) -> Option<Vec<u8>>) {
    every_design(|design| {
        let [mut one, mut two] = [(); 2].map(|()| lent::controller(design, START).expect("a fitting design"));
        let mut link = Exercise::new(design, START, 1);
        for cycle in 0..CYCLES {
            let heard = link.heard();
            for frame in &heard {
                let _ = one.receive(frame);
            }
            let mut buffer = [0; 64];
            let frame = one.cycle(&mut buffer).expect("there is room").expect("finite");
            let sent = steps(&mut two, &heard);
            assert!(sent.is_none_or(|sent| sent == frame), "cycle {cycle}");
            assert_eq!(known(&two), known(&one), "cycle {cycle}");
            link.finish(Some(frame));
        }
    });
}

fn hear(controller: &mut Node<'_, f32>, frames: &[Vec<u8>]) {
    for frame in frames {
        // What is too old is refused.
        let _ = controller.receive(frame);
    }
}

#[test]
fn a_cycle_in_two_steps_leaves_the_bits_of_one() {
    as_by_cycles(|controller, heard| {
        hear(controller, heard);
        let (frame, _) = propose(controller);
        controller.commit(true);
        Some(frame)
    });
}

#[test]
fn proposing_again_changes_nothing_where_nothing_came_in_between() {
    as_by_cycles(|controller, heard| {
        hear(controller, heard);
        let first = propose(controller);
        let tick = controller.tick();
        let again = propose(controller);
        assert_eq!((&first, tick), (&again, controller.tick()));
        controller.commit(true);
        Some(first.0)
    });
}

#[test]
fn proposing_again_takes_account_of_what_came_in_between() {
    // Late by a step or not at all, but for what is counted as not acknowledged, which all of these are not any more.
    every_design(|design| {
        let [mut one, mut two] = [(); 2].map(|()| lent::controller(design, START).expect("a fitting design"));
        let mut link = Exercise::new(design, START, 2);
        for cycle in 0..CYCLES {
            let heard = link.heard();
            hear(&mut one, &heard);
            let (frame, _) = propose(&mut one);
            one.commit(true);
            propose(&mut two);
            hear(&mut two, &heard);
            assert_eq!(propose(&mut two).0, frame, "cycle {cycle}");
            two.commit(true);
            assert_eq!(two.estimator().posterior_mean(), one.estimator().posterior_mean());
            link.finish(Some(&frame));
        }
        assert!(two.counts().unacknowledged > one.counts().unacknowledged);
    });
}

#[test]
fn a_commit_without_a_proposal_sends_the_sequence_of_the_law() {
    as_by_cycles(|controller, heard| {
        hear(controller, heard);
        controller.commit(true);
        // What it has sent shows in what is expected of it later.
        None
    });
}

#[test]
fn frames_between_the_steps_count_from_the_next_cycle_on() {
    every_design(|design| {
        let [mut after, mut between] =
            [(); 2].map(|()| lent::controller(design, START).expect("a fitting design"));
        let mut link = Exercise::new(design, START, 4);
        for cycle in 0..CYCLES {
            let heard = link.heard();
            let (frame, _) = propose(&mut after);
            after.commit(true);
            let (proposed, _) = propose(&mut between);
            assert_eq!(proposed, frame, "cycle {cycle}");
            hear(&mut between, &heard);
            between.commit(true);
            hear(&mut after, &heard);
            // Too late for some by the step in between.
            assert_eq!(between.counts().unacknowledged, after.counts().unacknowledged);
            link.finish(Some(&frame));
        }
    });
}

#[test]
fn what_is_not_sent_is_as_a_packet_that_could_not_be_written() {
    let workshop = workshop(DefaultInput::Hold);
    let [mut one, mut two] =
        [(); 2].map(|()| lent::controller(workshop.design(), START).expect("a fitting design"));
    let mut link = Exercise::new(workshop.design(), START, 3);
    for cycle in 0..CYCLES {
        let heard = link.heard();
        hear(&mut one, &heard);
        hear(&mut two, &heard);
        let (frame, _) = propose(&mut two);
        let is_sent = cycle % 3 != 1;
        two.commit(is_sent);
        let mut buffer = [0; 64];
        let room = if is_sent { 64 } else { 5 };
        let outcome = one.cycle(&mut buffer[..room]);
        assert_eq!(outcome, if is_sent { Ok(Some(&frame[..])) } else { Err(EncodeError::BufferTooSmall) });
        assert_eq!(known(&two), known(&one), "cycle {cycle}");
        link.finish(is_sent.then_some(&frame));
    }
}

#[test]
fn a_sequence_that_replaces_the_proposed_one_is_what_is_expected_to_be_played() {
    every_design(|design| {
        for proposes in [true, false] {
            let mut controller = lent::controller(design, START).expect("a fitting design");
            if proposes {
                controller.propose();
            }
            let sequence = controller.replace(&OTHER).expect("as many, and finite");
            assert_eq!((sequence.tick, sequence.inputs), (START, &OTHER[..]), "it is on the grid as it is");
            controller.commit(true);
            // Nothing is known of its way: it has arrived with a probability of 0.4.
            controller.propose();
            let likely = 0.4 * OTHER[0];
            let expected = controller.expected_input(START).expect("over");
            assert!((expected - likely).amax() < 1e-6, "{expected} instead of {likely}");
            acknowledge(&mut controller, START, Age::Steps(0)).expect("sent");
            controller.propose();
            assert_eq!(controller.expected_input(START), Some(OTHER[0]));
            let left = controller.propose().expected.to_vec();
            assert_eq!(left[..LENGTH - 1], OTHER[1..], "what is in flight if nothing newer arrives");
            assert_eq!(played_out(&mut controller, START), OTHER);
        }
    });
}

#[test]
fn inputs_off_the_grid_are_replaced_by_what_the_actuator_gets() {
    let workshop = workshop(DefaultInput::Zero);
    let design = Design { grid: Some(GRID), ..workshop.design() };
    let mut controller = lent::controller(design, START).expect("a fitting design");
    let numbers = [0.3, -0.7, 100.0, 0.1].map(|number| SVector::from([number]));
    let on_grid = [0.25, -0.75, 2.0, 0.0].map(|number| SVector::from([number]));
    assert_eq!(controller.replace(&numbers).expect("finite").inputs, on_grid);
    controller.commit(true);
    assert_eq!(played_out(&mut controller, START), on_grid);
}

#[test]
fn inputs_that_are_refused_leave_the_proposed_sequence() {
    let workshop = workshop(DefaultInput::Zero);
    let mut controller = lent::controller(workshop.design(), START).expect("a fitting design");
    controller.commit(true);
    let (_, proposed) = propose(&mut controller);
    assert_eq!(controller.replace(&OTHER[1..]), Err(RejectedInputs::Length));
    assert_eq!(controller.replace(&[OTHER[0]; LENGTH + 1]), Err(RejectedInputs::Length));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut inputs = OTHER;
        inputs[LENGTH - 1][0] = bad;
        assert_eq!(controller.replace(&inputs), Err(RejectedInputs::NotFinite));
    }
    controller.commit(true);
    assert_eq!(played_out(&mut controller, START + 1), proposed);
}

#[test]
fn proposing_again_and_a_cycle_take_a_replacement_back() {
    as_by_cycles(|controller, heard| {
        hear(controller, heard);
        controller.replace(&OTHER).expect("as many, and finite");
        if controller.tick().0 % 2 == 0 {
            let mut buffer = [0; 64];
            return controller.cycle(&mut buffer).expect("there is room").map(<[u8]>::to_vec);
        }
        let (frame, _) = propose(controller);
        controller.commit(true);
        Some(frame)
    });
}

#[test]
fn a_sequence_that_is_not_finite_is_counted_and_taken_for_not_sent() {
    let mut workshop = workshop(DefaultInput::Zero);
    workshop.model.initial_mean = SVector::from([f32::MAX, f32::MAX]);
    let mut controller = lent::controller(workshop.design(), START).expect("a fitting design");
    assert!(!controller.propose().sequence.is_finite());
    controller.commit(true);
    assert!(!controller.has_sent(START));
    assert_eq!(controller.counts(), Counts { not_finite: 1, ..Counts::default() });
    assert_eq!(
        acknowledge(&mut controller, START, Age::Steps(0)),
        Err(RejectedFrame::Acknowledgement),
        "it cannot have been played"
    );
}

#[test]
fn a_reference_followed_or_refused_between_the_steps_leaves_the_proposed_sequence() {
    let workshop = workshop(DefaultInput::Zero);
    let gains = [1.0, 2.0, 3.0, 4.0];
    let tables = Tables::check(&gains, &[]).expect("finite");
    let preview =
        Preview::check(LENGTH, DefaultInput::Zero, 1, 1, tables).expect("tables of the right shape");
    let design = Design { preview: Some(preview), ..workshop.design() };
    let [mut one, mut two] = [(); 2].map(|()| lent::controller(design, START).expect("a fitting design"));
    let still = [SVector::from([1.0])];
    let frames =
        [None, Some((&still[0], Ok(()))), Some((&BAD, Err(RejectedReference::NotFinite)))].map(|reference| {
            let (frame, _) = propose(&mut two);
            if let Some((reference, taken)) = reference {
                assert_eq!(two.follow(&[*reference]), taken);
            }
            two.commit(true);
            frame
        });
    let (last, _) = propose(&mut two);
    two.commit(true);
    for (cycle, frame) in frames.iter().chain([&last]).enumerate() {
        if cycle == 2 {
            one.follow(&still).expect("a sample of the tracked output");
        }
        let mut buffer = [0; 64];
        assert_eq!(one.cycle(&mut buffer), Ok(Some(&frame[..])), "cycle {cycle}");
    }
    assert_ne!(frames[1], frames[2], "the reference makes a difference");
    assert_eq!(known(&two), known(&one));
}

const BAD: SVector<f32, 1> = SVector::<f32, 1>::new(f32::INFINITY);
