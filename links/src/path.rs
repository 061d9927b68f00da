//! [`Path`]: packets under way on a link, cycle by cycle.
//!
//! A path carries bytes and looks at none of them. A packet that is later than its successor is overtaken by it.

use crate::{
    channel::Channel,
    link::{Behaviour, Link},
    recording::Recording,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::{collections::VecDeque, sync::Arc};

/// What became of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// Arrives after this many cycles.
    Delayed(usize),
    /// Never arrives.
    Lost,
    /// Not decided yet: on a bus that depends on what others send.
    Open,
}

/// Where the next delay comes from.
#[derive(Debug, Clone)]
enum Source {
    /// P(delay <= d).
    Independent(Vec<f64>),
    Markov(Channel),
    /// The record, and the cycle in it.
    Recorded(Arc<Recording>, usize),
}

/// A link in use.
#[derive(Debug, Clone)]
pub struct Path {
    source: Source,
    duplicates: f64,
    random: ChaCha8Rng,
    /// The current cycle.
    cycle: u64,
    /// In the order sent, from the oldest on that may still be taken.
    packets: VecDeque<Packet>,
    /// Room that taken packets leave to the next ones, so that a path with one packet per cycle allocates nothing once it is
    /// made.
    room: Vec<Vec<u8>>,
}

/// A packet.
#[derive(Debug, Clone)]
struct Packet {
    /// The cycle it arrives in; `None` once it is taken.
    due: Option<u64>,
    bytes: Vec<u8>,
}

/// Bytes that each packet has room for from the start; longer ones make theirs when they are first sent.
const ROOM: usize = 64;

impl Path {
    /// A path with nothing under way that draws its delays from `random`. A recording is entered anywhere in it.
    pub fn new(link: &Link, mut random: ChaCha8Rng) -> Self {
        let source = match &link.behaviour {
            // Without its bus, a link's packets are as independent as others.
            Behaviour::Independent | Behaviour::Bus => Source::Independent(cumulative(link)),
            Behaviour::Markov(markov) => Source::Markov(Channel::new(markov.clone(), &mut random)),
            Behaviour::Recorded(recording) => {
                let first = random.random_range(0..recording.cycles() as u64) as usize;
                Source::Recorded(recording.clone(), first)
            }
        };
        let copies = if link.duplicates > 0.0 { 2 } else { 1 };
        let most = copies * (link.largest_delay() + 1);
        let room = std::iter::repeat_with(|| Vec::with_capacity(ROOM)).take(most).collect();
        let packets = VecDeque::with_capacity(most);
        Self { source, duplicates: link.duplicates, random, cycle: 0, packets, room }
    }

    /// Sends a packet in the current cycle; it may arrive in the same cycle.
    #[inline]
    pub fn send(&mut self, packet: &[u8]) -> Fate {
        let Some(delay) = self.delay() else { return Fate::Lost };
        self.put(packet, delay);
        if self.duplicates > 0.0
            && self.random.random_bool(self.duplicates)
            && let Some(again) = self.delay()
        {
            self.put(packet, again);
        }
        Fate::Delayed(delay)
    }

    /// The delay of this cycle's packet, for one who carries packets himself, and on to the next cycle; `None`: it is lost.
    pub fn next_delay(&mut self) -> Option<usize> {
        let delay = self.delay();
        self.next_cycle();
        delay
    }

    fn put(&mut self, packet: &[u8], delay: usize) {
        let mut bytes = self.room.pop().unwrap_or_default();
        if bytes.capacity() < packet.len() {
            // Acknowledgements grow in the first cycles: whole steps of room take that up.
            bytes.reserve(packet.len().next_multiple_of(ROOM));
        }
        bytes.extend_from_slice(packet);
        self.packets.push_back(Packet { due: Some(self.cycle + delay as u64), bytes });
    }

    /// Takes a draw without sending, so that the next packet meets the fate it would have met.
    pub fn skip(&mut self) {
        self.delay();
    }

    fn delay(&mut self) -> Option<usize> {
        match &self.source {
            Source::Independent(cumulative) => {
                let draw: f64 = self.random.random();
                cumulative.iter().position(|&up_to| draw < up_to)
            }
            Source::Markov(channel) => channel.delay(&mut self.random),
            Source::Recorded(recording, cycle) => recording.fate(*cycle),
        }
    }

    /// State of the channel in the current cycle, where it has any.
    #[inline]
    pub fn channel_state(&self) -> Option<usize> {
        match &self.source {
            Source::Markov(channel) => Some(channel.state()),
            Source::Independent(_) | Source::Recorded(..) => None,
        }
    }

    /// Takes the packets that arrive in the current cycle, in the order sent; each is there once.
    #[inline]
    pub fn arrived(&mut self) -> impl Iterator<Item = &[u8]> {
        let now = self.cycle;
        self.packets.iter_mut().filter(move |packet| packet.due == Some(now)).map(|packet| {
            packet.due = None;
            packet.bytes.as_slice()
        })
    }

    /// Ends the current cycle.
    #[inline]
    pub fn next_cycle(&mut self) {
        while let Some(packet) = self.packets.front()
            && packet.due.is_none_or(|due| due <= self.cycle)
            && let Some(Packet { mut bytes, .. }) = self.packets.pop_front()
        {
            bytes.clear();
            self.room.push(bytes);
        }
        self.cycle += 1;
        match &mut self.source {
            Source::Independent(_) => (),
            Source::Markov(channel) => channel.next_cycle(&mut self.random),
            Source::Recorded(_, cycle) => *cycle += 1,
        }
    }
}

fn cumulative(link: &Link) -> Vec<f64> {
    let mut sum = 0.0;
    let mut cumulative: Vec<f64> = link
        .delays
        .probabilities()
        .iter()
        .map(|probability| {
            sum += probability;
            sum
        })
        .collect();
    if let (true, Some(last)) = (link.delays.loss() == 0.0, cumulative.last_mut()) {
        // Rounding of the sum must not lose packets.
        *last = 1.0;
    }
    cumulative
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{delay::DelayDistribution, markov::MarkovLink};
    use rand::SeedableRng;

    fn path(link: &Link) -> Path {
        Path::new(link, ChaCha8Rng::seed_from_u64(1))
    }

    fn independent(probabilities: Vec<f64>) -> Path {
        path(&Link::independent(DelayDistribution::new(probabilities).expect("a distribution")))
    }

    #[test]
    fn a_perfect_link_delivers_in_the_same_cycle() {
        let mut path = independent(vec![1.0]);
        for cycle in 0..10 {
            assert_eq!(path.send(&[cycle]), Fate::Delayed(0));
            assert!(path.arrived().eq([&[cycle]]));
            path.next_cycle();
        }
    }

    #[test]
    fn a_packet_arrives_once_and_after_its_delay() {
        let mut path = independent(vec![0.3, 0.2, 0.2, 0.1]);
        let mut due = std::collections::BTreeMap::new();
        for cycle in 0..1000_u16 {
            if let Fate::Delayed(delay) = path.send(&cycle.to_le_bytes()) {
                due.entry(cycle + delay as u16).or_insert_with(Vec::new).push(cycle.to_le_bytes().to_vec());
            }
            assert!(path.arrived().eq(due.remove(&cycle).unwrap_or_default()));
            assert_eq!(path.arrived().count(), 0, "packets arrive once");
            path.next_cycle();
        }
    }

    #[test]
    fn delays_follow_the_distribution() {
        let probabilities = [0.5, 0.25, 0.0, 0.125];
        let mut path = independent(probabilities.to_vec());
        let draws = 100_000;
        let mut counts = [0_u32; 5];
        for _ in 0..draws {
            match path.send(&[]) {
                Fate::Delayed(delay) => counts[delay] += 1,
                Fate::Lost | Fate::Open => counts[4] += 1,
            }
            path.next_cycle();
        }
        for (count, probability) in counts.iter().zip(probabilities.iter().chain(&[0.125])) {
            let deviation = (probability * (1.0 - probability) / f64::from(draws)).sqrt();
            let found = f64::from(*count) / f64::from(draws);
            assert!((found - probability).abs() <= 4.0 * deviation, "{found} for {probability}");
        }
    }

    #[test]
    fn a_recording_is_met_again_in_its_order() {
        let fates = vec![Some(1), None, Some(0), Some(3), Some(0)];
        let recording = Recording::new(fates.clone());
        let mut path = path(&Link::recorded(recording.shares().expect("a distribution"), recording));
        let met: Vec<_> = (0..10)
            .map(|_| {
                let fate = path.send(&[]);
                path.next_cycle();
                match fate {
                    Fate::Delayed(delay) => Some(delay),
                    Fate::Lost | Fate::Open => None,
                }
            })
            .collect();
        let is_it = |from: usize| (0..10).all(|cycle| met[cycle] == fates[(from + cycle) % fates.len()]);
        assert!((0..fates.len()).any(is_it), "{met:?}");
    }

    #[test]
    fn a_duplicate_arrives_besides_its_original() {
        let mut link =
            Link::independent(DelayDistribution::new(vec![0.5, 0.3, 0.2]).expect("a distribution"));
        link.duplicates = 0.25;
        let mut path = path(&link);
        let cycles = 20_000;
        let mut arrived = 0;
        for _ in 0..cycles {
            path.send(&[1]);
            arrived += path.arrived().count();
            path.next_cycle();
        }
        let per_packet = arrived as f64 / f64::from(cycles);
        assert!((per_packet - 1.25).abs() < 0.02, "{per_packet}");
    }

    #[test]
    fn packets_of_a_bad_channel_are_as_late_as_that_state_says() {
        let channel =
            MarkovLink::gilbert_elliott(0.1, 0.2, vec![1.0], vec![0.0, 0.0, 0.5]).expect("a channel");
        let mut path = path(&Link::markov(channel));
        let mut seen = [0_u32; 3];
        for _ in 0..3000 {
            let state = path.channel_state().expect("a channel has a state");
            match (state, path.send(&[])) {
                (0, fate) => assert_eq!(fate, Fate::Delayed(0)),
                (_, Fate::Delayed(delay)) => {
                    assert_eq!(delay, 2);
                    seen[2] += 1;
                }
                (_, Fate::Lost | Fate::Open) => seen[1] += 1,
            }
            path.next_cycle();
        }
        assert!(seen[1] > 300 && seen[2] > 300, "{seen:?}");
    }
}
