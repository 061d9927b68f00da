//! The actuator node applies an input in each cycle, and the safe one when it does not know the time.

use slqg::nalgebra::SVector;
use slqg::wire::{self, Clock, Kind};
use slqg::{Age, actuator::Applied};
use slqg::{Tick, sequence::ControlSequence};
use slqg_nodes::actuator::{Node, PATIENCE};
use slqg_nodes::board::{Node as _, Notice};
use slqg_nodes::design::{ACTUATOR_MEMORY, INPUTS, SEQUENCE_LENGTH, Scalar};

mod desk;
use desk::{BYTES, Desk, RUNNING, STEPPED};

fn node() -> Node<'static> {
    Node::new(Box::leak(Box::new(ACTUATOR_MEMORY)))
}

fn applied(frame: &[u8]) -> Applied<Scalar, INPUTS> {
    wire::decode_applied(frame).expect("what was applied")
}

/// A control frame of cycle `tick` with the same input all over.
fn control(tick: u32, input: Scalar) -> Vec<u8> {
    let inputs = (0..SEQUENCE_LENGTH).map(|_| SVector::<Scalar, INPUTS>::repeat(input)).collect::<Vec<_>>();
    let sequence = ControlSequence { tick: Tick(tick), inputs: &inputs };
    let mut buffer = vec![0; wire::control_len(INPUTS, SEQUENCE_LENGTH, BYTES)];
    wire::encode_control(&sequence, &mut buffer).expect("it is as long as it says").to_vec()
}

#[test]
fn a_sequence_that_comes_before_the_first_cycle_is_played_if_the_cycle_is_known() {
    let (mut node, mut desk) = (node(), Desk::default());
    desk.clock(&mut node, 7, Clock { begins: false, ..STEPPED });
    node.take(&control(7, 2.5), &mut desk);
    desk.clock(&mut node, 7, STEPPED);
    let played = applied(&desk.sent[1]);
    assert_eq!(
        (played.tick, played.age, played.input),
        (Tick(7), Age::Steps(0), SVector::<Scalar, INPUTS>::repeat(2.5))
    );
    assert_eq!(desk.kinds(), [Kind::Acknowledgement, Kind::Applied]);
}

#[test]
fn a_node_that_does_not_know_the_cycle_takes_no_sequence() {
    let (mut node, mut desk) = (node(), Desk::default());
    node.take(&control(7, 2.5), &mut desk);
    desk.clock(&mut node, 7, STEPPED);
    assert_eq!(applied(&desk.sent[1]).age, Age::Empty);
}

#[test]
fn a_clock_that_stops_leaves_the_plant_with_the_safe_input_once() {
    let (mut node, mut desk) = (node(), Desk::default());
    desk.clock(&mut node, 7, Clock { begins: false, ..STEPPED });
    node.take(&control(7, 2.5), &mut desk);
    desk.clock(&mut node, 7, STEPPED);
    desk.sent.clear();
    (1..PATIENCE).for_each(|_| node.period_over(&mut desk));
    assert!(desk.sent.is_empty(), "patience is not over");
    (0..5).for_each(|_| node.period_over(&mut desk));
    assert_eq!(desk.sent.len(), 1);
    assert_eq!(applied(&desk.sent[0]).input, SVector::<Scalar, INPUTS>::zeros());
    assert_eq!(desk.notices.last(), Some(&Notice::Safe));
    desk.clock(&mut node, 8, STEPPED);
    assert_eq!(applied(desk.sent.last().expect("it goes on")).input, SVector::<Scalar, INPUTS>::repeat(2.5));
}

#[test]
fn a_node_that_runs_by_its_timer_plays_its_buffer_out() {
    let (mut node, mut desk) = (node(), Desk::default());
    desk.clock(&mut node, 0, Clock { begins: false, ..RUNNING });
    node.take(&control(0, 1.0), &mut desk);
    desk.clock(&mut node, 0, RUNNING);
    (1..SEQUENCE_LENGTH).for_each(|_| node.period_over(&mut desk));
    assert_eq!(applied(desk.sent.last().expect("it ran")).input, SVector::<Scalar, INPUTS>::repeat(1.0));
    node.period_over(&mut desk);
    assert_eq!(applied(desk.sent.last().expect("it ran")).age, Age::Empty, "nothing is left");
}

#[test]
fn the_frame_for_when_the_program_has_failed_applies_the_safe_input() {
    let mut buffer = [0; 64];
    assert_eq!(applied(node().safe_frame(&mut buffer)).input, SVector::<Scalar, INPUTS>::zeros());
}
