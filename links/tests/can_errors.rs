//! Disturbed bits: error frames, retransmission, duplicates, single and in bursts, at both bit rates.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slqg_links::can::{
    Attempts, Bus, Errors, Fate, Format, Frame, Id, Length, NodeId, Origin, Phase, Settings, Stuffing, Time,
    What,
};

const BIT: Time = 8000;
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

#[test]
fn a_disturbed_frame_costs_its_error_frame_and_is_sent_again() {
    // Rarely enough that the counters fall between errors, and the sender stays error-active.
    let mut bus = bus(Errors::Independent { probability: 2e-4 }, 3);
    let mut repeated = 0;
    for cycle in 0..20_000u64 {
        let at = cycle * SECOND / 100;
        bus.offer(at, NodeId(0), frame(0x100), cycle).unwrap();
        let before = bus.statistics();
        let events = bus.run_until(at + SECOND / 100);
        let errors = bus.statistics().error_frames - before.error_frames;
        let delivered = events[0].at - at;
        assert!(matches!(events[0].what, What::Fate { fate: Fate::Delivered, .. }));
        if errors == 0 {
            assert_eq!(delivered, 132 * BIT);
        } else if errors == 1 && events.len() == 1 {
            // Some bits of the first attempt, flag with echo, delimiter, intermission, then the frame.
            let lost = delivered - 132 * BIT - (12 + 8 + 3) * BIT;
            assert!(lost.is_multiple_of(BIT) && (1..=131).contains(&(lost / BIT)), "{lost}");
            repeated += 1;
        }
    }
    // 131 bits in which an error leads to a repetition before delivery.
    assert!((420..600).contains(&repeated), "{repeated} of 20000, about 505 expected");
}

#[test]
fn frames_that_are_not_repeated_are_lost_as_often_as_bit_errors_say() {
    let (probability, frames) = (1e-3, 100_000u64);
    for attempts in [Attempts::UntilError, Attempts::Once] {
        let mut bus = bus(Errors::Independent { probability }, 4);
        for cycle in 0..frames {
            let frame = frame(0x100).with_attempts(attempts);
            bus.offer(cycle * SECOND / 100, NodeId(0), frame, cycle).unwrap();
        }
        bus.run_until(frames * SECOND / 100);
        let row = &bus.statistics().messages[0];
        assert_eq!((row.delivered + row.aborted, row.duplicates, row.retransmissions), (frames, 0, 0));
        // Receivers have the frame if no error comes before the last of its 132 bits.
        let expected = 1.0 - (1.0 - probability).powi(131);
        let found = row.aborted as f64 / frames as f64;
        let deviation = (expected * (1.0 - expected) / frames as f64).sqrt();
        assert!((found - expected).abs() < 4.0 * deviation, "{found} {expected}");
    }
}

#[test]
fn an_error_in_the_last_bit_makes_a_duplicate_after_delivery() {
    let (probability, frames) = (5e-4, 300_000u64);
    let mut bus = bus(Errors::Independent { probability }, 5);
    let mut delivered = vec![false; frames as usize];
    let mut duplicates = 0;
    for cycle in 0..frames {
        let at = cycle * SECOND / 100;
        bus.offer(at, NodeId(0), frame(0x100), cycle).unwrap();
        for event in bus.run_until(at + SECOND / 100) {
            match event.what {
                What::Fate { origin: Origin::Offered(tag), fate: Fate::Delivered } => {
                    assert!(!std::mem::replace(&mut delivered[tag as usize], true), "delivered twice");
                }
                What::Duplicate { origin: Origin::Offered(tag) } => {
                    assert!(delivered[tag as usize], "duplicate before delivery");
                    duplicates += 1;
                }
                other => panic!("{other:?}"),
            }
        }
    }
    let row = bus.statistics().messages[0].clone();
    assert_eq!((row.duplicates, row.delivered), (duplicates, frames));
    // A delivery is disturbed in its last bit with probability p, and then there is one more.
    let expected = probability / (1.0 - probability);
    let found = duplicates as f64 / frames as f64;
    assert!((found - expected).abs() < 4.0 * (expected / frames as f64).sqrt(), "{found} {expected}");
}

#[test]
fn a_delivered_frame_that_waits_for_its_repetition_can_be_stopped_but_stays_delivered() {
    let mut bus = bus(Errors::Independent { probability: 5e-4 }, 8);
    let mut stopped = 0;
    for cycle in 0..60_000u64 {
        let at = cycle * SECOND / 100;
        bus.offer(at, NodeId(0), frame(0x100), cycle).unwrap();
        let before = bus.statistics().error_frames;
        let first = bus.run_until(at + 132 * BIT);
        let fate = What::Fate { origin: Origin::Offered(cycle), fate: Fate::Delivered };
        if first.iter().any(|event| event.what == fate) && bus.statistics().error_frames > before {
            assert!(!bus.withdraw(cycle), "its fate is decided");
            stopped += 1;
            assert!(bus.run_until(at + SECOND / 100).is_empty(), "no duplicate");
        }
        bus.run_until(at + SECOND / 100);
    }
    // About 60000 times the probability that the last bit is the first one disturbed: 28.
    let row = &bus.statistics().messages[0];
    assert!((15..45).contains(&stopped) && row.withdrawn == 0 && row.undecided() == 0, "{stopped} {row:?}");
}

#[test]
fn short_phases_of_one_probability_are_like_none() {
    // Phases change several times within a frame. Errors strike early and late bits alike, as without phases.
    let phase = Phase { mean: 20.0 * 8e-6, probability: 1e-3 };
    let lost_at = |errors: Errors| {
        let mut bus = bus(errors, 9);
        let mut times = Vec::new();
        for cycle in 0..50_000u64 {
            let at = cycle * SECOND / 100;
            bus.offer(at, NodeId(0), frame(0x100).with_attempts(Attempts::UntilError), cycle).unwrap();
            let lost = |what| matches!(what, What::Fate { fate: Fate::Aborted, .. });
            let events = bus.run_until(at + SECOND / 100);
            times.extend(events.iter().filter(|event| lost(event.what)).map(|event| (event.at - at) / BIT));
        }
        (times.len() as f64, times.iter().sum::<u64>() as f64 / times.len() as f64)
    };
    let (count, mean) = lost_at(Errors::Bursts { good: phase, bad: phase });
    // Expected: 1 - 0.999^131 of the frames; the mean of a geometric law cut off at 131 bits.
    let (expected, centre) = (50_000.0 * (1.0 - 0.999f64.powi(131)), 64.6);
    assert!((count - expected).abs() < 4.0 * expected.sqrt(), "{count} {expected}");
    // Positions are nearly uniform: standard deviation 131 / sqrt(12).
    assert!((mean - centre).abs() < 4.0 * 37.8 / count.sqrt(), "{mean} {centre}");
}

#[test]
fn bursts_disturb_as_often_as_their_phases_say_and_in_clusters() {
    let errors = Errors::Bursts {
        good: Phase { mean: 0.9, probability: 1e-5 },
        bad: Phase { mean: 0.1, probability: 5e-3 },
    };
    let mut bus = bus(errors, 6);
    let frames = 200_000u64;
    let mut aborted = vec![false; frames as usize];
    for cycle in 0..frames {
        let frame = frame(0x100).with_attempts(Attempts::UntilError);
        bus.offer(cycle * SECOND / 100, NodeId(0), frame, cycle).unwrap();
    }
    for event in bus.run_until(frames * SECOND / 100) {
        if let What::Fate { origin: Origin::Offered(tag), fate: Fate::Aborted } = event.what {
            aborted[tag as usize] = true;
        }
    }
    let lost = |probability: f64| 1.0 - (1.0 - probability).powi(131);
    let expected = 0.9 * lost(1e-5) + 0.1 * lost(5e-3);
    let count = |which: &mut dyn Iterator<Item = bool>| which.filter(|&aborted| aborted).count() as f64;
    let all = count(&mut aborted.iter().copied());
    let found = all / frames as f64;
    assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
    // The frame after a lost one is lost far more often than any frame: phases last ten frames.
    let after = count(&mut aborted.windows(2).filter(|pair| pair[0]).map(|pair| pair[1])) / all;
    assert!(after > 5.0 * found, "{after} {found}");
}

#[test]
fn both_bit_rates_see_errors() {
    let settings = Settings {
        errors: Errors::Independent { probability: 1e-3 },
        data_bit_rate: Some(2_000_000),
        ..Settings::new(500_000, 2)
    };
    let mut bus = Bus::new(settings, ChaCha8Rng::seed_from_u64(7)).unwrap();
    let (format, frames) = (Format::Fd { bit_rate_switch: true }, 50_000u64);
    let frame = Frame::new(id(0x100), format, &[0x55; 64]).unwrap().with_attempts(Attempts::UntilError);
    let length = Length::actual(&frame);
    let (mut early, mut late) = (0, 0);
    for cycle in 0..frames {
        let at = cycle * SECOND / 1000;
        bus.offer(at, NodeId(0), frame.clone(), cycle).unwrap();
        for event in bus.run_until(at + SECOND / 1000) {
            if matches!(event.what, What::Fate { fate: Fate::Aborted, .. }) {
                if event.at - at <= length.offset(length.head, bus.rates()) { early += 1 } else { late += 1 }
            }
        }
    }
    let expected = |bits: u32, before: u32| {
        frames as f64 * 0.999f64.powi(before as i32) * (1.0 - 0.999f64.powi(bits as i32))
    };
    let head = expected(length.head, 0);
    let rest = expected(length.bits() - length.head - 1, length.head);
    assert!((f64::from(early) - head).abs() < 4.0 * head.sqrt(), "{early} {head}");
    assert!((f64::from(late) - rest).abs() < 4.0 * rest.sqrt(), "{late} {rest}");
}
