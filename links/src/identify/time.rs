//! Seconds as text to whole nanoseconds: binary fractions would move a packet from one cycle to another.

/// Nanoseconds since whatever the log counts from.
pub(super) type Nanoseconds = i64;

const PER_SECOND: i64 = 1_000_000_000;
/// Times beyond 146 years are refused, so that the difference of two always fits, rounded or not.
const FARTHEST: i64 = i64::MAX / 2 - 1_000_000;

/// From this many seconds on a binary fraction of 64 bits holds no nanoseconds: 1.7e9 s, as since 1970, come 238 ns apart.
const COARSE: i64 = 1_000_000_000;
const MICROSECOND: i64 = 1000;

/// Seconds in decimal, as `1436509052.249713` or `2.5e-3`; digits below a nanosecond are cut off.
pub(super) fn parse(text: &str) -> Option<Nanoseconds> {
    parse_bytes(text.as_bytes())
}

/// As [`parse`], of bytes.
pub(super) fn parse_bytes(text: &[u8]) -> Option<Nanoseconds> {
    since_1970(text).or_else(|| scaled(text, PER_SECOND))
}

/// Ten digits, a point and six, as most logs have them: tens of millions of times.
fn since_1970(text: &[u8]) -> Option<Nanoseconds> {
    let &[a, b, ref whole @ .., b'.', c, d, e, f, g, h] = text else { return None };
    let below = eight([b'0', b'0', c, d, e, f, g, h])?;
    let (high, low) = (eight([b'0', b'0', b'0', b'0', b'0', b'0', a, b])?, eight(whole.try_into().ok()?)?);
    let time = ((high * 100_000_000 + low) as i64).checked_mul(PER_SECOND)? + below as i64 * MICROSECOND;
    near(time)
}

/// The number that eight digits make, two and two and two together.
fn eight(digits: [u8; 8]) -> Option<u64> {
    let word = u64::from_le_bytes(digits);
    let (above, below) = (word.wrapping_add(0x4646_4646_4646_4646), word.wrapping_sub(0x3030_3030_3030_3030));
    if (above | below) & 0x8080_8080_8080_8080 != 0 {
        return None;
    }
    let pairs = (below * 10 + (below >> 8)) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs * 100 + (pairs >> 16)) & 0x0000_ffff_0000_ffff;
    Some((fours & 0xffff) * 10_000 + (fours >> 32))
}

/// A decimal number of units of `unit` nanoseconds each.
pub(super) fn scaled(text: &[u8], unit: i64) -> Option<Nanoseconds> {
    let (negative, digits) = match text {
        [b'-', digits @ ..] => (true, digits),
        _ => (false, text),
    };
    let (mut whole, mut at) = (0_i64, 0);
    while let Some(digit) = digits.get(at).map(|byte| byte.wrapping_sub(b'0')).filter(|digit| *digit < 10) {
        whole = whole.checked_mul(10)?.checked_add(i64::from(digit))?;
        at += 1;
    }
    let (mut fraction, mut place, mut decimals) = (0, unit, 0);
    match digits.get(at) {
        None if at > 0 => {}
        Some(b'.') if digits.len() > 1 => {
            for byte in &digits[at + 1..] {
                let digit = byte.wrapping_sub(b'0');
                if digit > 9 {
                    return with_exponent(text, unit);
                }
                place /= 10;
                fraction += i64::from(digit) * place;
                decimals += 1;
            }
        }
        _ => return with_exponent(text, unit),
    }
    let time = whole.checked_mul(unit)?.checked_add(fraction)?;
    let time =
        if decimals == 7 && unit == PER_SECOND && whole >= COARSE { to_microseconds(time) } else { time };
    (time < FARTHEST).then_some(if negative { -time } else { time })
}

fn with_exponent(text: &[u8], unit: i64) -> Option<Nanoseconds> {
    let text = std::str::from_utf8(text).ok().filter(|text| text.contains(['e', 'E']))?;
    let nanoseconds = (text.parse::<f64>().ok()? * unit as f64).round();
    let time = (nanoseconds.abs() < FARTHEST as f64).then_some(nanoseconds as i64)?;
    Some(if time.abs() >= COARSE * PER_SECOND { to_microseconds(time) } else { time })
}

/// To the nearest microsecond: times that went through a binary fraction, or were cut, miss a whole one by less.
pub(super) fn to_microseconds(time: Nanoseconds) -> Nanoseconds {
    (time + MICROSECOND / 2).div_euclid(MICROSECOND) * MICROSECOND
}

/// Date and time of day as `2023-11-14 22:13:20.500100`, with `T` between or an offset from UTC behind.
pub(super) fn date(text: &str) -> Option<Nanoseconds> {
    let (day, rest) = (text.get(..10)?, text.get(11..)?);
    if !matches!(text.as_bytes()[10], b' ' | b'T' | b't' | b'_') {
        return None;
    }
    let mut parts = day.split('-').map(|part| part.parse::<i64>().ok());
    let (year, month, day) = (parts.next()??, parts.next()??, parts.next()??);
    let (clock, zone) = match rest.find(['Z', 'z', '+', '-']) {
        Some(at) => rest.split_at(at),
        None => (rest, ""),
    };
    let mut parts = clock.trim_end().split(':');
    let (hour, minute) = (parts.next()?.parse::<i64>().ok()?, parts.next()?.parse::<i64>().ok()?);
    let second = parts.next().map_or(Some(0), |second| parse(&second.replace(',', ".")))?;
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) || !(1..=9999).contains(&year) {
        return None;
    }
    if !(0..24).contains(&hour) || !(0..60).contains(&minute) || !(0..=60 * PER_SECOND).contains(&second) {
        return None;
    }
    let east = match zone.as_bytes() {
        [] | [b'Z' | b'z'] => 0,
        [sign, ..] => {
            let digits: String = zone[1..].chars().filter(|letter| *letter != ':').collect();
            let (hours, minutes) = (digits.get(..2)?.parse::<i64>().ok()?, digits.get(2..4).unwrap_or("0"));
            let minutes = hours * 60 + minutes.parse::<i64>().ok()?;
            if *sign == b'-' { -minutes } else { minutes }
        }
    };
    let minutes = (days(year, month, day) * 24 + hour) * 60 + minute - east;
    Some(minutes * 60 * PER_SECOND + second).filter(|time| time.abs() < FARTHEST)
}

/// Days from 1970 on, in the Gregorian calendar, with years that begin in March.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * month + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

/// The time, if it is not too far for differences.
pub(super) fn near(time: Nanoseconds) -> Option<Nanoseconds> {
    (time.unsigned_abs() < FARTHEST as u64).then_some(time)
}

/// A time after another one, if it is not too far.
pub(super) fn after(time: Nanoseconds, by: Nanoseconds) -> Option<Nanoseconds> {
    near(time.saturating_add(by))
}

/// The nearest time that is not too far.
pub(super) fn clamped(time: Nanoseconds) -> Nanoseconds {
    time.clamp(-FARTHEST, FARTHEST)
}

/// Seconds for a message.
pub(super) fn seconds(time: Nanoseconds) -> f64 {
    time as f64 / PER_SECOND as f64
}

#[cfg(test)]
mod tests {
    use super::{date, parse};

    #[test]
    fn decimals_are_read_exactly() {
        assert_eq!(parse("1436509052.249713"), Some(1_436_509_052_249_713_000));
        assert_eq!(parse("0000000000.000001"), Some(1000));
        assert_eq!(parse("9999999999.000000"), None, "too far");
        assert_eq!(parse("-0.5"), Some(-500_000_000));
        assert_eq!(
            (parse("7"), parse(".25"), parse("3.")),
            (Some(7_000_000_000), Some(250_000_000), Some(3_000_000_000))
        );
        assert_eq!((parse("2.5e-3"), parse("0.0000000019")), (Some(2_500_000), Some(1)));
    }

    #[test]
    fn times_from_binary_fractions_are_whole_microseconds_again() {
        assert_eq!(parse("1700000000.5000999"), Some(1_700_000_000_500_100_000));
        assert_eq!(parse("1.7000000005001e+09"), Some(1_700_000_000_500_100_000));
        assert_eq!(parse("0.5000999"), Some(500_099_900));
    }

    #[test]
    fn dates_are_seconds_since_1970() {
        let expected = Some(1_700_000_000_500_100_000);
        for text in [
            "2023-11-14 22:13:20.500100",
            "2023-11-14T22:13:20.5001Z",
            "2023-11-14 23:13:20.500100+01:00",
            "2023-11-14 20:43:20.5001-0130",
        ] {
            assert_eq!(date(text), expected, "{text}");
        }
        assert_eq!(date("1970-01-01 00:00:00"), Some(0));
        assert_eq!(date("2000-02-29 12:00"), Some(951_825_600_000_000_000));
        for wrong in
            ["2023-11-14", "2023-13-14 00:00:00", "2023-11-14 25:00:00", "20231114 221320", "é", "1,5"]
        {
            assert_eq!(date(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for wrong in [
            "",
            "-",
            ".",
            "1,5",
            "nan",
            "1.2.3",
            "1e30",
            "99999999999999",
            "4611686019",
            "0x1",
            "+1",
            "1 2",
            "143650905:.249713",
            "1436509052.24971/",
        ] {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
