//! [`Lengths`]: sequence lengths as the command line writes them. What becomes of them is in [`crate::sweep`].

use crate::design::LONGEST_SEQUENCE;
use std::str::FromStr;

/// Sequence lengths, ascending and distinct, each from 1 to 128; never empty.
///
/// Written as one length `4`, a range `1..=12` or `1..13` (without its end, as in Rust), or several of these with
/// commas: `1,2,4..=8`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lengths(Vec<usize>);

/// A text that names no lengths.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "found `{found}`; give lengths from 1 to {LONGEST_SEQUENCE}: one as 4, a range as 1..=12 or 1..13, several as \
     1,2,4..=8"
)]
pub struct LengthsError {
    /// The part that is neither a length nor a range that holds one.
    pub found: String,
}

impl Lengths {
    /// The lengths, ascending.
    pub fn as_slice(&self) -> &[usize] {
        &self.0
    }
}

impl FromStr for Lengths {
    type Err = LengthsError;

    fn from_str(text: &str) -> Result<Self, LengthsError> {
        let mut lengths = Vec::new();
        for part in text.split(',') {
            let named = range(part.trim()).ok_or_else(|| LengthsError { found: part.trim().into() })?;
            lengths.extend(named);
        }
        lengths.sort_unstable();
        lengths.dedup();
        Ok(Self(lengths))
    }
}

/// The lengths that one part between commas names; `None` if there are none, or one of them is no length.
fn range(part: &str) -> Option<std::ops::RangeInclusive<usize>> {
    let number = |text: &str| text.parse::<usize>().ok();
    let (first, last) = if let Some((first, last)) = part.split_once("..=") {
        (number(first)?, number(last)?)
    } else if let Some((first, end)) = part.split_once("..") {
        (number(first)?, number(end)?.checked_sub(1)?)
    } else {
        let length = number(part)?;
        (length, length)
    };
    (1 <= first && first <= last && last <= LONGEST_SEQUENCE).then_some(first..=last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_single_lengths_and_lists_are_read() {
        for (text, expected) in [
            ("4", &[4][..]),
            ("1..=3", &[1, 2, 3]),
            ("1..3", &[1, 2]),
            ("8, 1,2 ,4", &[1, 2, 4, 8]),
            ("2..=4,1,3", &[1, 2, 3, 4]),
            ("128", &[128]),
        ] {
            assert_eq!(text.parse::<Lengths>().unwrap().as_slice(), expected, "{text}");
        }
    }

    #[test]
    fn what_names_no_length_is_named_with_what_is_allowed() {
        for (text, part) in [
            ("", ""),
            ("0", "0"),
            ("129", "129"),
            ("1..1", "1..1"),
            ("5..=3", "5..=3"),
            ("1,x,3", "x"),
            ("1..=1000000000000", "1..=1000000000000"),
            ("1..", "1.."),
            ("-1", "-1"),
        ] {
            let error = text.parse::<Lengths>().unwrap_err();
            assert_eq!(error.found, part, "{text}");
            assert!(error.to_string().contains("give lengths from 1 to 128: one as 4, a range as 1..=12"));
        }
    }
}
