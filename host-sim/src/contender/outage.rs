//! Cycles in which the links bring nothing.

use slqg_links::loop_bus::Role;
use std::{fmt, ops::Range, str::FromStr};

/// An outage: of frames that are sent in these cycles none arrives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outage {
    /// Which frames; `None`: all.
    pub role: Option<Role>,
    /// When they are sent.
    pub cycles: Range<u64>,
}

/// Why a text is no outage.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "found {0:?}; give CYCLE+CYCLES, such as 5000+58, for all links, or one of them: sensor@5000+58, control@5000+58, acknowledgement@5000+58"
)]
pub struct NoOutage(String);

/// Names of the links, as on the command line.
const LINKS: [(&str, Role); Role::COUNT] =
    [("sensor", Role::Measurement), ("control", Role::Control), ("acknowledgement", Role::Acknowledgement)];

impl Outage {
    /// Whether a frame of this role that is sent in this cycle is lost.
    pub fn loses(&self, role: Role, cycle: u64) -> bool {
        self.role.is_none_or(|lost| lost == role) && self.cycles.contains(&cycle)
    }
}

impl FromStr for Outage {
    type Err = NoOutage;

    fn from_str(text: &str) -> Result<Self, NoOutage> {
        let outage = || {
            let (role, cycles) = match text.split_once('@') {
                Some((name, cycles)) => (Some(LINKS.iter().find(|(link, _)| *link == name)?.1), cycles),
                None => (None, text),
            };
            let (begin, length) = cycles.split_once('+')?;
            let (begin, length): (u64, u64) = (begin.parse().ok()?, length.parse().ok()?);
            (length > 0).then(|| Some(Self { role, cycles: begin..begin.checked_add(length)? }))?
        };
        outage().ok_or_else(|| NoOutage(text.to_owned()))
    }
}

/// As on the command line.
impl fmt::Display for Outage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((name, _)) = LINKS.iter().find(|(_, role)| Some(*role) == self.role) {
            write!(f, "{name}@")?;
        }
        write!(f, "{}+{}", self.cycles.start, self.cycles.end - self.cycles.start)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outage_is_read_from_link_cycle_and_cycles() {
        for text in ["5000+58", "sensor@0+1", "control@7+2", "acknowledgement@3+9"] {
            let outage: Outage = text.parse().expect("an outage");
            assert_eq!(outage.to_string(), text);
        }
        let outage: Outage = "control@7+2".parse().expect("an outage");
        let lost = |role| (0..12).filter(|cycle| outage.loses(role, *cycle)).collect::<Vec<_>>();
        assert_eq!((lost(Role::Control), lost(Role::Measurement)), (vec![7, 8], vec![]));
        for text in ["", "58", "5+0", "radio@5+8", "5+x", "-1+4", "18446744073709551615+2"] {
            assert_eq!(text.parse::<Outage>(), Err(NoOutage(text.to_owned())), "{text}");
        }
    }
}
