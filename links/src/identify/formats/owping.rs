//! `owping -R`: a line per packet with both times as 64-bit fixed point with 32 bits below the second.

use super::{
    super::{
        join::Joined,
        logs::Selection,
        pairing,
        time::Nanoseconds,
        trace::{Gaps, Trace, TraceError},
    },
    words::{Words, quoted},
};
use std::path::Path;

/// Seconds from 1900, from which OWAMP counts, to 1970.
const TO_1970: i64 = 2_208_988_800;

/// Number, time sent, synchronised, error, time received, synchronised, error, time to live; a packet that was lost was received at 0.
pub(in super::super) fn read(
    file: &Path,
    bytes: &[u8],
    selection: &Selection<'_>,
) -> Result<Trace, TraceError> {
    let mut rows: Vec<(u64, Nanoseconds, Option<Nanoseconds>)> = Vec::new();
    let mut is_synchronised = true;
    for (index, text) in bytes.split(|byte| *byte == b'\n').enumerate() {
        let text = text.trim_ascii();
        if text.is_empty() || text.starts_with(b"#") {
            continue;
        }
        let wrong = || {
            TraceError::line(
                file,
                index as u64 + 1,
                format!("found {}; give lines of owping -R", quoted(text)),
            )
        };
        let words: Vec<&[u8]> = Words(text).collect();
        let number =
            |at: usize| words.get(at).and_then(|word| std::str::from_utf8(word).ok()?.parse::<u64>().ok());
        let (Some(sequence), Some(sent), Some(received)) = (number(0), number(1), number(4)) else {
            return Err(wrong());
        };
        let sent = nanoseconds(sent).ok_or_else(wrong)?;
        let received = if received == 0 { None } else { Some(nanoseconds(received).ok_or_else(wrong)?) };
        is_synchronised &= number(2) == Some(1) && (received.is_none() || number(5) == Some(1));
        rows.push((sequence, sent, received));
    }
    let all = rows.len();
    rows.sort_by_key(|(sequence, _, received)| (*sequence, received.is_none(), *received));
    rows.dedup_by_key(|(sequence, ..)| *sequence);
    let mut joined = Joined { duplicates: (all - rows.len()) as u64, ..Joined::default() };
    for (sequence, sent, received) in rows {
        match received {
            Some(received) => joined.arrived(sequence, sent, received),
            None => joined.packets.push(sequence, sent, None),
        }
    }
    let mut trace = pairing::of_one_way(joined, selection.gaps.unwrap_or(Gaps::Ignore), selection)
        .map_err(|problem| TraceError::file(file, problem))?;
    trace.about.number = Some("owping's sequence number".into());
    if !is_synchronised {
        trace
            .about
            .notes
            .push("owping says that a clock was not synchronised: delays may be wrong by any amount".into());
    }
    Ok(trace)
}

/// To the nearest nanosecond; nothing before 1970 or after 2036.
fn nanoseconds(fixed: u64) -> Option<Nanoseconds> {
    let whole = (fixed >> 32) as i64 - TO_1970;
    let below = ((fixed & 0xffff_ffff) * 1_000_000_000 + (1 << 31)) >> 32;
    (whole >= 0).then_some(whole * 1_000_000_000 + below as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_point_is_rounded_to_nanoseconds() {
        // 1700000000.5 s
        let fixed = (1_700_000_000_u64 + 2_208_988_800) << 32 | 1 << 31;
        assert_eq!(nanoseconds(fixed), Some(1_700_000_000_500_000_000));
        assert_eq!(nanoseconds(1 << 32), None);
    }
}
