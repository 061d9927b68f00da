//! A controller node whose memory has changed by itself says so once, sends nothing any more, and nothing but a reset changes that.

use slqg::Tick;
use slqg::controller::Law;
use slqg::health::{Cause, Health};
use slqg::wire::{GainsAnswer, GainsPart, Kind, Verdict};
use slqg_nodes::board::Notice;
use slqg_nodes::controller::Node;
use slqg_nodes::design::{INPUTS, Memory, STATES, Scalar};
use slqg_nodes::laws::Laws;

mod desk;
use desk::{Desk, STEPPED};

/// Gains beside the design's, whose memory changes by itself after so many looks.
struct Failing(u32);

impl Laws for Failing {
    fn law(&self) -> Option<Law<'_, Scalar, STATES, INPUTS>> {
        None
    }

    fn take(&mut self, _part: &GainsPart<'_>) -> GainsAnswer {
        GainsAnswer { received: 0, verdict: Verdict::Dimensions }
    }

    fn check_memory(&mut self, _numbers: usize) -> bool {
        self.0 = self.0.saturating_sub(1);
        // It was wrong at one look only.
        self.0 != 1
    }
}

fn node_that_fails_in_cycle(cycle: u32) -> Node<'static, Failing> {
    Node::new(Box::leak(Box::new(Memory::new())), Box::leak(Box::new(Failing(cycle + 2))))
}

#[test]
fn a_fault_is_told_once_and_ends_sending_for_good_also_over_a_clock_that_jumps() {
    let (mut node, mut desk) = (node_that_fails_in_cycle(3), Desk::default());
    let mut kinds = Vec::new();
    for tick in (0..8).chain(1000..1010) {
        desk.clock(&mut node, tick, STEPPED);
        kinds.push(desk.kinds());
    }
    let is_sent: Vec<bool> = kinds.iter().map(|kinds| kinds.contains(&Kind::Control)).collect();
    let expected: Vec<bool> = (0..18).map(|call| call <= 3).collect();
    assert_eq!(is_sent, expected);
    assert!(desk.notices.contains(&Notice::Realigned(Tick(1002))));
    let lost = Notice::Health(Health::Lost(Cause::Memory));
    assert_eq!(desk.notices.iter().filter(|notice| **notice == lost).count(), 1, "{:?}", desk.notices);
}

#[test]
fn tables_that_are_as_they_were_compiled_are_no_fault_from_the_start_and_for_one_that_joins() {
    for start in [0, 77] {
        let (mut node, mut desk) = (node_that_fails_in_cycle(u32::MAX - 2), Desk::default());
        for tick in start..start + 100 {
            desk.clock(&mut node, tick, STEPPED);
            assert!(desk.kinds().contains(&Kind::Control), "cycle {tick}");
        }
        let lost = Notice::Health(Health::Lost(Cause::Memory));
        assert!(!desk.notices.contains(&lost));
    }
}
