//! Seconds as text to whole nanoseconds: binary fractions would move a packet from one cycle to another.

/// Nanoseconds since whatever the log counts from.
pub(super) type Nanoseconds = i64;

const PER_SECOND: i64 = 1_000_000_000;
/// Times beyond 146 years are refused, so that the difference of two always fits.
const FARTHEST: i64 = i64::MAX / 2;

/// Seconds in decimal, as `1436509052.249713` or `2.5e-3`; digits below a nanosecond are cut off.
pub(super) fn parse(text: &str) -> Option<Nanoseconds> {
    if text.contains(['e', 'E']) {
        let seconds: f64 = text.parse().ok()?;
        let nanoseconds = (seconds * PER_SECOND as f64).round();
        return (nanoseconds.abs() < FARTHEST as f64).then_some(nanoseconds as i64);
    }
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let numeric = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if (whole.is_empty() && fraction.is_empty()) || !numeric(whole) || !numeric(fraction) {
        return None;
    }
    let seconds: i64 = if whole.is_empty() { 0 } else { whole.parse().ok()? };
    let below = fraction.bytes().chain(std::iter::repeat(b'0')).take(9);
    let below = below.fold(0, |sum, digit| sum * 10 + i64::from(digit - b'0'));
    let time = seconds.checked_mul(PER_SECOND)?.checked_add(below)?;
    (time < FARTHEST).then_some(sign * time)
}

/// Seconds for a message.
pub(super) fn seconds(time: Nanoseconds) -> f64 {
    time as f64 / PER_SECOND as f64
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn decimals_are_read_exactly() {
        assert_eq!(parse("1436509052.249713"), Some(1_436_509_052_249_713_000));
        assert_eq!(parse("-0.5"), Some(-500_000_000));
        assert_eq!(
            (parse("7"), parse(".25"), parse("3.")),
            (Some(7_000_000_000), Some(250_000_000), Some(3_000_000_000))
        );
        assert_eq!((parse("2.5e-3"), parse("0.0000000019")), (Some(2_500_000), Some(1)));
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for wrong in
            ["", "-", ".", "1,5", "nan", "1.2.3", "1e30", "99999999999999", "4611686019", "0x1", "+1", "1 2"]
        {
            assert_eq!(parse(wrong), None, "{wrong}");
        }
    }
}
