//! A bus without errors: arbitration, queues, and what events and figures say.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slqg_links::can::{
    Attempts, Bus, Errors, Event, Fate, Format, Frame, Id, Length, NodeId, Origin, Pattern, Settings, Source,
    Stuffing, Time, What,
};

const BIT: Time = 2000;
const MILLISECOND: Time = 1_000_000;

fn base(value: u16) -> Id {
    Id::base(value).unwrap()
}

fn frame(id: Id) -> Frame {
    Frame::new(id, Format::Classic, &[0x5A; 8]).unwrap()
}

fn bus(settings: Settings) -> Bus {
    Bus::new(settings, ChaCha8Rng::seed_from_u64(7)).unwrap()
}

fn idle_bus() -> Bus {
    bus(Settings::new(500_000, 4))
}

fn periodic(id: Id, node: u16, period: Time, offset: Time) -> Source {
    Source {
        node: NodeId(node),
        id,
        format: Format::Classic,
        bytes: 8,
        pattern: Pattern::Periodic { period, offset, jitter: 0 },
        attempts: Attempts::Unlimited,
    }
}

/// Tags and times of the frames with this fate.
fn with_fate(events: &[Event], wanted: Fate) -> Vec<(u64, Time)> {
    let tag = |event: &Event| match event.what {
        What::Fate { origin: Origin::Offered(tag), fate } if fate == wanted => Some((tag, event.at)),
        _ => None,
    };
    events.iter().filter_map(tag).collect()
}

#[test]
fn a_frame_offered_to_an_idle_bus_is_delivered_its_length_later() {
    let mut bus = idle_bus();
    let frame = frame(base(0x123));
    let duration = Length::actual(&frame).duration(bus.rates());
    bus.offer(777, NodeId(0), frame, 1).unwrap();
    assert!(bus.run_until(777 + duration - 1).is_empty());
    let events = bus.run_until(777 + duration);
    assert_eq!(with_fate(&events, Fate::Delivered), [(1, 777 + duration)]);
}

#[test]
fn without_errors_and_other_traffic_no_frame_waits() {
    let mut bus = idle_bus();
    for round in 0..1000u64 {
        let at = round * MILLISECOND + round * 37;
        let frame = Frame::new(base(0x100), Format::Classic, &round.to_be_bytes()).unwrap();
        let duration = Length::actual(&frame).duration(bus.rates());
        bus.offer(at, NodeId(0), frame, round).unwrap();
        assert_eq!(
            with_fate(&bus.run_until(at + MILLISECOND / 2), Fate::Delivered),
            [(round, at + duration)]
        );
    }
    let statistics = bus.statistics();
    let message = statistics.message(Origin::Offered(0), base(0x100)).unwrap();
    assert_eq!((message.offered, message.delivered, message.retransmissions), (1000, 1000, 0));
    assert!(message.response.max().unwrap() <= 132 * BIT && message.response.min().unwrap() >= 108 * BIT);
}

#[test]
fn of_frames_that_start_together_the_smaller_identifier_wins() {
    let mut bus = idle_bus();
    let extended = |value| Id::extended(value).unwrap();
    let order = [base(0x0FF), base(0x100), extended(0x100 << 18), extended((0x100 << 18) + 1)];
    for (tag, node) in [(3, 0), (1, 1), (0, 2), (2, 3)] {
        bus.offer(0, NodeId(node), frame(order[tag]), tag as u64).unwrap();
    }
    let events = bus.run_until(2 * MILLISECOND);
    let delivered = with_fate(&events, Fate::Delivered);
    assert_eq!(delivered.iter().map(|&(tag, _)| tag).collect::<Vec<_>>(), [0, 1, 2, 3]);
    // One after the other, three bits of intermission between them.
    for (pair, id) in delivered.windows(2).zip(&order[1..]) {
        assert_eq!(pair[1].1 - pair[0].1, Length::actual(&frame(*id)).duration(bus.rates()) + 3 * BIT);
    }
}

#[test]
fn a_frame_offered_when_an_arbitration_starts_takes_part_in_it() {
    let mut bus = idle_bus();
    bus.offer(1000, NodeId(0), frame(base(0x200)), 1).unwrap();
    assert!(bus.run_until(1000).is_empty());
    bus.offer(1000, NodeId(1), frame(base(0x100)), 2).unwrap();
    let delivered = with_fate(&bus.run_until(MILLISECOND), Fate::Delivered);
    assert_eq!(delivered.iter().map(|&(tag, _)| tag).collect::<Vec<_>>(), [2, 1]);

    // A nanosecond later it is too late: the other frame is on the bus.
    let mut bus = idle_bus();
    bus.offer(1000, NodeId(0), frame(base(0x200)), 1).unwrap();
    bus.run_until(1001);
    bus.offer(1001, NodeId(1), frame(base(0x100)), 2).unwrap();
    let delivered = with_fate(&bus.run_until(MILLISECOND), Fate::Delivered);
    assert_eq!(delivered.iter().map(|&(tag, _)| tag).collect::<Vec<_>>(), [1, 2]);
}

#[test]
fn a_node_sends_its_most_urgent_frame_first_and_equal_ones_in_order() {
    let mut bus = idle_bus();
    for (tag, id) in [(0, 0x300), (1, 0x200), (2, 0x300), (3, 0x100)] {
        bus.offer(0, NodeId(0), frame(base(id)), tag).unwrap();
    }
    let delivered = with_fate(&bus.run_until(2 * MILLISECOND), Fate::Delivered);
    assert_eq!(delivered.iter().map(|&(tag, _)| tag).collect::<Vec<_>>(), [3, 1, 0, 2]);
}

#[test]
fn a_full_queue_refuses_and_the_frame_on_the_bus_counts() {
    let mut bus = bus(Settings { queue: 2, ..Settings::new(500_000, 2) });
    bus.offer(0, NodeId(0), frame(base(0x100)), 1).unwrap();
    for tag in 2..5 {
        bus.offer(10, NodeId(0), frame(base(0x100)), tag).unwrap();
    }
    let events = bus.run_until(MILLISECOND);
    assert_eq!(with_fate(&events, Fate::Refused), [(3, 10), (4, 10)]);
    assert_eq!(with_fate(&events, Fate::Delivered).len(), 2);
}

#[test]
fn a_waiting_frame_can_be_withdrawn_but_not_one_on_the_bus() {
    let mut bus = idle_bus();
    bus.offer(0, NodeId(0), frame(base(0x100)), 1).unwrap();
    bus.offer(0, NodeId(0), frame(base(0x101)), 2).unwrap();
    bus.offer(MILLISECOND, NodeId(0), frame(base(0x102)), 3).unwrap();
    bus.run_until(50_000);
    assert!(!bus.withdraw(1) && bus.withdraw(2) && bus.withdraw(3) && !bus.withdraw(2));
    let events = bus.run_until(2 * MILLISECOND);
    assert_eq!(with_fate(&events, Fate::Delivered).len(), 1);
    assert!(!bus.withdraw(1), "delivered");
    let statistics = bus.statistics();
    let fates: Vec<_> =
        statistics.messages.iter().map(|row| (row.offered, row.delivered, row.withdrawn)).collect();
    assert_eq!(fates, [(1, 1, 0), (1, 0, 1), (1, 0, 1)]);
}

#[test]
fn a_single_shot_frame_that_loses_arbitration_is_aborted() {
    let mut bus = idle_bus();
    bus.offer(0, NodeId(0), frame(base(0x100)), 0).unwrap();
    for (tag, attempts) in [(1, Attempts::Once), (2, Attempts::UntilError), (3, Attempts::Unlimited)] {
        let frame = frame(base(0x100 + tag)).with_attempts(attempts);
        bus.offer(0, NodeId(tag), frame, tag.into()).unwrap();
    }
    let events = bus.run_until(2 * MILLISECOND);
    assert_eq!(with_fate(&events, Fate::Aborted), [(1, 0)]);
    assert_eq!(with_fate(&events, Fate::Delivered).len(), 3);
}

#[test]
fn bus_load_is_the_sum_of_its_messages() {
    let sources =
        vec![periodic(base(0x100), 0, 5 * MILLISECOND, 0), periodic(base(0x200), 1, 2 * MILLISECOND, 7)];
    let settings = Settings { sources, stuffing: Stuffing::Worst, ..Settings::new(500_000, 2) };
    let mut bus = bus(settings);
    bus.run_until(1000 * MILLISECOND);
    let statistics = bus.statistics();
    // 135 bits with intermission last 270 us.
    let expected = 0.270 / 5.0 + 0.270 / 2.0;
    assert!((statistics.load() - expected).abs() < 1e-12, "{}", statistics.load());
    assert_eq!(statistics.messages[0].busy, 200 * 270_000);
    assert!(statistics.to_string().contains("load 18.90 %"), "{statistics}");
}

#[test]
fn sporadic_frames_keep_their_distance() {
    let pattern = Pattern::Sporadic { minimum: 3 * MILLISECOND, extra: 2 * MILLISECOND };
    let sources = vec![Source { pattern, ..periodic(base(0x100), 0, 1, 0) }];
    let mut bus = bus(Settings { sources, log: true, ..Settings::new(500_000, 2) });
    bus.run_until(50_000 * MILLISECOND);
    let due: Vec<Time> = bus.log().unwrap().records.iter().map(|record| record.due).collect();
    assert!(due.windows(2).all(|pair| pair[1] - pair[0] >= 3 * MILLISECOND));
    // One in e^2 is more than twice the mean beyond the minimum.
    let long =
        due.windows(2).filter(|pair| pair[1] - pair[0] > 7 * MILLISECOND).count() as f64 / due.len() as f64;
    assert!((long - (-2.0f64).exp()).abs() < 0.015, "{long}");
    assert!((9_500..10_500).contains(&due.len()), "{} frames in 50 s at 5 ms on average", due.len());
}

#[test]
fn jitter_delays_by_at_most_what_it_says_and_does_not_add_up() {
    let pattern = Pattern::Periodic { period: MILLISECOND, offset: 500, jitter: MILLISECOND };
    let sources = vec![Source { pattern, ..periodic(base(0x100), 0, 1, 0) }];
    let mut bus = bus(Settings { sources, log: true, ..Settings::new(500_000, 2) });
    bus.run_until(1000 * MILLISECOND);
    let records = &bus.log().unwrap().records;
    assert!(records.iter().enumerate().all(|(k, record)| record.due == 500 + k as u64 * MILLISECOND));
    let response = bus.statistics().messages[0].response;
    assert!(response.max().unwrap() > 900_000 && response.min().unwrap() < 300_000, "{response:?}");
    assert!((650_000.0..850_000.0).contains(&response.mean().unwrap()), "{response:?}");
}

#[test]
fn the_log_is_a_table_of_every_frame() {
    let mut bus = bus(Settings { log: true, queue: 1, ..Settings::new(500_000, 2) });
    bus.offer(0, NodeId(0), frame(base(0x123)), 8).unwrap();
    bus.offer(0, NodeId(0), frame(base(0x123)), 9).unwrap();
    bus.run_until(MILLISECOND);
    let table = bus.log().unwrap().to_string();
    assert_eq!(table.lines().count(), 3);
    assert!(table.contains("refused   tag 9") && table.contains("delivered tag 8"), "{table}");
}

#[test]
fn the_same_seed_gives_the_same_events() {
    let run = |seed| {
        let pattern = Pattern::Sporadic { minimum: MILLISECOND, extra: MILLISECOND };
        let sources =
            vec![Source { pattern, ..periodic(base(0x100), 0, 1, 0) }, periodic(base(0x80), 1, 300_000, 0)];
        let errors = Errors::Independent { probability: 1e-3 };
        let settings = Settings { sources, errors, ..Settings::new(500_000, 3) };
        Bus::new(settings, ChaCha8Rng::seed_from_u64(seed)).unwrap().run_until(500 * MILLISECOND)
    };
    assert_eq!(run(1), run(1));
    assert_ne!(run(1), run(2));
}

#[test]
fn running_in_small_steps_changes_nothing() {
    let sources = vec![periodic(base(0x100), 0, 600_000, 0), periodic(base(0x80), 1, 410_000, 0)];
    let errors = Errors::Independent { probability: 1e-3 };
    let settings = Settings { sources, errors, ..Settings::new(500_000, 3) };
    let whole = bus(settings.clone()).run_until(100 * MILLISECOND);
    let mut small = bus(settings);
    let steps: Vec<Event> = (1..=100_000).flat_map(|step| small.run_until(step * 1000)).collect();
    assert_eq!(whole, steps);
}
