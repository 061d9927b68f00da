//! Packets under way: each is delayed by a whole number of cycles, or lost, independently of the others.
//!
//! A link carries bytes and looks at none of them. Thesis 3.1, Assumption 3.1.

use gain_gen::design::DelayDistribution;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// What became of a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// Arrives after this many cycles.
    Delayed(usize),
    /// Never arrives.
    Lost,
}

/// A link with independent delays and losses.
#[derive(Debug, Clone)]
pub struct Link {
    /// P(delay <= d).
    cumulative: Vec<f64>,
    random: ChaCha8Rng,
    /// Packets by the cycle they arrive in; the front is the current one.
    under_way: std::collections::VecDeque<Vec<Vec<u8>>>,
}

impl Link {
    /// A link with nothing under way that draws its delays from `random`.
    pub fn new(distribution: &DelayDistribution, random: ChaCha8Rng) -> Self {
        let mut sum = 0.0;
        let mut cumulative: Vec<f64> = distribution
            .probabilities()
            .iter()
            .map(|probability| {
                sum += probability;
                sum
            })
            .collect();
        if let (true, Some(last)) = (distribution.loss() == 0.0, cumulative.last_mut()) {
            // Rounding of the sum must not lose packets.
            *last = 1.0;
        }
        let cycles = cumulative.len().max(1);
        Self { cumulative, random, under_way: vec![Vec::new(); cycles].into() }
    }

    /// Sends a packet in the current cycle; it may arrive in the same cycle.
    pub fn send(&mut self, packet: &[u8]) -> Fate {
        let draw: f64 = self.random.random();
        match self.cumulative.iter().position(|&up_to| draw < up_to) {
            Some(delay) => {
                self.under_way[delay].push(packet.to_vec());
                Fate::Delayed(delay)
            }
            None => Fate::Lost,
        }
    }

    /// Takes a draw without sending, so that the next packet meets the fate it would have met.
    pub fn skip(&mut self) {
        let _: f64 = self.random.random();
    }

    /// Packets that arrive in the current cycle, in the order sent.
    pub fn arrived(&mut self) -> Vec<Vec<u8>> {
        self.under_way.front_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Ends the current cycle.
    pub fn next_cycle(&mut self) {
        self.under_way.rotate_left(1);
        if let Some(newest) = self.under_way.back_mut() {
            newest.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, stream};

    fn link(probabilities: Vec<f64>) -> Link {
        let distribution = DelayDistribution::new(probabilities).expect("a distribution");
        Link::new(&distribution, stream(1, 0, Purpose::ActuatorLink))
    }

    #[test]
    fn a_perfect_link_delivers_in_the_same_cycle() {
        let mut link = link(vec![1.0]);
        for cycle in 0..10 {
            assert_eq!(link.send(&[cycle]), Fate::Delayed(0));
            assert_eq!(link.arrived(), vec![vec![cycle]]);
            link.next_cycle();
        }
    }

    #[test]
    fn a_packet_arrives_once_and_after_its_delay() {
        let mut link = link(vec![0.3, 0.2, 0.2, 0.1]);
        let mut due = std::collections::BTreeMap::new();
        for cycle in 0..1000_u16 {
            if let Fate::Delayed(delay) = link.send(&cycle.to_le_bytes()) {
                due.entry(cycle + delay as u16).or_insert_with(Vec::new).push(cycle.to_le_bytes().to_vec());
            }
            assert_eq!(link.arrived(), due.remove(&cycle).unwrap_or_default());
            assert!(link.arrived().is_empty(), "packets arrive once");
            link.next_cycle();
        }
    }

    #[test]
    fn delays_follow_the_distribution() {
        let probabilities = [0.5, 0.25, 0.0, 0.125];
        let mut link = link(probabilities.to_vec());
        let draws = 100_000;
        let mut counts = [0_u32; 5];
        for _ in 0..draws {
            match link.send(&[]) {
                Fate::Delayed(delay) => counts[delay] += 1,
                Fate::Lost => counts[4] += 1,
            }
            link.arrived();
            link.next_cycle();
        }
        for (count, probability) in counts.iter().zip(probabilities.iter().chain(&[0.125])) {
            let deviation = (probability * (1.0 - probability) / f64::from(draws)).sqrt();
            let found = f64::from(*count) / f64::from(draws);
            assert!((found - probability).abs() <= 4.0 * deviation, "{found} for {probability}");
        }
    }
}
