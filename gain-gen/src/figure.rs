//! How numbers are spelled for people: enough digits to compare, no more.

/// Digits that count in results.
const DIGITS: usize = 6;
/// Digits that count in durations.
const FEW_DIGITS: usize = 4;
/// Digits after which two `f64` no longer differ.
const MOST_DIGITS: usize = 17;

/// `value` with six significant digits and no zeros at the end; more where it would otherwise read 1 and is not.
///
/// Rates are compared with 1, so one that is not must not be shown as one.
pub(crate) fn figure(value: f64) -> String {
    if !value.is_finite() {
        return "unbounded".into();
    }
    (DIGITS..=MOST_DIGITS)
        .map(|digits| spelled(value, digits))
        .find(|text| value == 1.0 || text != "1")
        .unwrap_or_else(|| value.to_string())
}

fn spelled(value: f64, digits: usize) -> String {
    let scientific = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..digits as i32).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).unsigned_abs() as usize;
        trimmed(&format!("{value:.decimals$}")).into()
    } else {
        format!("{}e{exponent}", trimmed(mantissa))
    }
}

fn trimmed(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// A duration, which only has to be read, with four significant digits.
pub(super) fn duration(value: f64) -> String {
    spelled(value, FEW_DIGITS)
}

/// A share as a percentage; a small one keeps its digits.
pub(crate) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if share == 0.0 || share >= 1e-4 { format!("{percent:.2} %") } else { format!("{percent:.1e} %") }
}

/// `1 state`, `4 states`.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A count in groups of three: `80 640`.
pub(crate) fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (at, digit) in digits.chars().enumerate() {
        if at > 0 && (digits.len() - at).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// 1st, 2nd, 3rd, 4th.
pub(crate) fn ordinal(number: usize) -> String {
    let ending = match (number % 100, number % 10) {
        (11..=13, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_digits_count_and_zeros_at_the_end_do_not() {
        for (value, text) in [
            (1.6875, "1.6875"),
            (0.02, "0.02"),
            (0.0, "0"),
            (1.0, "1"),
            (-3.123_456_7, "-3.12346"),
            (123_456.7, "123457"),
            (1_234_567.0, "1.23457e6"),
            (3.046_174e-6, "3.04617e-6"),
            (100.0, "100"),
            (f64::INFINITY, "unbounded"),
        ] {
            assert_eq!(figure(value), text);
        }
    }

    #[test]
    fn a_rate_that_is_not_one_does_not_read_one() {
        assert_eq!(figure(0.999_999_98), "0.99999998");
        assert_eq!(figure(1.000_000_03), "1.00000003");
    }

    #[test]
    fn long_counts_are_grouped() {
        assert_eq!([610, 80_640, 1_234_567].map(grouped), ["610", "80 640", "1 234 567"]);
    }

    #[test]
    fn a_small_share_is_not_rounded_to_none() {
        assert_eq!([0.0, 0.25, 3e-10].map(percent), ["0.00 %", "25.00 %", "3.0e-8 %"]);
    }
}
