//! [`Link`]: what packets meet one after the other, and what a single one meets. How they travel is in [`crate::path`].

use crate::{delay::DelayDistribution, markov::MarkovLink, recording::Recording};
use std::sync::Arc;

/// A link between two nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Delay of a packet sent at any time: what gains are designed for that take packets as independent.
    pub delays: DelayDistribution,
    /// What packets meet one after the other.
    pub behaviour: Behaviour,
    /// Probability that a packet which arrives arrives once more, with a delay of its own.
    pub duplicates: f64,
}

/// What packets meet one after the other.
#[derive(Debug, Clone, PartialEq)]
pub enum Behaviour {
    /// Each packet meets its delay independently of the others. Thesis 3.1, Assumption 3.1.
    Independent,
    /// The quality comes and goes.
    Markov(MarkovLink),
    /// What was recorded, in the order recorded.
    Recorded(Arc<Recording>),
    /// What the other traffic on a bus leaves, with which the loop's other links share it: [`crate::loop_bus`].
    Bus,
}

impl Link {
    /// Independent delays and losses.
    pub fn independent(delays: DelayDistribution) -> Self {
        Self { delays, behaviour: Behaviour::Independent, duplicates: 0.0 }
    }

    /// A link whose quality comes and goes.
    pub fn markov(link: MarkovLink) -> Self {
        Self { delays: link.average().clone(), behaviour: Behaviour::Markov(link), duplicates: 0.0 }
    }

    /// A recorded link with the delays found in the record.
    pub fn recorded(delays: DelayDistribution, recording: Recording) -> Self {
        Self { delays, behaviour: Behaviour::Recorded(Arc::new(recording)), duplicates: 0.0 }
    }

    /// A link over a bus, with the delays found there.
    pub fn bus(delays: DelayDistribution) -> Self {
        Self { delays, behaviour: Behaviour::Bus, duplicates: 0.0 }
    }

    /// Whether packets go over a bus.
    pub fn is_on_bus(&self) -> bool {
        self.behaviour == Behaviour::Bus
    }

    /// Every packet arrives in the cycle it is sent in.
    pub fn perfect() -> Self {
        Self::independent(DelayDistribution::new(vec![1.0]).expect("certain arrival is a distribution"))
    }

    /// Largest delay that occurs, in cycles.
    pub fn largest_delay(&self) -> usize {
        match &self.behaviour {
            Behaviour::Recorded(recording) => recording.largest_delay(),
            Behaviour::Independent | Behaviour::Markov(_) | Behaviour::Bus => self.delays.largest_delay(),
        }
    }

    /// The channel, where its state tells more of the next packet than the average does.
    pub fn channel(&self) -> Option<&MarkovLink> {
        match &self.behaviour {
            Behaviour::Markov(link) => Some(link),
            Behaviour::Independent | Behaviour::Recorded(_) | Behaviour::Bus => None,
        }
    }
}
