//! The controller node does in each cycle what its clock, its host and its link tell it.

use slqg::blob::{DesignId, Shape, encode, encoded_len};
use slqg::health::{Cause, Health};
use slqg::nalgebra::SVector;
use slqg::wire::{self, GainsAnswer, GainsPart, Kind, Measurement, Status, Verdict};
use slqg::{Tick, gains::Tables};
use slqg_nodes::board::{Node as _, Notice};
use slqg_nodes::controller::Node;
use slqg_nodes::design::{ACTUATOR, INPUTS, Memory, OUTPUTS, SEQUENCE_LENGTH, STATES, Scalar};
use slqg_nodes::dimensions::DESIGN_ID;
use slqg_nodes::laws::{BANK_MEMORY, Sent};

mod desk;
use desk::{BYTES, Desk, RUNNING, STEPPED};

fn node() -> Node<'static, Sent<'static>> {
    let (memory, bank) = (Box::leak(Box::new(Memory::new())), Box::leak(Box::new([0.0; BANK_MEMORY])));
    Node::new(memory, Box::leak(Box::new(Sent::new(bank))))
}

#[test]
fn nothing_is_sent_before_the_clock_tells_the_cycle() {
    let (mut node, mut desk) = (node(), Desk::default());
    node.start(&mut desk);
    assert_eq!(desk.kinds(), [Kind::Status]);
    let mut buffer = [0; 64];
    let measurement = Measurement { tick: Tick(0), output: SVector::<Scalar, OUTPUTS>::zeros() };
    node.take(wire::encode_measurement(&measurement, &mut buffer).expect("there is room"), &mut desk);
    node.period_over(&mut desk);
    assert_eq!(desk.kinds(), []);
    assert_eq!(desk.notices, [Notice::Rejected(Kind::Measurement as u8)]);
}

#[test]
fn each_cycle_that_begins_brings_a_control_frame_and_its_end() {
    let (mut node, mut desk) = (node(), Desk::default());
    for tick in 5..8 {
        desk.clock(&mut node, tick, STEPPED);
        assert_eq!(desk.kinds(), [Kind::Control, Kind::Ran], "cycle {tick}");
    }
    assert_eq!(desk.notices, [Notice::Aligned(Tick(5))]);
    assert_eq!(desk.restarts, 3, "the timer begins anew with each cycle");
}

#[test]
fn a_node_whose_clock_frame_is_lost_goes_on_by_its_timer() {
    let (mut node, mut desk) = (node(), Desk::default());
    desk.clock(&mut node, 5, RUNNING);
    node.period_over(&mut desk);
    desk.clock(&mut node, 6, RUNNING);
    desk.clock(&mut node, 7, RUNNING);
    assert_eq!(desk.kinds(), [Kind::Control, Kind::Ran].repeat(3), "cycles 5, 6 and 7, each once");
}

#[test]
fn a_clock_that_jumps_is_told_of_and_taken_when_three_frames_in_a_row_say_so() {
    let (mut node, mut desk) = (node(), Desk::default());
    desk.clock(&mut node, 5, RUNNING);
    desk.clock(&mut node, 2000, RUNNING);
    desk.clock(&mut node, 6, RUNNING);
    let refused = Notice::ClockRefused(Tick(2000));
    assert_eq!(desk.notices, [Notice::Aligned(Tick(5)), refused], "one wrong frame among right ones");
    assert_eq!(desk.kinds(), [Kind::Control, Kind::Ran].repeat(2), "cycles 5 and 6");
    desk.notices.clear();
    for tick in [20, 21, 22] {
        desk.clock(&mut node, tick, RUNNING);
    }
    let told = [20, 21].map(|tick| Notice::ClockRefused(Tick(tick)));
    assert_eq!(desk.notices, [&told[..], &[Notice::Realigned(Tick(22))]].concat());
}

#[test]
fn a_node_that_hears_no_sensor_says_so_and_falls_silent_when_its_loop_is_lost() {
    let (mut node, mut desk) = (node(), Desk::default());
    for tick in 5..500 {
        desk.clock(&mut node, tick, STEPPED);
        let is_lost = matches!(desk.notices.last(), Some(Notice::Health(health)) if health.is_lost());
        let kinds = desk.kinds();
        assert_eq!(kinds.contains(&Kind::Control), !is_lost, "cycle {tick}");
        assert_eq!(kinds.last(), Some(&Kind::Ran), "cycle {tick}");
    }
    let told: Vec<_> = desk
        .notices
        .iter()
        .filter_map(|notice| if let Notice::Health(health) = notice { Some(*health) } else { None })
        .collect();
    assert_eq!(told.first(), Some(&Health::Degraded(Cause::NotMeasured)));
    assert_eq!(told.last(), Some(&Health::Lost(Cause::NotMeasured)));
    assert!(told.len() < 8, "{told:?}");
}

#[test]
fn a_node_that_is_asked_tells_how_it_is() {
    let (mut node, mut desk) = (node(), Desk::default());
    desk.clock(&mut node, 5, STEPPED);
    desk.sent.clear();
    let mut buffer = [0; wire::LONGEST_SERVICE];
    let question = wire::encode_service::<Scalar, _>(Tick(0), &wire::Question {}, &mut buffer);
    node.take(question.expect("there is room"), &mut desk);
    let (tick, status) = wire::decode_service::<Scalar, Status>(&desk.sent[0]).expect("a status");
    assert_eq!(tick, Tick(6), "the cycle that comes next");
    assert_eq!((status.cycles, status.stack, status.variables, status.overruns), (1, 100, 20, 3));
}

/// A law of nothing but one number, as a blob of the plant `id`.
fn blob(id: DesignId) -> Vec<u8> {
    let shape = Shape {
        length: SEQUENCE_LENGTH,
        states: STATES,
        inputs: INPUTS,
        default_input: ACTUATOR.default_input,
    };
    let rows = SEQUENCE_LENGTH * INPUTS;
    let lx = vec![-1.0; rows * STATES];
    let m = vec![0.0; rows * ACTUATOR.default_input.in_flight(SEQUENCE_LENGTH) * INPUTS];
    let arrival = vec![0.5; SEQUENCE_LENGTH * (SEQUENCE_LENGTH - 1) / 2];
    let mut buffer = vec![0; encoded_len(&shape, BYTES)];
    encode::<Scalar>(id, &shape, &Tables::check(&lx, &m, &arrival).expect("numbers"), &mut buffer)
        .expect("gains")
        .to_vec()
}

/// Sends a blob to the node; returns its last answer.
fn send(node: &mut Node<'_, Sent<'_>>, desk: &mut Desk, blob: &[u8]) -> GainsAnswer {
    let mut answer = GainsAnswer { received: 0, verdict: Verdict::Incomplete };
    while answer.verdict == Verdict::Incomplete {
        let offset = usize::from(answer.received);
        let bytes = &blob[offset..blob.len().min(offset + 32)];
        let part = GainsPart { transfer: 1, offset: answer.received, total: blob.len() as u16, bytes };
        let mut buffer = vec![0; wire::gains_part_len(bytes.len())];
        desk.sent.clear();
        node.take(wire::encode_gains_part::<Scalar>(&part, &mut buffer).expect("there is room"), desk);
        answer = wire::decode_service::<Scalar, _>(&desk.sent[0]).expect("an answer").1;
    }
    desk.sent.clear();
    answer
}

#[test]
fn gains_of_the_plant_are_in_force_from_the_next_cycle_on_and_others_never() {
    let sequence_after = |id: DesignId| {
        let (mut node, mut desk) = (node(), Desk::default());
        desk.clock(&mut node, 0, STEPPED);
        let answer = send(&mut node, &mut desk, &blob(id));
        desk.clock(&mut node, 1, STEPPED);
        (answer.verdict, desk.sent[0].clone())
    };
    let designed = {
        let (mut node, mut desk) = (node(), Desk::default());
        desk.clock(&mut node, 0, STEPPED);
        desk.sent.clear();
        desk.clock(&mut node, 1, STEPPED);
        desk.sent[0].clone()
    };
    let (verdict, sequence) = sequence_after(DESIGN_ID);
    assert_eq!(verdict, Verdict::InForce);
    assert_ne!(sequence, designed);
    let (verdict, sequence) = sequence_after(DesignId(DESIGN_ID.0 ^ 1));
    assert_eq!(verdict, Verdict::Design);
    assert_eq!(sequence, designed);
}
