//! What a report tells of a link whose quality comes and goes: designs that know more or less of it, on the true channel.

use super::Report;
use crate::design::Design;
use crate::solve::{ChannelSolution, Correlated, LoopProblem, TooManyModes, correlated, solve_channel};

/// Designs for the channel of the link to the actuator.
#[derive(Debug, Clone)]
pub struct ChannelDesigns {
    /// Modes, and the designs with their costs.
    pub correlated: Correlated,
    /// The law that knows the channel, in the form the device computes.
    pub in_flight: ChannelSolution,
}

impl ChannelDesigns {
    /// Designs for the link's channel; `None` if packets are independent on it.
    ///
    /// # Errors
    /// The channel has too many states for this sequence length.
    pub fn of(design: &Design, problem: &LoopProblem) -> Option<Result<Self, TooManyModes>> {
        let channel = design.network.controller_to_actuator.channel()?;
        let designs = correlated(problem, channel, &design.plant.process_noise);
        Some(designs.map(|correlated| Self { correlated, in_flight: solve_channel(problem, channel) }))
    }
}

impl Report {
    /// Adds the designs for the channel, if the link to the actuator has one. Dense: slow for long sequences.
    ///
    /// # Errors
    /// The channel has too many states for this sequence length.
    pub fn find_channel(&mut self) -> Result<(), TooManyModes> {
        let problem = LoopProblem::of(&self.design);
        self.channel = ChannelDesigns::of(&self.design, &problem).transpose()?;
        Ok(())
    }
}
