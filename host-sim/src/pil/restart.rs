//! Nodes that are killed in the middle of a run, and come back.

use super::remote::name;
use crate::random::common;
use rand::Rng;
use slqg::wire::Role;
use std::{fmt, ops::Range};

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

/// Why restarts cannot be in a run.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Misplaced {
    /// The node would not be back before the run ends.
    #[error(
        "--restart {restart}: the run has {cycles} cycles, and the node must be back before the last one ends: {}",
        allowed(restart, *cycles)
    )]
    Outside {
        /// Which.
        restart: Restart,
        /// Cycles of the run.
        cycles: usize,
    },
    /// The node is killed while it is not there.
    #[error(
        "--restart {next}: by {before} the {} is away and back in cycle {}: give that cycle or a later one",
        name(next.role), before.away.end
    )]
    Overlapping {
        /// The one that is too early.
        next: Restart,
        /// The one before it.
        before: Restart,
    },
    /// There are more random ones than the run has room for.
    #[error("--restarts: found {count}; a run of {cycles} cycles has room for up to {}", cycles / 2)]
    TooMany {
        /// Restarts.
        count: usize,
        /// Cycles of the run.
        cycles: usize,
    },
}

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

/// As on the command line.
impl fmt::Display for Restart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}@{}+{}", name(self.role), self.away.start, self.away.len())
    }
}

/// Restarts in the order in which nodes are killed. The two nodes may be away at once.
///
/// # Errors
/// If a node is not back before the run of `cycles` cycles ends, or is killed while it is away.
pub fn in_order(mut restarts: Vec<Restart>, cycles: usize) -> Result<Vec<Restart>, Misplaced> {
    restarts.sort_by_key(|restart| restart.away.start);
    for (index, restart) in restarts.iter().enumerate() {
        if restart.away.end >= cycles {
            return Err(Misplaced::Outside { restart: restart.clone(), cycles });
        }
        let before = restarts[..index].iter().rfind(|before| before.role == restart.role);
        if let Some(before) = before.filter(|before| before.away.end > restart.away.start) {
            return Err(Misplaced::Overlapping { next: restart.clone(), before: before.clone() });
        }
    }
    Ok(restarts)
}

/// `count` restarts of either node at random cycles of `cycles`, each away for up to `longest` cycles, in order and without
/// two at once.
///
/// # Errors
/// If there is no room for as many.
pub fn at_random(count: usize, cycles: usize, longest: usize, seed: u64) -> Result<Vec<Restart>, Misplaced> {
    let mut random = common(seed);
    let room = cycles / count.max(1);
    if room < 2 {
        return Err(Misplaced::TooMany { count, cycles });
    }
    Ok((0..count)
        .map(|index| {
            let away = random.random_range(1..=longest.min(room / 2).max(1));
            let begin = index * room + random.random_range(0..=room.saturating_sub(away + 1));
            let role = if random.random_bool(0.5) { Role::Controller } else { Role::Actuator };
            Restart { role, away: begin..begin + away }
        })
        .collect())
}

/// Which cycles there are for a restart.
fn allowed(restart: &Restart, cycles: usize) -> String {
    let away = restart.away.len();
    match cycles.checked_sub(away + 1) {
        Some(latest) => format!("if it is away for {away}, give a cycle from 0 to {latest}"),
        None => format!("it can be away for less than {cycles} cycles"),
    }
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
        let restarts = at_random(100, 10_000, 20, 1).unwrap();
        assert_eq!(restarts.len(), 100);
        assert!(restarts.windows(2).all(|pair| pair[0].away.end <= pair[1].away.start));
        assert!(restarts.iter().all(|restart| restart.away.end < 10_000));
        assert!(restarts.iter().any(|restart| restart.role == Role::Actuator));
        let tight = at_random(100, 200, 20, 1).unwrap();
        assert_eq!(in_order(tight.clone(), 200), Ok(tight));
        let found = at_random(100, 199, 20, 1).unwrap_err().to_string();
        assert!(found.ends_with("a run of 199 cycles has room for up to 99"), "{found}");
    }

    #[test]
    fn restarts_are_put_in_order_and_those_that_cannot_be_are_named() {
        let order = |texts: &[&str]| {
            let restarts = texts.iter().map(|text| text.parse().unwrap()).collect();
            in_order(restarts, 100).map(|all| all.iter().map(Restart::to_string).collect::<Vec<_>>())
        };
        let both = ["actuator@12+10", "controller@20+5", "controller@25+74"];
        assert_eq!(order(&[both[2], both[1], both[0]]).unwrap(), both, "back and killed again, at once");
        let found = order(&["controller@90+10"]).unwrap_err().to_string();
        let expected = "--restart controller@90+10: the run has 100 cycles";
        assert!(found.starts_with(expected) && found.ends_with("from 0 to 89"), "{found}");
        let found = order(&["actuator@0+100"]).unwrap_err().to_string();
        assert!(found.ends_with("it can be away for less than 100 cycles"), "{found}");
        let found = order(&["controller@14", "actuator@12", "controller@5"]).unwrap_err().to_string();
        let expected =
            "--restart controller@14+10: by controller@5+10 the controller is away and back in cycle 15";
        assert!(found.starts_with(expected), "{found}");
    }
}
