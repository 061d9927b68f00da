//! The controller that is told the state of a channel that comes and goes.

use super::{Contender, ContenderError};
use gain_gen::{
    design::{Design, MarkovLink},
    solve::{LoopProblem, Outcome, solve_channel},
};

/// Most tables of arrival probabilities that a simulated controller may choose from.
pub(super) const MOST_TABLES: usize = 1 << 14;

impl Contender {
    /// Gives it gains for each state of the channel.
    pub(super) fn know_channel(
        &mut self,
        problem: &LoopProblem,
        design: &Design,
    ) -> Result<(), ContenderError> {
        let controller = self.kind.name();
        let channel = self.actuator_link.channel().ok_or(ContenderError::NoChannel)?;
        // The simulator looks arrival probabilities up by the states of all cycles that count.
        let tables = channel.states().checked_pow(problem.length.max(2) as u32 - 1);
        if tables.is_none_or(|tables| tables > MOST_TABLES) {
            return Err(ContenderError::TooManyTables { states: channel.states(), length: problem.length });
        }
        let solution = solve_channel(problem, channel);
        if solution.outcome != Outcome::Converged {
            return Err(ContenderError::Unstable { controller });
        }
        let law = solution.law;
        self.must_see(design)?;
        self.laws = (0..law.channel_states()).map(|state| law.at(&[state])).collect();
        self.channel = Some(law);
        Ok(())
    }

    /// The state in which the channel to the actuator is most of the time; 0 without one.
    pub fn usual_channel_state(&self) -> usize {
        let shares = self.actuator_link.channel().map_or(&[] as &[f64], MarkovLink::shares);
        (0..shares.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b])).unwrap_or(0)
    }
}
