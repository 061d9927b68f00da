//! Words, numbers and data in the lines of a log.

use super::message::{CanId, Direction};

/// Most bytes of a CAN FD frame.
pub(super) const MOST: usize = 64;

/// Words of a line between blanks and tabs.
#[derive(Clone)]
pub(super) struct Words<'a>(pub(super) &'a [u8]);

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let mut rest = self.0;
        while let [b' ' | b'\t', after @ ..] = rest {
            rest = after;
        }
        let begin = rest;
        while let [byte, after @ ..] = rest
            && !matches!(byte, b' ' | b'\t')
        {
            rest = after;
        }
        self.0 = rest;
        let word = &begin[..begin.len() - rest.len()];
        (!word.is_empty()).then_some(word)
    }
}

/// Values of hexadecimal digits; above 15: none.
const NIBBLES: [u8; 256] = {
    let mut values = [u8::MAX; 256];
    let mut digit = 0;
    while digit < 16 {
        values[b"0123456789abcdef"[digit] as usize] = digit as u8;
        values[b"0123456789ABCDEF"[digit] as usize] = digit as u8;
        digit += 1;
    }
    values
};

fn nibble(digit: u8) -> u8 {
    NIBBLES[usize::from(digit)]
}

/// A hexadecimal number of at most 32 bits.
pub(super) fn hex(digits: &[u8]) -> Option<u32> {
    if digits.is_empty() || digits.len() > 8 {
        return None;
    }
    digits.iter().try_fold(0, |number, &digit| {
        let digit = nibble(digit);
        (digit < 16).then_some(number << 4 | u32::from(digit))
    })
}

/// A decimal number.
pub(super) fn decimal(digits: &[u8]) -> Option<u32> {
    if digits.is_empty() || digits.len() > 9 {
        return None;
    }
    digits
        .iter()
        .try_fold(0, |number, digit| digit.is_ascii_digit().then(|| number * 10 + u32::from(digit - b'0')))
}

/// Bytes written one after the other, into `data`; how many they are.
pub(super) fn packed(digits: &[u8], data: &mut [u8; MOST]) -> Option<usize> {
    if digits.len() > 2 * MOST {
        return None;
    }
    let pairs = digits.chunks_exact(2);
    if !pairs.remainder().is_empty() {
        return None;
    }
    for (pair, byte) in pairs.zip(data.iter_mut()) {
        let (high, low) = (nibble(pair[0]), nibble(pair[1]));
        if high | low > 15 {
            return None;
        }
        *byte = high << 4 | low;
    }
    Some(digits.len() / 2)
}

/// `count` bytes as words, in a base of 16 or 10.
pub(super) fn spread(words: &mut Words<'_>, count: usize, base: u32, data: &mut [u8; MOST]) -> Option<()> {
    for byte in data.get_mut(..count)? {
        let word = words.next()?;
        let number = if base == 16 { hex(word) } else { decimal(word) };
        *byte = u8::try_from(number?).ok()?;
    }
    Some(())
}

/// An identifier of candump: three digits, or eight if it has 29 bits.
pub(super) fn identifier(digits: &[u8]) -> Option<(u32, bool)> {
    Some((hex(digits)?, digits.len() > 3))
}

/// The identifier in SocketCAN's 32 bits without their flags.
pub(super) fn can_id(number: u32, is_extended: bool) -> CanId {
    CanId { number: number & 0x1fff_ffff, is_extended }
}

/// `Tx` or `Rx`, in any case.
pub(super) fn direction(word: &[u8]) -> Option<Direction> {
    match word.to_ascii_lowercase().as_slice() {
        b"tx" => Some(Direction::Sent),
        b"rx" => Some(Direction::Heard),
        _ => None,
    }
}

/// A line for a message, not too long.
pub(super) fn quoted(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text);
    let short: String = text.trim().chars().take(80).collect();
    format!("\"{}\"", short.escape_debug())
}
