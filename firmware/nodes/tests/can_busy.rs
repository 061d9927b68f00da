//! A node whose CAN controller has no room: what waits, what is replaced, and what is counted.

use embedded_can::ErrorKind;
use slqg::Age;
use slqg::wire::Role;
use slqg_nodes::can::{Line, Lost, taken_by};

// Each file of tests uses a part of it.
#[allow(dead_code)]
mod memory_bus;

use memory_bus::frames::{
    Loop, acknowledgement, all_received, begins, carry, control, line, measurement, packed,
};
use memory_bus::{Memory, form};

#[test]
fn a_full_mailbox_keeps_the_newest_frame_of_each_kind_and_counts_those_it_replaces() {
    let mut node: Loop = Line::new(Memory::with_room(0), form(), &[]);
    let mut receiver = line(taken_by(Role::Controller));
    for tick in 1..=3 {
        node.send(&acknowledgement(tick, &[Age::Steps(0), Age::Steps(1)]));
    }
    node.send(&measurement(3, [0.25, 0.5]));
    assert_eq!(node.lost(), Lost { replaced: 2, ..Lost::default() });
    node.bus().room = 3;
    node.flush();
    carry(&mut node, &mut receiver);
    let arrived = [measurement(3, [0.25, 0.5]), acknowledgement(3, &[Age::Steps(0), Age::Steps(1)])];
    assert_eq!(all_received(&mut receiver), arrived);
    // Nothing is sent twice.
    node.flush();
    assert!(node.bus().mailboxes.is_empty());
    assert_eq!(node.lost().total(), 2);
}

#[test]
fn a_frame_that_gives_way_to_a_more_urgent_one_goes_later() {
    let mut node: Loop = Line::new(Memory::with_room(1), form(), &[]);
    let mut receiver = line(taken_by(Role::Controller));
    node.send(&acknowledgement(1, &[Age::Empty]));
    node.send(&begins(2));
    assert_eq!(carry(&mut node, &mut receiver).len(), 1);
    assert_eq!(all_received(&mut receiver), [begins(2)]);
    node.flush();
    carry(&mut node, &mut receiver);
    assert_eq!(all_received(&mut receiver), [acknowledgement(1, &[Age::Empty])]);
    assert_eq!(node.lost(), Lost::default());
}

#[test]
fn a_frame_that_gives_way_while_a_newer_one_waits_is_counted() {
    let mut node: Loop = Line::new(Memory::with_room(1), form(), &[]);
    node.send(&acknowledgement(1, &[Age::Empty]));
    node.send(&acknowledgement(2, &[Age::Empty]));
    assert_eq!(node.lost(), Lost::default(), "one in the mailbox, one waits");
    node.send(&begins(3));
    assert_eq!(node.lost(), Lost { replaced: 1, ..Lost::default() });
    node.bus().mailboxes.clear();
    node.flush();
    assert_eq!(node.bus().mailboxes, [packed(&acknowledgement(2, &[Age::Empty]))]);
}

#[test]
fn an_overrun_is_counted_and_what_follows_it_is_received() {
    let mut actuator = line(taken_by(Role::Actuator));
    actuator.bus().received.push_back(Err(ErrorKind::Overrun));
    actuator.bus().received.push_back(Ok(packed(&control::<1>(5, &[0.125]))));
    assert!(all_received(&mut actuator).is_empty());
    assert_eq!(all_received(&mut actuator), [control::<1>(5, &[0.125])]);
    assert_eq!(actuator.lost(), Lost { overruns: 1, ..Lost::default() });
}
