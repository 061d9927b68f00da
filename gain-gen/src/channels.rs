//! Links whose packets depend on each other through a channel that is known: what they really do to the loop.
//!
//! Gains and the table of arrival probabilities are those for the average link. On the chain of age and channel the loop with
//! them is a jump-linear system like any other, and its mean-square rate decides exactly. The error of the estimate depends on
//! what the actuator is sent as little as on an independent link; [`crate::estimation`] decides on it.

use crate::design::{Behaviour, DelayDistribution, Design, Link, MarkovLink};
use crate::solve::{ClosedLoop, LoopProblem, ModeChain, Solution, modes};
use crate::units::Units;
use slqg::estimator::Merging;

/// Multiplications of one step over all modes up to which their rate is computed.
const MOST_WORK: usize = 20_000_000;

/// The loop with the gains as emitted, state known, on the channel of the link to the actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ControlOnChannel {
    /// Its mean-square rate.
    Rate {
        /// Per step.
        rate: f64,
        /// Modes of age and channel.
        modes: usize,
    },
    /// Too large for its rate to be computed.
    TooLarge,
}

/// The channel that packets on the link meet; `None` where they are independent with the link's own delays, and where nothing
/// is known of how they depend on each other. Copies count: of a packet and its copy the first counts.
pub(crate) fn channel(link: &Link) -> Option<MarkovLink> {
    let copied = |delays: &DelayDistribution| first_arrival(delays, link.duplicates);
    match &link.behaviour {
        Behaviour::Independent if link.duplicates > 0.0 => {
            MarkovLink::new(vec![vec![1.0]], vec![copied(&link.delays)]).ok()
        }
        Behaviour::Markov(channel) => {
            let states = 0..channel.states();
            let transitions =
                states.clone().map(|from| states.clone().map(|to| channel.transition(from, to)).collect());
            let delays = states.clone().map(|state| channel.delays(state).map(copied).unwrap_or_default());
            MarkovLink::new(transitions.collect(), delays.collect()).ok()
        }
        Behaviour::Independent | Behaviour::Recorded(_) | Behaviour::Bus => None,
    }
}

/// P(the first arrival is 0, 1, .. cycles late) where a packet that arrives arrives once more with this probability, with a
/// delay of its own or not at all.
fn first_arrival(delays: &DelayDistribution, duplicates: f64) -> Vec<f64> {
    let in_the_end = delays.arrival(delays.largest_delay());
    let by = |delay: usize| {
        let once = delays.arrival(delay);
        once + (in_the_end - once) * duplicates * once
    };
    let before = |delay: usize| delay.checked_sub(1).map_or(0.0, by);
    (0..=delays.largest_delay()).map(|delay| (by(delay) - before(delay)).max(0.0)).collect()
}

/// What the problem's loop comes to on the channel of its link; `None` where that has none, or there are no gains.
pub(crate) fn control(
    design: &Design,
    problem: &LoopProblem,
    solution: &Solution,
) -> Option<ControlOnChannel> {
    let channel = channel(&design.network.controller_to_actuator)?;
    // Of the linear estimator's law it is not known.
    if !solution.is_stabilising() || design.estimator() == Merging::Linear {
        return None;
    }
    let units = Units::of(&design.plant);
    let plant = units.plant(&design.plant);
    let law = units.law(&solution.law.rounded_to(design.controller.scalar));
    let problem = LoopProblem { a: plant.a, b: plant.b, ..problem.clone() };
    let Ok(chain) = ModeChain::with_channel(&channel, problem.length) else {
        return Some(ControlOnChannel::TooLarge);
    };
    let loops = modes(&problem);
    let of_ages = law.mode_gains();
    let size = loops[0].a.nrows();
    let count = chain.ages.len();
    if count * size.pow(3) > MOST_WORK {
        return Some(ControlOnChannel::TooLarge);
    }
    let gains: Vec<_> = chain.ages.iter().map(|&age| of_ages[age].clone()).collect();
    let rate = ClosedLoop { modes: &loops, chain: &chain, gains: &gains }.rate();
    Some(ControlOnChannel::Rate { rate, modes: count })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::{Method, solve};

    const CRITICAL: &str = include_str!("../../designs/critical.toml");

    #[test]
    fn a_channel_whose_states_are_alike_has_the_rate_of_independent_packets() {
        let mut design = Design::parse(CRITICAL, "critical.toml").expect("a design");
        let problem = LoopProblem::of(&design);
        let solution = solve(&problem, Method::InFlight);
        let delays = problem.link.probabilities().to_vec();
        let alike = MarkovLink::gilbert_elliott(0.1, 0.3, delays.clone(), delays).expect("a channel");
        design.network.controller_to_actuator = Link::markov(alike);
        let found = control(&design, &problem, &solution).expect("a channel");
        let ControlOnChannel::Rate { rate, .. } = found else { panic!("{found:?}") };
        let expected = solution.emitted_rate(&problem, design.controller.scalar);
        assert!((rate - expected).abs() < 1e-8, "{rate} {expected}");
    }

    #[test]
    fn a_copy_moves_the_first_arrival_ahead_and_loses_nothing() {
        let delays = DelayDistribution::new(vec![0.5, 0.3]).expect("a distribution");
        let found = first_arrival(&delays, 0.5);
        // Late by itself and copied in time: 0.3 * 0.5 * 0.5.
        assert!((found[0] - 0.575).abs() < 1e-15 && (found[1] - 0.225).abs() < 1e-15, "{found:?}");
    }
}
