//! Error counters, bus-off and the way back.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slqg_links::can::{
    Bus, Confinement, Errors, Event, Fate, Format, Frame, Id, NodeId, Origin, Phase, Recovery, Settings,
    Stuffing, Time, What,
};

const BIT: Time = 8000;
/// A disturbed SOF, the longest error flag, delimiter, intermission.
const FAILED_AT_ONCE: Time = (1 + 12 + 8 + 3) * BIT;
/// So near to 1 that every frame fails in its first bit.
const CERTAIN: f64 = 1.0 - 1e-16;
const SECOND: Time = 1_000_000_000;

fn id(value: u16) -> Id {
    Id::base(value).unwrap()
}

fn frame(value: u16) -> Frame {
    Frame::new(id(value), Format::Classic, &[0x5A; 8]).unwrap()
}

fn bus(errors: Errors, seed: u64) -> Bus {
    let settings = Settings { errors, stuffing: Stuffing::Worst, queue: 1000, ..Settings::new(125_000, 3) };
    Bus::new(settings, ChaCha8Rng::seed_from_u64(seed)).unwrap()
}

fn hopeless() -> Bus {
    bus(Errors::Independent { probability: CERTAIN }, 0)
}

fn node_events(events: &[Event]) -> Vec<(Time, What)> {
    let of_nodes = |event: &&Event| matches!(event.what, What::BusOff { .. } | What::Recovered { .. });
    events.iter().filter(of_nodes).map(|event| (event.at, event.what)).collect()
}

#[test]
fn counters_follow_the_rules_up_to_bus_off() {
    let mut bus = hopeless();
    bus.offer(0, NodeId(0), frame(0x100), 1).unwrap();
    let mut start = 0;
    for attempt in 1..=32u16 {
        bus.run_until(start + BIT - 1);
        assert_eq!(bus.confinement(NodeId(0)).unwrap().1, 8 * (attempt - 1));
        bus.run_until(start + BIT);
        let (state, transmit, receive) = bus.confinement(NodeId(0)).unwrap();
        assert_eq!((transmit, receive), (8 * attempt, 0), "TEC + 8 for each error");
        let expected = match attempt {
            1..=15 => Confinement::Active,
            16..=31 => Confinement::Passive,
            _ => Confinement::Off,
        };
        assert_eq!(state, expected, "TEC {transmit}");
        assert_eq!(bus.confinement(NodeId(1)).unwrap(), (Confinement::Active, 0, attempt), "REC + 1");
        // An error-passive sender waits 8 bits more.
        start += FAILED_AT_ONCE + if attempt >= 16 { 8 * BIT } else { 0 };
    }
    assert_eq!(bus.statistics().error_frames, 32);
    assert_eq!(bus.statistics().messages[0].retransmissions, 31);
}

#[test]
fn bus_off_ends_on_an_idle_bus_after_128_times_11_recessive_bits() {
    let mut bus = hopeless();
    bus.offer(0, NodeId(0), frame(0x100), 1).unwrap();
    let events = bus.run_until(SECOND / 50);
    let off = 31 * FAILED_AT_ONCE + 16 * 8 * BIT + BIT;
    // Counted from the first bit of the error delimiter after the flag of 12 bits.
    let back = off + 12 * BIT + 128 * 11 * BIT;
    let node = NodeId(0);
    assert_eq!(node_events(&events), [(off, What::BusOff { node }), (back, What::Recovered { node })]);
    // The frame stayed in the queue and is tried again at once: its next attempt fails as well.
    bus.run_until(back + BIT);
    let statistics = bus.statistics();
    assert_eq!((statistics.bus_offs, statistics.messages[0].undecided()), (1, 1));
    assert!(statistics.messages[0].retransmissions > 32);
}

#[test]
fn without_recovery_a_node_stays_off_and_its_frames_wait() {
    let errors = Errors::Independent { probability: CERTAIN };
    let settings = Settings { errors, recovery: Recovery::Never, ..Settings::new(125_000, 2) };
    let mut bus = Bus::new(settings, ChaCha8Rng::seed_from_u64(0)).unwrap();
    bus.offer(0, NodeId(0), frame(0x100), 1).unwrap();
    let events = bus.run_until(10 * SECOND);
    assert_eq!(events.len(), 1, "{events:?}");
    assert_eq!(bus.confinement(NodeId(0)).unwrap().0, Confinement::Off);
    assert_eq!((bus.statistics().messages[0].undecided(), bus.statistics().error_frames), (1, 32));
    assert!(bus.withdraw(1), "it still waits");
}

/// A bus that begins with errors in every frame until node 0 is bus-off, and has none for long after that.
/// Returns the bus and the time of bus-off.
fn recently_off() -> (Bus, Time) {
    let phases = Errors::Bursts {
        good: Phase { mean: 1.0, probability: 0.0 },
        bad: Phase { mean: 0.02, probability: CERTAIN },
    };
    for seed in 0..100_000 {
        let prepared = || {
            let mut bus = bus(phases, seed);
            bus.offer(0, NodeId(0), frame(0x100), 1).unwrap();
            let off = node_events(&bus.run_until(31 * FAILED_AT_ONCE + 16 * 8 * BIT + BIT));
            off.first().map(|&(at, _)| (bus, at))
        };
        let Some((mut trial, _)) = prepared() else { continue };
        // Node 1 asks for the bus all the time, so errors would show.
        for tag in 0..500 {
            trial.offer(trial.now() + 22 * BIT, NodeId(1), frame(0x200), tag).unwrap();
        }
        trial.run_until(SECOND / 2);
        if trial.statistics().error_frames == 32 {
            return prepared().unwrap();
        }
    }
    panic!("one seed in ten thousand or so should fit")
}

#[test]
fn on_a_busy_bus_every_frame_counts_as_one_sequence() {
    let (mut bus, off) = recently_off();
    let free = off + (12 + 8 + 3) * BIT;
    for tag in 10..300 {
        bus.offer(free, NodeId(1), frame(0x200), tag).unwrap();
    }
    let events = bus.run_until(SECOND / 2);
    // One sequence after the error frame, then one at the end of each of 127 frames of 135 bits with intermission.
    let back = free + 127 * 135 * BIT;
    assert_eq!(node_events(&events), [(back, What::Recovered { node: NodeId(0) })]);
    // It is back, error-active, and wins the arbitration at that very bit.
    let own = What::Fate { origin: Origin::Offered(1), fate: Fate::Delivered };
    assert!(events.contains(&Event { at: back + 132 * BIT, what: own }), "{off}");
    assert_eq!(bus.confinement(NodeId(0)).unwrap(), (Confinement::Active, 0, 0));
}

#[test]
fn idle_time_between_frames_counts_in_whole_sequences() {
    let (mut bus, off) = recently_off();
    let free = off + (12 + 8 + 3) * BIT;
    // Every 168 bits a frame of 135: 33 idle bits make 3 sequences; with 32 it would be 2.
    for (gap, per_frame) in [(33, 4), (32, 3)] {
        let mut bus = bus.clone();
        for tag in 0..127u64 {
            let at = free + (tag * (135 + gap) + gap) * BIT;
            bus.offer(at, NodeId(1), frame(0x200), tag + 10).unwrap();
        }
        let events = bus.run_until(SECOND);
        let (frames, left) = (127 / per_frame, 127 % per_frame);
        let last = free + frames * (135 + gap) * BIT;
        let back = if left == 0 { last } else { last + left * 11 * BIT };
        assert_eq!(node_events(&events), [(back, What::Recovered { node: NodeId(0) })], "gap {gap}");
    }
    assert!(bus.run_until(SECOND).len() == 2);
}

#[test]
fn an_error_passive_sender_lets_others_go_first() {
    let mut bus = hopeless();
    bus.offer(0, NodeId(0), frame(0x100), 1).unwrap();
    bus.offer(0, NodeId(1), frame(0x200), 2).unwrap();
    let sixteenth = 15 * FAILED_AT_ONCE + BIT;
    bus.run_until(sixteenth);
    assert_eq!(bus.confinement(NodeId(1)).unwrap().1, 0, "the smaller identifier always wins");
    bus.run_until(sixteenth + FAILED_AT_ONCE);
    assert_eq!(bus.confinement(NodeId(1)).unwrap().1, 8, "the other one goes while the passive sender waits");
    assert_eq!(bus.confinement(NodeId(0)).unwrap().0, Confinement::Passive);
}

#[test]
fn counters_fall_with_every_good_frame() {
    let (mut bus, _) = recently_off();
    let receive = |bus: &Bus, node| bus.confinement(NodeId(node)).unwrap().2;
    let before = receive(&bus, 2);
    assert_eq!(before, 32);
    for tag in 10..15 {
        bus.offer(bus.now() + SECOND / 1000, NodeId(1), frame(0x200), tag).unwrap();
    }
    bus.run_until(bus.now() + 10 * SECOND / 1000);
    assert_eq!((receive(&bus, 2), receive(&bus, 1)), (before - 5, before));
}
