//! The relay node: passes datagrams on, some late, some twice, some never.
//!
//! It looks at none of them, and counts time from the arrival of each: a delay of two cycles is twice the sample time.

use super::{
    clock::WallTime,
    event_loop::{Channel, Node, Outbox},
    statistics::{Figure, Mean, Section},
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use slqg_links::{link::Link, path::Path};
use std::{cmp::Reverse, collections::BinaryHeap, ops::RangeInclusive, time::Duration};

/// Packets kept; more are a flood, and lost.
const ROOM: usize = 1 << 16;

/// What becomes of packets.
#[derive(Debug, Clone)]
pub enum Fates {
    /// Delays in whole cycles, as the link has them one after the other.
    Cycles {
        /// The link; a packet that comes is the next cycle's.
        path: Box<Path>,
        /// Length of a cycle.
        sample_time: Duration,
    },
    /// A delay between two bounds, any as likely as another.
    Uniform {
        /// Probability of loss.
        loss: f64,
        /// Bounds.
        delay: RangeInclusive<Duration>,
    },
}

impl Fates {
    /// Those of a design's link, drawn from `random`.
    pub fn of(link: &Link, sample_time: Duration, random: ChaCha8Rng) -> Self {
        Self::Cycles { path: Box::new(Path::new(link, random)), sample_time }
    }

    /// The delay of the next packet; `None` if it is lost.
    fn draw(&mut self, random: &mut ChaCha8Rng) -> Option<Duration> {
        match self {
            Self::Cycles { path, sample_time } => {
                path.next_delay().map(|delay| *sample_time * u32::try_from(delay).unwrap_or(u32::MAX))
            }
            Self::Uniform { loss, delay } => {
                let (lost, share): (f64, f64) = (random.random(), random.random());
                let spread = delay.end().saturating_sub(*delay.start());
                (lost >= *loss).then(|| *delay.start() + spread.mul_f64(share))
            }
        }
    }
}

/// A link that can be disturbed.
#[derive(Debug)]
pub struct RelayNode {
    fates: Fates,
    /// Probability that a packet is passed on twice, each time with a fate of its own.
    duplicate: f64,
    random: ChaCha8Rng,
    sample_time: Duration,
    begun: WallTime,
    now: WallTime,
    /// By the time they are due, then in the order they came.
    under_way: BinaryHeap<Reverse<(WallTime, u64, Vec<u8>)>>,
    received: u64,
    copies: u64,
    lost: u64,
    overflowed: u64,
    forwarded: u64,
    delay: Mean,
    lateness: Mean,
}

impl RelayNode {
    /// A relay with nothing under way that draws fates from `random`.
    pub fn new(
        fates: Fates,
        duplicate: f64,
        sample_time: Duration,
        random: ChaCha8Rng,
        now: WallTime,
    ) -> Self {
        Self {
            fates,
            duplicate,
            random,
            sample_time,
            begun: now,
            now,
            under_way: BinaryHeap::new(),
            received: 0,
            copies: 0,
            lost: 0,
            overflowed: 0,
            forwarded: 0,
            delay: Mean::default(),
            lateness: Mean::default(),
        }
    }

    fn take(&mut self, packet: &[u8], now: WallTime) {
        let Some(delay) = self.fates.draw(&mut self.random) else {
            self.lost += 1;
            return;
        };
        if self.under_way.len() >= ROOM {
            self.overflowed += 1;
            return;
        }
        self.copies += 1;
        self.delay.add(delay.as_secs_f64());
        self.under_way.push(Reverse((now.after(delay), self.copies, packet.to_vec())));
    }
}

impl Node for RelayNode {
    fn next(&self) -> Option<WallTime> {
        self.under_way.peek().map(|Reverse((due, _, _))| *due)
    }

    fn act(&mut self, now: WallTime, outbox: &mut Outbox) {
        self.now = now;
        while self.next().is_some_and(|due| due <= now) {
            let Some(Reverse((due, _, packet))) = self.under_way.pop() else { return };
            self.forwarded += 1;
            self.lateness.add(due.until(now).as_secs_f64());
            outbox.push((Channel::Relayed, packet));
        }
    }

    fn receive(&mut self, packet: &[u8], now: WallTime) {
        self.received += 1;
        let twice = self.random.random::<f64>() < self.duplicate;
        self.take(packet, now);
        if twice {
            self.take(packet, now);
        }
    }

    /// Cycles since it began.
    fn cycles(&self) -> u64 {
        (self.begun.until(self.now).as_nanos() / self.sample_time.as_nanos().max(1)) as u64
    }

    fn progress(&self) -> String {
        format!("{} received, {} passed on, {} lost", self.received, self.forwarded, self.lost)
    }

    fn sections(&self) -> Vec<Section> {
        let relay = vec![
            ("received", Figure::Count(self.received)),
            ("forwarded", Figure::Count(self.forwarded)),
            ("lost", Figure::Count(self.lost)),
            ("under_way", Figure::Count(self.under_way.len() as u64)),
            ("overflowed", Figure::Count(self.overflowed)),
            ("mean_delay", Figure::Seconds(self.delay.mean())),
            ("worst_delay", Figure::Seconds(self.delay.worst())),
            ("mean_lateness", Figure::Seconds(self.lateness.mean())),
            ("worst_lateness", Figure::Seconds(self.lateness.worst())),
        ];
        vec![("relay", relay)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use slqg_links::delay::DelayDistribution;

    const MS: u64 = 1_000_000;
    const CYCLE: Duration = Duration::from_millis(10);

    fn relay(fates: Fates, duplicate: f64) -> RelayNode {
        RelayNode::new(fates, duplicate, CYCLE, ChaCha8Rng::seed_from_u64(1), WallTime(0))
    }

    fn of(probabilities: Vec<f64>) -> Fates {
        let delays = DelayDistribution::new(probabilities).expect("a distribution");
        Fates::of(&Link::independent(delays), CYCLE, ChaCha8Rng::seed_from_u64(2))
    }

    /// What is passed on at `now`, in ms.
    fn passed_on(relay: &mut RelayNode, now: u64) -> Vec<u8> {
        let mut outbox = Outbox::new();
        relay.act(WallTime(now * MS), &mut outbox);
        outbox.into_iter().map(|(_, packet)| packet[0]).collect()
    }

    #[test]
    fn a_packet_is_passed_on_once_after_whole_cycles() {
        let mut relay = relay(of(vec![0.0, 0.0, 1.0]), 0.0);
        relay.receive(&[7], WallTime(3 * MS));
        relay.receive(&[8], WallTime(3 * MS));
        assert_eq!(relay.next(), Some(WallTime(23 * MS)));
        assert!(passed_on(&mut relay, 22).is_empty());
        assert_eq!(passed_on(&mut relay, 24), [7, 8]);
        assert_eq!((passed_on(&mut relay, 99), relay.next()), (vec![], None));
    }

    #[test]
    fn fates_follow_the_distribution() {
        let mut relay = relay(of(vec![0.5, 0.0, 0.25]), 0.0);
        let count = 10_000;
        (0..count).for_each(|_| relay.receive(&[0], WallTime(0)));
        let at_once = passed_on(&mut relay, 0).len();
        assert_eq!(passed_on(&mut relay, 10).len(), 0);
        let late = passed_on(&mut relay, 20).len();
        for (found, expected) in [(at_once, 5000.0), (late, 2500.0), (relay.lost as usize, 2500.0)] {
            assert!((found as f64 - expected).abs() < 200.0, "{found} of {count}, expected {expected}");
        }
    }

    #[test]
    fn duplicates_have_fates_of_their_own() {
        let delay = Duration::from_millis(1)..=Duration::from_millis(9);
        let mut relay = relay(Fates::Uniform { loss: 0.0, delay }, 1.0);
        relay.receive(&[7], WallTime(0));
        assert!(passed_on(&mut relay, 0).is_empty());
        let first = relay.next().expect("two are under way");
        let mut outbox = Outbox::new();
        relay.act(first, &mut outbox);
        assert_eq!(outbox.len(), 1);
        assert_eq!(passed_on(&mut relay, 9), [7]);
    }

    #[test]
    fn the_same_seed_gives_the_same_fates() {
        let run = || {
            let mut relay = relay(of(vec![0.4, 0.3]), 0.2);
            (0..100).for_each(|packet| relay.receive(&[packet], WallTime(0)));
            passed_on(&mut relay, 10)
        };
        assert_eq!(run(), run());
    }
}
