//! [`Recording`]: what became of the packets of a log, to be met again in the same order.

use crate::{
    delay::{DelayDistribution, DistributionError},
    identify::sample::Sample,
};

/// Fates of packets in the order sent, one for each cycle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recording {
    fates: Vec<Option<usize>>,
}

impl Recording {
    /// Delays in cycles, or lost (`None`), one for each cycle.
    pub fn new(fates: Vec<Option<usize>>) -> Self {
        Self { fates }
    }

    /// The fates of a sample, file after file as if they had been one.
    pub fn of(sample: &Sample) -> Self {
        Self::new(sample.fates(0..sample.packets() as usize).collect())
    }

    /// Share of each delay among the packets; what is missing to 1 was lost.
    ///
    /// # Errors
    /// No packet arrived.
    pub fn shares(&self) -> Result<DelayDistribution, DistributionError> {
        let longest = self.fates.iter().flatten().max().map_or(0, |&delay| delay + 1);
        let mut counts = vec![0_u32; longest];
        for &delay in self.fates.iter().flatten() {
            counts[delay] += 1;
        }
        let packets = self.fates.len() as f64;
        DelayDistribution::new(counts.iter().map(|&count| f64::from(count) / packets).collect())
    }

    /// Cycles recorded.
    pub fn cycles(&self) -> usize {
        self.fates.len()
    }

    /// What became of the packet of a cycle; after the last one it begins anew.
    pub fn fate(&self, cycle: usize) -> Option<usize> {
        self.fates[cycle % self.fates.len()]
    }

    /// Largest delay that occurs, in cycles.
    pub fn largest_delay(&self) -> usize {
        self.fates.iter().flatten().copied().max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_count_what_was_recorded_and_it_begins_anew_at_its_end() {
        let recording = Recording::new(vec![Some(0), None, Some(2), Some(0)]);
        let shares = recording.shares().expect("a distribution");
        assert_eq!((shares.probabilities(), shares.loss()), ([0.5, 0.0, 0.25].as_slice(), 0.25));
        assert_eq!([4, 5, 6].map(|cycle| recording.fate(cycle)), [Some(0), None, Some(2)]);
    }
}
