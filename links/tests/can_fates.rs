//! Every frame has exactly one fate, whatever happens on the bus.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slqg_links::can::{
    Attempts, Background, Bus, Errors, Event, Fate, Format, Frame, Id, NodeId, Origin, Phase, Settings,
    Statistics, Time, What,
};

const MILLISECOND: Time = 1_000_000;
const UNDECIDED: u8 = 0;
const DELIVERED: u8 = 1;
const OTHERWISE: u8 = 2;

/// Fates of tags, checked as they come.
#[derive(Default)]
struct Fates {
    of: Vec<u8>,
    withdrawn: u64,
}

impl Fates {
    fn decide(&mut self, tag: u64, fate: u8) {
        let known = &mut self.of[tag as usize];
        assert_eq!(*known, UNDECIDED, "tag {tag} has two fates");
        *known = fate;
    }

    fn see(&mut self, events: &[Event]) {
        for event in events {
            match event.what {
                What::Fate { origin: Origin::Offered(tag), fate } => {
                    self.decide(tag, if fate == Fate::Delivered { DELIVERED } else { OTHERWISE });
                }
                What::Duplicate { origin: Origin::Offered(tag) } => {
                    assert_eq!(self.of[tag as usize], DELIVERED)
                }
                _ => {}
            }
        }
    }
}

/// Offers frames of all kinds on a bus with bursts of errors and other traffic until `frames`, other traffic included, were
/// offered, then lets the bus run dry.
fn run(frames: u64) -> Statistics {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let ids: Vec<Id> = (0..4).map(|k| Id::base(0x080 + 0x100 * k).unwrap()).collect();
    let errors = Errors::Bursts {
        good: Phase { mean: 0.2, probability: 1e-5 },
        bad: Phase { mean: 0.02, probability: 2e-2 },
    };
    let sources = Background::load(0.4, 500_000, &ids, 4..8).unwrap().sources;
    let settings = Settings { queue: 4, errors, sources, ..Settings::new(500_000, 8) };
    let mut bus = Bus::new(settings, ChaCha8Rng::seed_from_u64(12)).unwrap();
    let mut fates = Fates::default();
    let all = |bus: &Bus| bus.statistics().messages.iter().map(|row| row.offered).sum::<u64>();
    let mut at = 0;
    while all(&bus) < frames {
        for _ in 0..100 {
            at += random.random_range(0..2 * MILLISECOND / 3);
            let tag = fates.of.len() as u64;
            fates.of.push(UNDECIDED);
            let attempts =
                [Attempts::Unlimited, Attempts::UntilError, Attempts::Once][random.random_range(0..3)];
            let node = random.random_range(0..4);
            let frame = Frame::new(ids[node], Format::Classic, &tag.to_be_bytes()).unwrap();
            bus.offer(at, NodeId(node as u16), frame.with_attempts(attempts), tag).unwrap();
            if random.random_bool(0.05) {
                let old = random.random_range(tag.saturating_sub(5)..=tag);
                if bus.withdraw(old) {
                    fates.decide(old, OTHERWISE);
                    fates.withdrawn += 1;
                }
            }
            fates.see(&bus.run_until(at));
        }
    }
    fates.see(&bus.run_until(at + 60_000 * MILLISECOND));
    assert!(fates.of.iter().all(|&fate| fate != UNDECIDED), "a frame has no fate");
    let statistics = bus.statistics();
    let own: Vec<_> = statistics.messages.iter().filter(|row| row.source.is_none()).collect();
    assert!(own.iter().all(|row| row.undecided() == 0));
    let delivered = fates.of.iter().filter(|&&fate| fate == DELIVERED).count() as u64;
    assert_eq!(own.iter().map(|row| row.delivered).sum::<u64>(), delivered);
    assert_eq!(own.iter().map(|row| row.withdrawn).sum::<u64>(), fates.withdrawn);
    statistics
}

#[test]
fn each_of_a_million_frames_has_exactly_one_fate() {
    let statistics = run(1_000_000);
    let sum =
        |field: fn(&slqg_links::can::Message) -> u64| statistics.messages.iter().map(field).sum::<u64>();
    // Every fate occurs, or the run would show nothing.
    assert!(statistics.bus_offs > 0 && sum(|row| row.duplicates) > 0 && sum(|row| row.refused) > 0);
    assert!(sum(|row| row.aborted) > 0 && sum(|row| row.withdrawn) > 0 && sum(|row| row.retransmissions) > 0);
    assert!(statistics.load() < 1.0);
}

#[test]
#[ignore = "takes a while; docs/can.md says what it printed"]
fn each_of_ten_million_frames_has_exactly_one_fate() {
    let before = std::time::Instant::now();
    let statistics = run(10_000_000);
    let seconds = before.elapsed().as_secs_f64();
    println!("{statistics}");
    let frames: u64 = statistics.messages.iter().map(|row| row.offered).sum();
    println!("{frames} frames in {seconds:.1} s: {:.0} frames/s", frames as f64 / seconds);
}
