//! Nodes that are killed in the middle of a run, and come back.

use crate::random::common;
use rand::Rng;
use slqg::wire::Role;
use std::ops::Range;

/// A node that is not there for some cycles: it is killed, and started anew without memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Restart {
    /// Which node.
    pub role: Role,
    /// The cycles without it.
    pub away: Range<usize>,
}

/// Why a text is no restart.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "found {0:?}; give controller@CYCLE or actuator@CYCLE, and how many cycles it is away: controller@5000+10"
)]
pub struct NoRestart(String);

impl std::str::FromStr for Restart {
    type Err = NoRestart;

    fn from_str(text: &str) -> Result<Self, NoRestart> {
        let restart = || {
            let (role, when) = text.split_once('@')?;
            let role = match role {
                "controller" => Role::Controller,
                "actuator" => Role::Actuator,
                _ => return None,
            };
            let (cycle, away) = when.split_once('+').unwrap_or((when, "10"));
            let (cycle, away): (usize, usize) = (cycle.parse().ok()?, away.parse().ok()?);
            (away > 0).then(|| Self { role, away: cycle..cycle.saturating_add(away) })
        };
        restart().ok_or_else(|| NoRestart(text.to_owned()))
    }
}

/// `count` restarts of either node at random cycles of `cycles`, each away for up to `longest` cycles, in order and without
/// two at once.
pub fn at_random(count: usize, cycles: usize, longest: usize, seed: u64) -> Vec<Restart> {
    let mut random = common(seed);
    let room = cycles / count.max(1);
    (0..count)
        .map(|index| {
            let away = random.random_range(1..=longest.min(room / 2).max(1));
            let begin = index * room + random.random_range(0..=room.saturating_sub(away + 1));
            let role = if random.random_bool(0.5) { Role::Controller } else { Role::Actuator };
            Restart { role, away: begin..begin + away }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_restart_is_read_from_node_cycle_and_cycles_away() {
        let restart: Restart = "controller@5000+3".parse().unwrap();
        assert_eq!(restart, Restart { role: Role::Controller, away: 5000..5003 });
        assert_eq!("actuator@7".parse::<Restart>().unwrap().away, 7..17);
        for text in ["motor@5", "controller", "actuator@x", "actuator@5+0"] {
            assert!(text.parse::<Restart>().is_err(), "{text}");
        }
    }

    #[test]
    fn restarts_at_random_do_not_overlap_and_fit_the_run() {
        let restarts = at_random(100, 10_000, 20, 1);
        assert_eq!(restarts.len(), 100);
        assert!(restarts.windows(2).all(|pair| pair[0].away.end <= pair[1].away.start));
        assert!(restarts.iter().all(|restart| restart.away.end < 10_000));
        assert!(restarts.iter().any(|restart| restart.role == Role::Actuator));
    }
}
