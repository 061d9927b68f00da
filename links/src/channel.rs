//! [`Channel`]: a channel that comes and goes, as it goes on cycle by cycle. What it is like is in [`crate::markov`].

use crate::markov::MarkovLink;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// A channel as it goes on, cycle by cycle.
#[derive(Debug, Clone)]
pub struct Channel {
    link: MarkovLink,
    state: usize,
}

/// Index of the part of a distribution in which `draw`, uniform in 0 to 1, falls.
fn pick(distribution: &[f64], mut draw: f64) -> usize {
    for (index, probability) in distribution.iter().enumerate() {
        draw -= probability;
        if draw < 0.0 {
            return index;
        }
    }
    // Rounding: the last one that can be.
    distribution.iter().rposition(|&probability| probability > 0.0).unwrap_or(0)
}

impl Channel {
    /// A channel that begins in a state drawn by its long-run share.
    pub fn new(link: MarkovLink, random: &mut ChaCha8Rng) -> Self {
        let state = pick(link.shares(), random.random());
        Self { link, state }
    }

    /// The state in which a packet of this cycle is sent.
    pub fn state(&self) -> usize {
        self.state
    }

    /// Draws the delay of a packet of this cycle; `None`: it is lost.
    pub fn delay(&self, random: &mut ChaCha8Rng) -> Option<usize> {
        let draw: f64 = random.random();
        let delays = self.link.delays(self.state)?;
        (draw < 1.0 - delays.loss()).then(|| pick(delays.probabilities(), draw))
    }

    /// Goes on to the next cycle.
    pub fn next_cycle(&mut self, random: &mut ChaCha8Rng) {
        self.state = pick(self.link.transitions_from(self.state), random.random());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn a_burst_is_as_long_and_as_frequent_as_its_two_probabilities_say() {
        let link = MarkovLink::gilbert_elliott(0.02, 0.25, vec![1.0], vec![]).expect("a channel");
        assert!((link.shares()[1] - 0.02 / 0.27).abs() < 1e-15);
        assert!((link.average().loss() - 0.02 / 0.27).abs() < 1e-15);
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut channel = Channel::new(link, &mut random);
        let (mut lost, mut bursts, mut was_lost) = (0, 0, false);
        let cycles = 200_000;
        for _ in 0..cycles {
            let is_lost = channel.delay(&mut random).is_none();
            lost += u32::from(is_lost);
            bursts += u32::from(is_lost && !was_lost);
            was_lost = is_lost;
            channel.next_cycle(&mut random);
        }
        assert!((f64::from(lost) / f64::from(bursts) - 4.0).abs() < 0.2, "{lost} losses in {bursts} bursts");
        assert!((f64::from(lost) / f64::from(cycles) - 0.074).abs() < 0.005);
    }
}
