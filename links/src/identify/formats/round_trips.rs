//! `ping -D -O` and `fping -D`: round trips. Half of one is taken for the way there, and only if the user says so.

use super::{
    super::{
        join::Joined,
        logs::Selection,
        pairing,
        time::{self, Nanoseconds},
        trace::{Gaps, Trace, TraceError},
    },
    words::quoted,
};
use std::{collections::BTreeMap, path::Path};

const MILLISECOND: i64 = 1_000_000;
/// No answer takes longer than an hour.
const LONGEST: i64 = 3_600_000_000_000;

/// Which tool wrote a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in super::super) enum Tool {
    Ping,
    Fping,
}

/// What a line says of a packet: when it was printed, its number, and the round trip if it came back.
type Answer = (Nanoseconds, u64, Option<Nanoseconds>);

/// Reads the answers. A packet counts as lost if none came, on whichever of the two ways.
pub(in super::super) fn read(
    file: &Path,
    bytes: &[u8],
    tool: Tool,
    selection: &Selection<'_>,
) -> Result<Trace, TraceError> {
    if !selection.halves_round_trips {
        let name = if tool == Tool::Ping { "ping" } else { "fping" };
        let problem = format!(
            "is output of {name}, which has round trips only: give --half-round-trip to take half of each for the delay, which assumes that both \
             ways take equally long, and every loss for one of this way; or measure one way with irtt, owping or two captures"
        );
        return Err(TraceError::file(file, problem));
    }
    let text = String::from_utf8_lossy(bytes);
    let mut packets: BTreeMap<u64, (Nanoseconds, Option<Nanoseconds>)> = BTreeMap::new();
    let mut duplicates = 0;
    for (index, line) in text.lines().enumerate() {
        let answer = match tool {
            Tool::Ping => ping(line),
            Tool::Fping => fping(line),
        };
        let answer = answer.map_err(|problem| TraceError::line(file, index as u64 + 1, problem))?;
        let Some((printed, number, round_trip)) = answer else { continue };
        let known = packets.entry(number).or_insert((printed, None));
        match (known.1, round_trip) {
            (Some(_), Some(_)) => duplicates += 1,
            // "No answer yet" may be followed by the answer.
            (None, Some(round_trip)) => *known = (printed - round_trip, Some(round_trip / 2)),
            _ => {}
        }
    }
    let mut joined = Joined { duplicates, ..Joined::default() };
    for (number, (sent, half)) in packets {
        match half {
            Some(half) => joined.arrived(number, sent, sent + half),
            None => joined.packets.push(number, sent, None),
        }
    }
    // ping without -O is silent about what did not come back.
    let gaps = selection.gaps.unwrap_or(Gaps::Lost);
    let mut trace =
        pairing::of_one_way(joined, gaps, selection).map_err(|problem| TraceError::file(file, problem))?;
    trace.about.number = Some("number of the round trip".into());
    trace.about.notes.push(
        "half of each round trip is taken for the delay (--half-round-trip), and what was lost on either way for a loss of this one".into(),
    );
    Ok(trace)
}

/// `[1795812804.893442] 64 bytes from 127.0.0.1: icmp_seq=1 ttl=64 time=0.110 ms`
fn ping(line: &str) -> Result<Option<Answer>, String> {
    let Some(number) = word_after(line, "icmp_seq=") else { return Ok(None) };
    let wrong = || format!("found {}; give output of ping -D -O", quoted(line.as_bytes()));
    let number = number.parse().map_err(|_| wrong())?;
    let Some(printed) = printed(line) else {
        return Err(format!("found {} without a time; give output of ping -D -O", quoted(line.as_bytes())));
    };
    let round_trip = match word_after(line, "time=") {
        Some(text) => Some(
            time::scaled(text.as_bytes(), MILLISECOND)
                .filter(|time| (0..LONGEST).contains(time))
                .ok_or_else(wrong)?,
        ),
        None => None,
    };
    Ok(Some((printed, number, round_trip)))
}

/// `[1795812814.55687] 127.0.0.1 : [0], 64 bytes, 0.035 ms (0.035 avg, 0% loss)`, or `timed out` for the answer.
fn fping(line: &str) -> Result<Option<Answer>, String> {
    let Some((_, rest)) = line.split_once(" : [") else { return Ok(None) };
    let wrong = || format!("found {}; give output of fping -D -l or -c", quoted(line.as_bytes()));
    let (number, rest) = rest.split_once(']').ok_or_else(wrong)?;
    let number = number.parse().map_err(|_| wrong())?;
    let printed = printed(line).ok_or_else(wrong)?;
    if rest.contains("timed out") {
        return Ok(Some((printed, number, None)));
    }
    let text = rest.split(", ").nth(2).and_then(|part| part.split(' ').next()).ok_or_else(wrong)?;
    let round_trip = time::scaled(text.as_bytes(), MILLISECOND)
        .filter(|time| (0..LONGEST).contains(time))
        .ok_or_else(wrong)?;
    Ok(Some((printed, number, Some(round_trip))))
}

fn printed(line: &str) -> Option<Nanoseconds> {
    time::after(time::parse(line.strip_prefix('[')?.split_once(']')?.0)?, -LONGEST).map(|time| time + LONGEST)
}

fn word_after<'l>(line: &'l str, key: &str) -> Option<&'l str> {
    let rest = &line[line.find(key)? + key.len()..];
    rest.split(|letter: char| letter.is_whitespace()).next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_and_missing_answers_are_read() {
        assert_eq!(
            ping("[1.5] 64 bytes from 127.0.0.1: icmp_seq=7 ttl=64 time=0.110 ms"),
            Ok(Some((1_500_000_000, 7, Some(110_000))))
        );
        assert_eq!(ping("[1.5] no answer yet for icmp_seq=38"), Ok(Some((1_500_000_000, 38, None))));
        assert_eq!(ping("--- 127.0.0.1 ping statistics ---"), Ok(None));
        assert!(ping("64 bytes from 127.0.0.1: icmp_seq=7 ttl=64 time=0.110 ms").is_err());
        assert_eq!(
            fping("[1.5] 127.0.0.1 : [3], 64 bytes, 0.035 ms (0.035 avg, 0% loss)"),
            Ok(Some((1_500_000_000, 3, Some(35_000))))
        );
        assert_eq!(
            fping("[1.5] 127.0.0.1 : [3], timed out (NaN avg, 100% loss)"),
            Ok(Some((1_500_000_000, 3, None)))
        );
    }
}
