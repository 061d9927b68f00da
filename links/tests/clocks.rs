//! Two logs by two clocks: offset and drift are found within the margin that is stated, and delays come out as they were.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slqg_links::identify::{
    formats::message::CanId,
    logs::{Selection, traces},
    trace::{Trace, TraceError},
};
use std::{fmt::Write, path::PathBuf};

const SECOND: i64 = 1_000_000_000;
const BEGIN: i64 = 1_700_000_000 * SECOND;
const PERIOD: i64 = 10_000_000;
const PACKETS: i64 = 1000;

/// Two computers that send to each other in every cycle.
struct Ends {
    /// Nanoseconds by which the receiver's clock is ahead at the begin.
    offset: i64,
    /// Millionths by which it goes faster.
    drift: f64,
    /// Nanoseconds by which it is set forward in the middle.
    step: i64,
    /// Shortest delay of the link and of the way back, in nanoseconds.
    shortest: [i64; 2],
    has_way_back: bool,
}

impl Ends {
    fn of(offset: i64, drift: f64) -> Self {
        Self { offset, drift, step: 0, shortest: [2_000_000; 2], has_way_back: true }
    }

    /// What the receiver's clock shows.
    fn receiver(&self, time: i64) -> i64 {
        let step = if time >= BEGIN + PACKETS / 2 * PERIOD { self.step } else { 0 };
        time + self.offset + step + ((time - BEGIN) as f64 * self.drift * 1e-6) as i64
    }

    /// Logs of both ends, and the delays of the packets of the link, in nanoseconds.
    fn logs(&self, seed: u64) -> ([String; 2], Vec<Option<i64>>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut lines: [Vec<(i64, String)>; 2] = Default::default();
        let mut delays = Vec::new();
        for number in 0..PACKETS {
            let sent = BEGIN + number * PERIOD;
            for (id, from, shortest) in [("123", 0, self.shortest[0]), ("124", 1, self.shortest[1])] {
                // Most delays are near the shortest one, some are long.
                let spread = 20e6 * random.random::<f64>().powi(4);
                let delay = random.random_bool(0.95).then_some(shortest + spread as i64);
                if id == "123" {
                    delays.push(delay);
                } else if !self.has_way_back {
                    continue;
                }
                let mut see = |end: usize, time: i64| {
                    let shown = if end == 1 { self.receiver(time) } else { time } / 1000;
                    let (seconds, below) = (shown / 1_000_000, shown % 1_000_000);
                    let payload: String =
                        (number as u32).to_le_bytes().iter().fold(String::new(), |mut text, byte| {
                            write!(text, "{byte:02X}").expect("a string");
                            text
                        });
                    lines[end].push((shown, format!("({seconds}.{below:06}) can{end} {id}#{payload}55\n")));
                };
                see(from, sent);
                if let Some(delay) = delay {
                    see(1 - from, sent + delay);
                }
            }
        }
        let text = lines.map(|mut lines| {
            lines.sort();
            lines.into_iter().map(|(_, line)| line).collect()
        });
        (text, delays)
    }
}

fn read([sender, receiver]: &[String; 2], shortest_delay: Option<i64>) -> Result<Trace, TraceError> {
    let logs =
        [(PathBuf::from("a.log"), sender.clone().into()), (PathBuf::from("b.log"), receiver.clone().into())];
    let id = Some(CanId::of(0x123));
    let selection =
        Selection { tx: Some("can0"), rx: Some("can1"), id, kind: 2, shortest_delay, ..Selection::default() };
    traces(&logs, &selection).map(|traces| traces.into_iter().next().expect("a trace"))
}

/// Largest error of a delay, in nanoseconds, of all but `apart` packets.
fn error(trace: &Trace, delays: &[Option<i64>], apart: usize) -> i64 {
    let mut errors: Vec<i64> = trace
        .packets()
        .filter_map(|packet| {
            let delay = packet.received? - packet.sent?;
            Some((delay - delays[((packet.sent? - BEGIN) / PERIOD) as usize]?).abs())
        })
        .collect();
    assert!(errors.len() > 900);
    errors.sort_unstable();
    errors[errors.len() - 1 - apart]
}

#[test]
fn offset_and_drift_are_within_the_stated_margin_whatever_the_ways_are_like() {
    let (mut held, mut near) = (0, 0);
    for seed in 0..100 {
        let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
        let is_uneven = seed % 2 == 1;
        let shortest =
            [2_000_000, if is_uneven { random.random_range(1_000_000..6_000_000) } else { 2_000_000 }];
        let offset = random.random_range(-4 * SECOND..4 * SECOND);
        let ends = Ends { shortest, ..Ends::of(offset, random.random_range(-100.0..100.0)) };
        let (logs, delays) = ends.logs(seed);
        let trace = read(&logs, None).expect("packets of both ways");
        let clock = trace.about.clock.expect("clocks that are apart");
        assert_eq!(clock.steps, 0, "seed {seed}");
        held += u32::from((clock.offset - offset as f64 / 1e9).abs() <= clock.margin);
        assert!(
            (clock.drift_ppm - ends.drift).abs() < 20.0,
            "seed {seed}: {} ppm, not {}",
            clock.drift_ppm,
            ends.drift
        );
        assert!(error(&trace, &delays, 0) as f64 <= clock.margin * 1e9 + 2000.0, "seed {seed}");
        // Where both shortest delays are alike, the middle is the offset.
        near += u32::from(is_uneven || error(&trace, &delays, 0) < 100_000);
    }
    assert!(held >= 95 && near >= 95, "{held} of 100 held, {near} near");
}

#[test]
fn a_clock_that_is_set_is_found() {
    for (seed, step) in [(1, SECOND / 2), (2, -SECOND / 2), (3, 60_000_000), (4, -3 * SECOND)] {
        let ends = Ends { step, ..Ends::of(3_200_000_000, 40.0) };
        let (logs, delays) = ends.logs(seed);
        let trace = read(&logs, None).expect("packets of both ways");
        let clock = trace.about.clock.expect("clocks that are apart");
        assert_eq!(clock.steps, 1, "step {step}: {clock:?}");
        assert!((clock.offset - 3.2).abs() <= clock.margin, "step {step}: {clock:?}");
        // Packets that were under way while the clock was set have two clocks of the receiver.
        assert!(error(&trace, &delays, 6) as f64 <= clock.margin * 1e9 + 2000.0, "step {step}");
    }
}

#[test]
fn clocks_that_may_well_agree_are_left_alone() {
    for seed in 0..10 {
        let (logs, delays) = Ends::of(500_000, 0.0).logs(seed);
        let trace = read(&logs, None).expect("packets");
        assert_eq!(trace.about.clock, None);
        // The offset stays in the delays.
        assert!(error(&trace, &delays, 0) <= 501_000);
    }
}

#[test]
fn without_a_way_back_the_shortest_delay_must_be_said() {
    let ends = Ends { has_way_back: false, ..Ends::of(-3_200_000_000, 40.0) };
    let (logs, delays) = ends.logs(7);
    let problem = read(&logs, None).expect_err("packets arrive before they are sent").to_string();
    assert!(
        problem.contains("clocks of the two ends are not synchronised")
            && problem.contains("--shortest-delay"),
        "{problem}"
    );
    let trace = read(&logs, Some(2_000_000)).expect("packets");
    let clock = trace.about.clock.expect("clocks that are apart");
    assert!((clock.drift_ppm - 40.0).abs() < 2.0, "{clock:?}");
    assert!(error(&trace, &delays, 0) < 100_000);
    assert!(trace.about.notes.iter().any(|note| note.contains("--shortest-delay")));
}
