//! Worst-case response times: the published example, the simulation within the analysis, and equal to it at the critical
//! instant.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slqg_links::can::{
    Attempts, Background, Bus, Fate, Format, Frame, INTERMISSION, Id, Length, NodeId, Origin, Pattern,
    Periodic, Settings, Source, Stuffing, Time, What, meets_deadlines, response_times,
};

/// At 125 kbit/s, in nanoseconds.
const BIT: Time = 8000;
const MICROSECOND: Time = 1000;

/// Messages A, B and C of Davis, Burns, Bril and Lukkien 2007: 7 bytes, 125 bits, 1 ms each.
fn published() -> [Periodic; 3] {
    [(2500, 2500), (3500, 3250), (3500, 3250)].map(|(period, deadline)| Periodic {
        transmission: 125 * BIT,
        period: period * MICROSECOND,
        jitter: 0,
        deadline: deadline * MICROSECOND,
    })
}

fn settings(stuffing: Stuffing, sources: Vec<Source>, nodes: u16) -> Settings {
    Settings { stuffing, sources, ..Settings::new(125_000, nodes) }
}

fn source(index: usize, bytes: usize, period: Time, offset: Time, jitter: Time) -> Source {
    Source {
        node: NodeId(index as u16),
        id: Id::base(0x100 + 0x10 * index as u16).unwrap(),
        format: Format::Classic,
        bytes,
        pattern: Pattern::Periodic { period, offset, jitter },
        attempts: Attempts::Unlimited,
    }
}

fn transmission(bytes: usize) -> Time {
    let length = Length::worst(false, Format::Classic, bytes).unwrap();
    Time::from(length.bits() + INTERMISSION) * BIT
}

#[test]
fn the_published_example_has_its_published_response_times() {
    let milliseconds = |times: Vec<Option<Time>>| -> Vec<f64> {
        times.iter().map(|time| time.unwrap() as f64 * 1e-6).collect()
    };
    assert_eq!(milliseconds(response_times(&published(), BIT)), [2.0, 3.0, 3.5]);
    // C misses its deadline of 3.25 ms, in its second instance.
    assert!(!meets_deadlines(&published(), BIT));
    assert!(meets_deadlines(&published()[..2], BIT));
}

#[test]
fn a_bus_that_is_full_has_no_bound() {
    let [mut a, b, c] = published();
    a.period = 2000 * MICROSECOND;
    // 0.5 + 2/7 + 2/7 > 1: only the least urgent has no bound.
    let bounds = response_times(&[a, b, c], BIT);
    assert!(bounds[0].is_some() && bounds[1].is_some() && bounds[2].is_none(), "{bounds:?}");
}

#[test]
fn the_published_example_is_met_by_the_simulation_exactly() {
    // All released together, one nanosecond after a frame as long as theirs has begun where there is a less urgent one.
    // The analysis counts the intermission after the frame as its part; the simulation delivers at the end of EOF.
    let bounds = response_times(&published(), BIT);
    for (index, bound) in bounds.iter().enumerate() {
        let blocked = Time::from(index < 2);
        let sources = published()[..=index]
            .iter()
            .enumerate()
            .map(|(k, message)| source(k, 7, message.period, blocked, 0))
            .collect();
        let mut bus = Bus::new(settings(Stuffing::Worst, sources, 4), ChaCha8Rng::seed_from_u64(0)).unwrap();
        if blocked == 1 {
            let least = Frame::new(Id::base(0x7FF).unwrap(), Format::Classic, &[0; 7]).unwrap();
            bus.offer(0, NodeId(3), least, 0).unwrap();
        }
        bus.run_until(1_000_000 * MICROSECOND);
        let longest = bus.statistics().messages[index].response.max().unwrap();
        assert_eq!(longest + 3 * BIT + blocked, bound.unwrap(), "message {index}");
    }
}

/// A set of messages with rate-monotonic identifiers and the given load, at random.
fn random_set(random: &mut ChaCha8Rng, load: f64) -> Vec<(usize, Time, Time)> {
    let mut set = Vec::new();
    let mut left = load;
    while left > 0.02 {
        let bytes = random.random_range(0..=8);
        let period = [10, 20, 25, 40, 50, 100, 200][random.random_range(0..7)] * 1000 * MICROSECOND;
        let jitter = random.random_range(0..=period / 4);
        left -= transmission(bytes) as f64 / period as f64;
        if left > 0.0 {
            set.push((bytes, period, jitter));
        }
    }
    set.sort_by_key(|&(_, period, _)| period);
    set
}

fn bounds(set: &[(usize, Time, Time)]) -> Vec<Option<Time>> {
    let message = |&(bytes, period, jitter): &(usize, Time, Time)| Periodic {
        transmission: transmission(bytes),
        period,
        jitter,
        deadline: period,
    };
    response_times(&set.iter().map(message).collect::<Vec<_>>(), BIT)
}

#[test]
fn simulated_response_times_stay_within_the_analysis() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    for (round, load) in [0.3, 0.5, 0.7, 0.85, 0.95].into_iter().enumerate() {
        let set = random_set(&mut random, load);
        let bounds = bounds(&set);
        for stuffing in [Stuffing::Actual, Stuffing::Worst] {
            let sources = set.iter().enumerate().map(|(k, &(bytes, period, jitter))| {
                source(k, bytes, period, random.random_range(0..period), jitter)
            });
            let settings = settings(stuffing, sources.collect(), set.len() as u16);
            let mut bus = Bus::new(settings, ChaCha8Rng::seed_from_u64(round as u64)).unwrap();
            bus.run_until(60_000_000 * MICROSECOND);
            for (message, bound) in bus.statistics().messages.iter().zip(&bounds) {
                let longest = message.response.max().unwrap();
                assert!(longest + 3 * BIT <= bound.unwrap(), "{message:?}, bound {bound:?}");
            }
        }
    }
}

#[test]
fn at_the_critical_instant_a_large_set_meets_the_analysis_exactly() {
    // Without jitter, message m and those above it released together, a nanosecond after the longest frame below has begun.
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let set: Vec<_> =
        random_set(&mut random, 0.8).iter().map(|&(bytes, period, _)| (bytes, period, 0)).collect();
    assert!(set.len() > 10, "{set:?}");
    for (m, bound) in bounds(&set).iter().enumerate() {
        let longest_below = set[m + 1..].iter().map(|&(bytes, ..)| bytes).max();
        let start = Time::from(longest_below.is_some());
        let sources = (0..=m).map(|k| source(k, set[k].0, set[k].1, start, 0)).collect();
        let settings = settings(Stuffing::Worst, sources, set.len() as u16 + 1);
        let mut bus = Bus::new(settings, ChaCha8Rng::seed_from_u64(0)).unwrap();
        if let Some(bytes) = longest_below {
            let frame = Frame::new(Id::base(0x7FF).unwrap(), Format::Classic, &vec![0; bytes]).unwrap();
            bus.offer(0, NodeId(set.len() as u16), frame, 0).unwrap();
        }
        bus.run_until(2_000_000 * MICROSECOND);
        let longest = bus.statistics().messages[m].response.max().unwrap();
        assert_eq!(longest + 3 * BIT + start, bound.unwrap(), "message {m} of {}", set.len());
    }
}

#[test]
fn a_frame_amid_background_traffic_stays_within_the_analysis() {
    let own = Id::base(0x200).unwrap();
    let background = Background::load(0.6, 125_000, &[own], 1..5).unwrap().sources;
    let message = |source: &Source| match source.pattern {
        Pattern::Periodic { period, jitter, .. } => {
            Periodic { transmission: transmission(source.bytes), period, jitter, deadline: period }
        }
        Pattern::Sporadic { .. } => panic!("background traffic is periodic"),
    };
    let period = 20_000 * MICROSECOND;
    let mut all: Vec<(Id, Periodic)> = background.iter().map(|source| (source.id, message(source))).collect();
    all.push((own, Periodic { transmission: transmission(8), period, jitter: 0, deadline: period }));
    all.sort_by_key(|&(id, _)| id);
    let bounds = response_times(&all.iter().map(|&(_, message)| message).collect::<Vec<_>>(), BIT);
    let place = all.iter().position(|&(id, _)| id == own).unwrap();
    let bound = bounds[place].unwrap();

    let settings = settings(Stuffing::Actual, background, 5);
    let mut bus = Bus::new(settings, ChaCha8Rng::seed_from_u64(6)).unwrap();
    let mut longest = 0;
    for cycle in 0..5000u64 {
        let at = cycle * period;
        bus.offer(at, NodeId(0), Frame::new(own, Format::Classic, &[0; 8]).unwrap(), cycle).unwrap();
        for event in bus.run_until(at + period) {
            if event.what == (What::Fate { origin: Origin::Offered(cycle), fate: Fate::Delivered }) {
                longest = longest.max(event.at - at);
            }
        }
    }
    assert!(longest + 3 * BIT <= bound && longest > transmission(8), "{longest} of {bound}");
}
