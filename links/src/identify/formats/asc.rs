//! Vector ASC, as CANalyzer, python-can and log2asc write it: a header, then `time channel id Rx d length bytes`, CAN FD as
//! `time CANFD channel Rx id flags length bytes`.

use super::{
    super::{
        about::Skip,
        collector::Collector,
        time::{self, Nanoseconds},
    },
    Lines,
    message::{Message, Stream},
    words::{MOST, Words, can_id, decimal, direction, hex, quoted, spread},
};

/// Lines of a log.
pub(in super::super) struct Asc {
    /// Base of identifiers and bytes, 16 or 10.
    base: u32,
    is_relative: bool,
    now: Nanoseconds,
    data: [u8; MOST],
}

impl Asc {
    pub(in super::super) fn new() -> Self {
        Self { base: 16, is_relative: false, now: 0, data: [0; MOST] }
    }

    /// `base hex  timestamps absolute`
    fn header(&mut self, words: Words<'_>) {
        let mut before: &[u8] = b"";
        for word in words {
            match (before, word) {
                (b"base", base) => self.base = if base == b"dec" { 10 } else { 16 },
                (b"timestamps", times) => self.is_relative = times == b"relative",
                _ => {}
            }
            before = word;
        }
    }
}

impl Lines for Asc {
    fn line(&mut self, text: &[u8], collector: &mut Collector<'_>) -> Result<(), String> {
        let mut words = Words(text);
        let first = words.next().unwrap_or_default();
        let Some(time) = time::parse_bytes(first) else {
            match first {
                b"base" => self.header(Words(text)),
                _ if first.first().is_some_and(u8::is_ascii_digit) => {
                    return Err(format!(
                        "found {}; give times in seconds, as Vector ASC has them",
                        quoted(text)
                    ));
                }
                _ => {}
            }
            return Ok(());
        };
        let before = if self.is_relative { self.now } else { 0 };
        self.now = time::after(before, time).ok_or("found a time beyond 146 years")?;
        match frame(self.now, words, self.base, &mut self.data) {
            Some(Ok(message)) => collector.message(&message),
            Some(Err(skip)) => collector.skip(skip),
            None => {
                return Err(format!(
                    "found {}; give lines of Vector ASC, as 0.010000 1 123 Rx d 2 01 02",
                    quoted(text)
                ));
            }
        }
        Ok(())
    }
}

fn frame<'a>(
    time: Nanoseconds,
    mut words: Words<'a>,
    base: u32,
    data: &'a mut [u8; MOST],
) -> Option<Result<Message<'a>, Skip>> {
    let Some(channel) = words.next() else { return Some(Err(Skip::Comment)) };
    if channel == b"CANFD" {
        return flexible(time, words, base, data);
    }
    // Events of the logger and of other buses have words where a channel would be, or behind it.
    let is_channel = decimal(channel).is_some();
    let second = words.next().unwrap_or_default();
    if second.eq_ignore_ascii_case(b"ErrorFrame") {
        return Some(Err(Skip::Error));
    }
    let (Some((number, is_extended)), true) = (identifier(second, base), is_channel) else {
        return Some(Err(Skip::Comment));
    };
    let towards = words.next().and_then(direction);
    match (towards, words.next()) {
        (Some(_), Some(b"d")) => {}
        (Some(_), Some(b"r")) => return Some(Err(Skip::Remote)),
        _ => return Some(Err(Skip::Comment)),
    }
    let count = hex(words.next()?)? as usize;
    spread(&mut words, count.min(8), base, data)?;
    let stream = Stream::Can(can_id(number, is_extended));
    Some(Ok(Message { time, interface: channel, direction: towards, stream, data: &data[..count.min(8)] }))
}

/// `channel direction id [name] brs esi dlc length bytes`
fn flexible<'a>(
    time: Nanoseconds,
    mut words: Words<'a>,
    base: u32,
    data: &'a mut [u8; MOST],
) -> Option<Result<Message<'a>, Skip>> {
    let channel = words.next()?;
    let mut word = words.next()?;
    // Some loggers write the direction behind the identifier.
    let mut towards = direction(word);
    if towards.is_some() {
        word = words.next()?;
    }
    if word.eq_ignore_ascii_case(b"ErrorFrame") {
        return Some(Err(Skip::Error));
    }
    let (number, is_extended) = identifier(word, base)?;
    let mut flag = words.next()?;
    if towards.is_none() {
        towards = direction(flag);
        flag = words.next()?;
    }
    // A symbolic name may stand before the flag of the bit rate.
    if !matches!(flag, b"0" | b"1") {
        words.next()?;
    }
    let (_state, code, length) = (words.next()?, words.next()?, words.next()?);
    hex(code)?;
    let count = decimal(length)? as usize;
    if count == 0 {
        return Some(Err(Skip::Remote));
    }
    spread(&mut words, count, base, data)?;
    let stream = Stream::Can(can_id(number, is_extended));
    Some(Ok(Message { time, interface: channel, direction: towards, stream, data: &data[..count] }))
}

/// An identifier; `x` behind it says that it has 29 bits.
fn identifier(word: &[u8], base: u32) -> Option<(u32, bool)> {
    let (digits, is_extended) = match word.strip_suffix(b"x") {
        Some(digits) => (digits, true),
        None => (word, false),
    };
    let number = if base == 16 { hex(digits)? } else { decimal(digits)? };
    Some((number, is_extended))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, base: u32) -> Option<Result<(String, usize), Skip>> {
        let mut data = [0; MOST];
        let frame = frame(5, Words(text.as_bytes()), base, &mut data)?;
        Some(frame.map(|message| (format!("{} {:?}", message.stream, message.data), message.interface.len())))
    }

    #[test]
    fn classic_and_flexible_frames_are_read() {
        for (text, base, expected) in [
            ("1  123             Rx   d 2 01 A0", 16, "identifier 123 [1, 160]"),
            (
                "2  18FF0123x       Tx   d 1 0A  Length = 0 BitCount = 60 ID = 1x",
                16,
                "identifier 18FF0123 [10]",
            ),
            ("1  291             Rx   d 2 1 160", 10, "identifier 123 [1, 160]"),
            (
                "CANFD   1 Rx        123                                  1 0 9 12 00 01 02 03 04 05 06 07 08 09 0a 0b 130000 130 3000 0",
                16,
                "identifier 123 [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]",
            ),
            ("CANFD   1 Tx        123x  Torque  0 0 1 1 07", 16, "identifier 00000123 [7]"),
        ] {
            assert_eq!(read(text, base), Some(Ok((expected.to_string(), 1))), "{text}");
        }
    }

    #[test]
    fn events_are_skipped_by_name() {
        for (text, skip) in [
            ("1  ErrorFrame", Skip::Error),
            ("1  123             Rx   r", Skip::Remote),
            ("Start of measurement", Skip::Comment),
            ("1  Statistic: D 1 R 0 XD 0 XR 0 E 0 O 0 B 0.00%", Skip::Comment),
            ("CAN 1 Status:chip status error active", Skip::Comment),
        ] {
            assert_eq!(read(text, 16), Some(Err(skip)), "{text}");
        }
        assert_eq!(read("1  123  Rx d 2 01", 16), None, "a byte is missing");
    }
}
