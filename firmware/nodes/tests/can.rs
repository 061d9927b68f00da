//! Nodes on a CAN bus: what one end sends, the other takes, through drivers made of memory.

use embedded_can::Frame;
use slqg::nalgebra::SVector;
use slqg::wire::can::{Compact, InvalidCompact};
use slqg::wire::{self, Clock, Kind, Ran, Role, Status};
use slqg::{Age, actuator::Applied};
use slqg::{Scalar, Tick};
use slqg_nodes::actuator;
use slqg_nodes::board::{Board, Node, Notice, Usage};
use slqg_nodes::can::{Form, LONGEST, Line, Lost, taken_by};
use slqg_nodes::design::{INPUTS, OUTPUTS};

mod memory_bus;

use memory_bus::frames::{
    acknowledgement, all_received, begins, carry, clock, control, hear, line, measurement, packed,
};
use memory_bus::{
    ACKNOWLEDGEMENT, BusFrame, CLOCK, CONTROL, DESIGN, MEASUREMENT, Memory, form, grid, identifiers, standard,
};

fn ran(tick: u32) -> Vec<u8> {
    wire::encode_service::<f32, _>(Tick(tick), &Ran { sent: true, duration: 1 }, &mut [0; 64])
        .expect("room")
        .to_vec()
}

#[test]
fn what_one_node_sends_another_takes_and_on_the_bus_it_is_the_compact_form() {
    let mut sensor = line(&[]);
    let mut controller = line(taken_by(Role::Controller));
    let mut actuator = line(taken_by(Role::Actuator));
    let compact = Compact::new(DESIGN, identifiers(), grid::<1>(0.125), grid::<2>(0.25)).expect("a form");
    let packed = |frame: &[u8]| compact.pack::<BusFrame>(frame).expect("fits");
    let tick = 0x0102_0304;
    // Both are told the cycle: half a tick is near to it from then on.
    sensor.send(&begins(tick));
    let told = carry(&mut sensor, &mut controller);
    actuator.bus().received.extend(told.into_iter().map(Ok));
    assert_eq!(all_received(&mut controller), [begins(tick)]);
    assert_eq!(all_received(&mut actuator), [begins(tick)]);

    let measured = measurement(tick, [1.0, -2.5]);
    sensor.send(&measured);
    assert_eq!(carry(&mut sensor, &mut controller), [packed(&measured)]);
    assert_eq!(all_received(&mut controller), [measured]);

    let sequence = control::<1>(tick, &[0.5, -1.0, 0.125]);
    controller.send(&sequence);
    assert_eq!(carry(&mut controller, &mut actuator), [packed(&sequence)]);
    assert_eq!(all_received(&mut actuator), [sequence]);

    let told = acknowledgement(tick, &[Age::Steps(0), Age::Empty, Age::Steps(3)]);
    actuator.send(&told);
    assert_eq!(carry(&mut actuator, &mut controller), [packed(&told)]);
    assert_eq!(all_received(&mut controller), [told]);

    for line in [&sensor, &controller, &actuator] {
        assert_eq!(line.lost(), Lost::default());
    }
}

#[test]
fn the_clock_travels_as_the_bytes_of_the_wire_format() {
    for (tick, told, data) in [
        (0x0102_0304, Clock { begins: true, period_us: 20_000 }, [4, 3, 2, 1, 0x20, 0x4e, 0x80, 0x27]),
        (7, Clock { begins: false, period_us: 0 }, [7, 0, 0, 0, 0, 0, 0, 0x8b]),
        (u32::MAX, Clock { begins: true, period_us: 0 }, [0xff, 0xff, 0xff, 0xff, 0, 0, 0x80, 0x03]),
        // The longest period there is.
        (1, Clock { begins: false, period_us: 0x7f_ffff }, [1, 0, 0, 0, 0xff, 0xff, 0x7f, 0xf5]),
    ] {
        let mut sender = line(&[]);
        let mut node = line(taken_by(Role::Actuator));
        sender.send(&clock(tick, told));
        let sent = carry(&mut sender, &mut node);
        assert_eq!(sent, [BusFrame::new(standard(CLOCK), &data).expect("8 bytes")]);
        assert_eq!(all_received(&mut node), [clock(tick, told)]);
        // Any bit of it that is wrong is noticed.
        for bit in 0..64 {
            let mut data = data;
            data[bit / 8] ^= 1 << (bit % 8);
            hear(&mut node, CLOCK, &data);
        }
        assert!(all_received(&mut node).is_empty());
        assert_eq!(node.lost(), Lost { refused: 64, ..Lost::default() });
    }
}

#[test]
fn a_period_that_does_not_fit_is_refused_and_counted() {
    let mut sender = line(&[]);
    sender.send(&clock(1, Clock { begins: true, period_us: 0x80_0000 }));
    assert!(sender.bus().mailboxes.is_empty());
    assert_eq!(sender.lost(), Lost { refused: 1, ..Lost::default() });
}

#[test]
fn frames_of_another_plant_or_an_older_round_are_refused_and_counted() {
    let mut actuator = line(taken_by(Role::Actuator));
    let others = Form::<f32, 1, 2>::new(
        slqg::blob::DesignId(DESIGN.0 ^ 0x55),
        standard(CLOCK),
        identifiers(),
        grid(0.125),
        grid(0.25),
    )
    .expect("a form");
    let sequence = |tick| control::<1>(tick, &[0.5, -1.0, 0.125]);
    actuator.bus().received.push_back(Ok(packed(&begins(0x0001_0005))));
    for frame in [
        others.pack(&begins(0x0001_0006)).expect("fits"),
        others.pack(&sequence(0x0001_0005)).expect("fits"),
        packed(&sequence(0x0000_0005)),
        packed(&sequence(0x0001_0005)),
    ] {
        actuator.bus().received.push_back(Ok(frame));
    }
    assert_eq!(all_received(&mut actuator), [begins(0x0001_0005), sequence(0x0001_0005)]);
    assert_eq!(actuator.lost(), Lost { refused: 3, ..Lost::default() });
}

#[test]
fn frames_of_strangers_and_of_other_nodes_are_ignored_and_not_counted() {
    let mut actuator = line(taken_by(Role::Actuator));
    for id in [0, 0x7f, 0x123, 0x7ff, MEASUREMENT, ACKNOWLEDGEMENT] {
        hear(&mut actuator, id, &[5, 0, 1, 0]);
    }
    actuator.bus().received.push_back(Ok(packed(&control::<1>(5, &[0.125]))));
    assert_eq!(all_received(&mut actuator), [control::<1>(5, &[0.125])]);
    assert_eq!(actuator.lost(), Lost::default());
}

#[test]
fn what_has_an_identifier_of_the_loop_but_not_its_form_is_counted() {
    let mut controller = line(taken_by(Role::Controller));
    for len in 0..8 {
        hear(&mut controller, CLOCK, &[0; 8][..len]);
    }
    let remote = BusFrame::new_remote(standard(CLOCK), 8).expect("8 bytes");
    controller.bus().received.push_back(Ok(remote));
    hear(&mut controller, MEASUREMENT, &[0; 8]);
    hear(&mut controller, ACKNOWLEDGEMENT, &[0; 2]);
    assert!(all_received(&mut controller).is_empty());
    assert_eq!(controller.lost(), Lost { refused: 11, ..Lost::default() });
    // Longer than the form has room for.
    controller.send(&control::<1>(9, &[0.0; 4]));
    assert!(controller.bus().mailboxes.is_empty());
    assert_eq!(controller.lost().total(), 12);
}

#[test]
fn service_frames_stay_off_the_bus_but_tell_the_line_which_cycle_it_is() {
    let mut controller = line(taken_by(Role::Controller));
    // Longer without a clock than half a tick reaches.
    controller.send(&ran(0x0003_0000));
    let status = Status {
        role: Role::Controller,
        cycles: 0,
        realigned: 0,
        rejected: 0,
        overruns: 0,
        stack: 0,
        variables: 0,
    };
    let status = wire::encode_service::<f32, _>(Tick(7), &status, &mut [0; 64]).expect("room").to_vec();
    controller.send(&status);
    assert!(controller.bus().mailboxes.is_empty());
    controller.bus().received.push_back(Ok(packed(&measurement(0x0002_ffff, [0.0, 1.0]))));
    assert_eq!(all_received(&mut controller), [measurement(0x0002_ffff, [0.0, 1.0])]);
    assert_eq!(controller.lost(), Lost::default());
}

#[test]
fn a_clock_that_jumps_does_not_move_the_ticks_of_a_node_that_has_told_its_own() {
    let mut actuator = line(taken_by(Role::Actuator));
    actuator.bus().received.push_back(Ok(packed(&begins(0x0001_0000))));
    assert_eq!(all_received(&mut actuator), [begins(0x0001_0000)]);
    actuator.send(&acknowledgement(0x0001_0000, &[Age::Empty]));
    let sequence = control::<1>(0x0001_0001, &[0.5]);
    for frame in [begins(0x0009_0000), sequence.clone()] {
        actuator.bus().received.push_back(Ok(packed(&frame)));
    }
    // The jump goes to the node, which does not believe it; the sequence is still of the cycle that it is of.
    assert_eq!(all_received(&mut actuator), [begins(0x0009_0000), sequence]);
    assert_eq!(actuator.lost(), Lost::default());
}

#[test]
fn a_form_has_four_different_identifiers() {
    let form_of =
        |clock| Form::<f32, 1, 2>::new(DESIGN, standard(clock), identifiers(), grid(1.0), grid(1.0));
    for taken in [MEASUREMENT, CONTROL, ACKNOWLEDGEMENT] {
        assert_eq!(form_of(taken), Err(InvalidCompact::Identifiers));
    }
    let form = form_of(CLOCK).expect("a form");
    assert_eq!(form.identifier(Kind::Clock), Some(standard(CLOCK)));
    assert_eq!(form.identifier(Kind::Status), None);
    assert_eq!(form.kind(standard(CONTROL)), Some(Kind::Control));
    assert_eq!(form.kind(standard(0x123)), None);
}

#[test]
fn the_longest_frame_of_a_line_fits_its_buffer() {
    for values in 1..=3 {
        assert!(wire::measurement_len(values, f64::BYTES) <= LONGEST);
        assert!(wire::control_len(1, values, f64::BYTES) <= LONGEST);
    }
    assert!(wire::acknowledgement_len(wire::can::MOST_CYCLES) <= LONGEST);
    assert!(begins(0).len() <= LONGEST);
}

/// A board with a bus only.
struct Bench {
    line: Line<Memory, f32, INPUTS, OUTPUTS>,
    applied: Vec<(Tick, SVector<f32, INPUTS>, Age)>,
}

impl Board for Bench {
    fn send(&mut self, frame: &[u8]) {
        self.line.send(frame);
    }
    fn restart_period(&mut self) {}
    fn apply(&mut self, applied: &Applied<f32, INPUTS>) {
        self.applied.push((applied.tick, applied.input, applied.age));
    }
    fn ticks(&self) -> u32 {
        0
    }
    fn elapsed(&self, _begin: u32) -> u32 {
        0
    }
    fn usage(&self) -> Usage {
        Usage::default()
    }
    fn note(&mut self, _notice: Notice) {}
}

#[test]
fn an_actuator_node_on_the_bus_plays_the_sequence_it_was_sent() {
    let line = Line::new(Memory::with_room(3), form(), taken_by(Role::Actuator));
    let mut board = Bench { line, applied: Vec::new() };
    let mut node = actuator::Node::new(Box::leak(Box::new(slqg_nodes::design::ACTUATOR_MEMORY)));
    let mut buffer = [0; LONGEST];
    let form = form::<INPUTS, OUTPUTS>();
    // The clock, a sequence for the cycle after next and the one after that, the clock three times more.
    let sequence = control::<INPUTS>(0x0001_0000, &[0.5, -0.25]);
    for frame in [begins(0xffff), begins(0x0001_0000), sequence, begins(0x0001_0001), begins(0x0001_0002)] {
        board.line.bus().received.push_back(Ok(form.pack(&frame).expect("fits")));
        while let Some(frame) = board.line.receive(&mut buffer) {
            node.take(frame, &mut board);
        }
    }
    let inputs: Vec<_> = board.applied.iter().map(|(tick, input, age)| (tick.0, input[0], *age)).collect();
    let played = [
        (0xffff, 0.0, Age::Empty),
        (0x0001_0000, 0.0, Age::Empty),
        (0x0001_0001, -0.25, Age::Steps(1)),
        (0x0001_0002, 0.0, Age::Empty),
    ];
    assert_eq!(inputs, played);
    assert_eq!(board.line.lost().overruns, 0);
    // It has told of the first of them: the default input.
    assert_eq!(board.line.bus().mailboxes.first(), Some(&packed(&acknowledgement(0xffff, &[Age::Empty]))));
}
