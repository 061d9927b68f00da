//! [`DelayDistribution`]: how long packets are under way, and how many never arrive. Not who sends them.

/// Mass below this is what rounding leaves when probabilities are summed up.
const ROUNDING: f64 = 1e-12;
/// A sum above 1 by at most this is still read as 1: files carry rounded figures.
const EXCESS: f64 = 1e-9;

/// Distribution of a link's packet delay, in whole steps; what is missing to 1 is lost.
///
/// Independent from packet to packet (thesis, assumption 3.1).
#[derive(Debug, Clone, PartialEq)]
pub struct DelayDistribution {
    probabilities: Vec<f64>,
    loss: f64,
}

/// Why a list of numbers is no delay distribution.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DistributionError {
    /// An entry is not a number within 0 and 1.
    #[error("found {probability} as probability of delay {delay}")]
    NotAProbability {
        /// Index of the entry, in steps.
        delay: usize,
        /// Its value.
        probability: f64,
    },
    /// The entries sum to more than 1.
    #[error("found probabilities that sum to {sum}")]
    SumAboveOne {
        /// Their sum.
        sum: f64,
    },
    /// No delay has a positive probability.
    #[error("found a link on which no packet ever arrives")]
    NothingArrives,
}

impl DelayDistribution {
    /// `probabilities[d]` is P(delay = d steps), what they leave to 1 is loss; zeros at the end are dropped.
    ///
    /// A loss below 1e-12 is rounding and taken as exactly 0.
    ///
    /// # Errors
    /// An entry outside 0 to 1 (or NaN), a sum above 1 by more than 1e-9, no positive entry.
    pub fn new(mut probabilities: Vec<f64>) -> Result<Self, DistributionError> {
        let wrong = probabilities.iter().position(|probability| !(0.0..=1.0).contains(probability));
        if let Some(delay) = wrong {
            return Err(DistributionError::NotAProbability { delay, probability: probabilities[delay] });
        }
        let Some(largest) = probabilities.iter().rposition(|&probability| probability > 0.0) else {
            return Err(DistributionError::NothingArrives);
        };
        probabilities.truncate(largest + 1);
        let sum: f64 = probabilities.iter().sum();
        if sum > 1.0 + EXCESS {
            return Err(DistributionError::SumAboveOne { sum });
        }
        let loss = if 1.0 - sum < ROUNDING { 0.0 } else { 1.0 - sum };
        Ok(DelayDistribution { probabilities, loss })
    }

    /// P(delay = `d` steps); 0 beyond the largest delay.
    pub fn probability(&self, d: usize) -> f64 {
        self.probabilities.get(d).copied().unwrap_or(0.0)
    }

    /// P(delay = 0), P(delay = 1), .. up to the largest delay that occurs.
    pub fn probabilities(&self) -> &[f64] {
        &self.probabilities
    }

    /// Probability that a packet never arrives.
    pub fn loss(&self) -> f64 {
        self.loss
    }

    /// Largest delay that occurs, in steps.
    pub fn largest_delay(&self) -> usize {
        self.probabilities.len() - 1
    }

    /// Mean delay of the packets that arrive, in steps.
    pub fn mean_delay(&self) -> f64 {
        let delays = self.probabilities.iter().enumerate();
        delays.map(|(steps, probability)| steps as f64 * probability).sum::<f64>() / (1.0 - self.loss)
    }

    /// Q(`upto`): probability that a packet arrives with a delay of at most `upto` steps; 1 - loss from the
    /// largest delay on, so exactly 1 on a link without loss.
    pub fn arrival(&self, upto: usize) -> f64 {
        if upto >= self.largest_delay() {
            1.0 - self.loss
        } else {
            self.probabilities[..=upto].iter().sum::<f64>().min(1.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_mass_is_loss() {
        let link = DelayDistribution::new(vec![0.5, 0.0, 0.25]).unwrap();
        assert_eq!((link.loss(), link.largest_delay()), (0.25, 2));
        assert_eq!([0, 1, 2, 3].map(|d| link.probability(d)), [0.5, 0.0, 0.25, 0.0]);
        assert_eq!([0, 1, 2, 9].map(|d| link.arrival(d)), [0.5, 0.5, 0.75, 0.75]);
        assert_eq!(link.mean_delay(), 2.0 / 3.0);
    }

    #[test]
    fn rounding_is_not_loss() {
        let link = DelayDistribution::new(vec![0.1; 10]).unwrap();
        assert!(link.probabilities().iter().sum::<f64>() < 1.0);
        assert_eq!((link.loss(), link.arrival(9), link.arrival(50)), (0.0, 1.0, 1.0));
        assert_eq!(DelayDistribution::new(vec![1.0 - 1e-11]).unwrap().loss(), 1.0 - (1.0 - 1e-11));
    }

    #[test]
    fn rounded_figures_may_exceed_one_a_little() {
        let link = DelayDistribution::new(vec![0.5, 0.5 + 5e-10, 0.0]).unwrap();
        assert_eq!((link.loss(), link.arrival(1)), (0.0, 1.0));
        let sum = 1.0 + 2e-9;
        let error = DelayDistribution::new(vec![0.5, 0.5 + 2e-9]).unwrap_err();
        assert!(
            matches!(error, DistributionError::SumAboveOne { sum: found } if (found - sum).abs() < 1e-15)
        );
    }

    #[test]
    fn zeros_at_the_end_do_not_lengthen_a_link() {
        let link = DelayDistribution::new(vec![0.0, 0.9, 0.0, 0.0]).unwrap();
        assert_eq!(link.probabilities(), [0.0, 0.9]);
    }

    #[test]
    fn only_probabilities_are_accepted() {
        for wrong in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
            let error = DelayDistribution::new(vec![0.2, wrong]).unwrap_err();
            assert!(matches!(error, DistributionError::NotAProbability { delay: 1, .. }), "{wrong}");
        }
        for nothing in [vec![], vec![0.0, 0.0]] {
            assert_eq!(DelayDistribution::new(nothing), Err(DistributionError::NothingArrives));
        }
    }
}
