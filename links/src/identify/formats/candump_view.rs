//! The view of candump: `(seconds)  interface  id  [length]  bytes`, with times of `-ta`, `-tA`, `-tz` or `-td`.

use super::{
    super::{
        about::Skip,
        collector::Collector,
        time::{self, Nanoseconds},
    },
    Lines,
    candump::{ERROR, dropped},
    message::{Message, Stream},
    words::{MOST, Words, can_id, decimal, direction, identifier, quoted, spread},
};

const WANTED: &str =
    "give the view of candump -ta, as (1436509052.249713)  can0  123   [2]  01 02, or lines of candump -L";

/// Lines of the view.
pub(in super::super) struct View {
    /// Times are differences to the line before (`-td`).
    is_delta: bool,
    now: Nanoseconds,
    data: [u8; MOST],
}

impl View {
    /// A reader for a log that begins with `head`.
    pub(in super::super) fn new(head: &[u8]) -> Self {
        Self { is_delta: has_differences(head), now: 0, data: [0; MOST] }
    }
}

/// Whether times count from the line before: then many are smaller than the one before.
fn has_differences(head: &[u8]) -> bool {
    let times: Vec<Nanoseconds> =
        head.split(|byte| *byte == b'\n').filter_map(|line| clock(line)).map(|(time, _)| time).collect();
    let back = times.windows(2).filter(|pair| pair[1] < pair[0]).count();
    10 * back > times.len()
}

/// Whether times begin at 0 (`-tz`, `-td`): those of two logs have no common origin.
pub(in super::super) fn begins_at_zero(head: &[u8]) -> bool {
    head.split(|byte| *byte == b'\n').find_map(clock).is_some_and(|(time, _)| time.abs() < 1_000_000_000)
}

/// The time of a line, and what follows it.
fn clock(line: &[u8]) -> Option<(Nanoseconds, &[u8])> {
    let rest = line.trim_ascii_start().strip_prefix(b"(")?;
    let end = memchr::memchr(b')', rest)?;
    let text = &rest[..end];
    let time = time::parse_bytes(text).or_else(|| time::date(std::str::from_utf8(text).ok()?))?;
    Some((time, &rest[end + 1..]))
}

impl Lines for View {
    fn line(&mut self, text: &[u8], collector: &mut Collector<'_>) -> Result<(), String> {
        if let Some(count) = dropped(text) {
            collector.dropped(count);
            return Ok(());
        }
        // candump -e explains an error frame in lines that begin with a tab.
        if text.starts_with(b"\t") {
            return Ok(());
        }
        let Some((time, rest)) = clock(text) else {
            return Err(format!("found {} without a time; {WANTED}", quoted(text)));
        };
        let before = if self.is_delta { self.now } else { 0 };
        self.now = time::after(before, time).ok_or("found a time beyond 146 years")?;
        match frame(self.now, rest, &mut self.data) {
            Some(Ok(message)) => collector.message(&message),
            Some(Err(skip)) => collector.skip(skip),
            None => return Err(format!("found {}; {WANTED}", quoted(text))),
        }
        Ok(())
    }
}

fn frame<'a>(
    time: Nanoseconds,
    text: &'a [u8],
    data: &'a mut [u8; MOST],
) -> Option<Result<Message<'a>, Skip>> {
    let mut words = Words(text);
    let interface = words.next()?;
    let mut word = words.next()?;
    // candump -x: RX or TX, and two flags.
    let towards = direction(word);
    if towards.is_some() {
        word = words.find(|word| word.len() >= 3)?;
    }
    let (number, is_extended) = identifier(word)?;
    let length = words.next()?.strip_prefix(b"[")?;
    let length = match length.strip_suffix(b"]") {
        Some(length) => length,
        // A blank may stand before the number.
        None => words.next()?.strip_suffix(b"]")?,
    };
    if is_extended && number & ERROR != 0 {
        return Some(Err(Skip::Error));
    }
    if length.len() > 2 {
        return Some(Err(Skip::Xl));
    }
    let count = decimal(length)? as usize;
    if words.clone().next() == Some(b"remote".as_slice()) {
        return Some(Err(Skip::Remote));
    }
    spread(&mut words, count, 16, data)?;
    let stream = Stream::Can(can_id(number, is_extended));
    Some(Ok(Message { time, interface, direction: towards, stream, data: &data[..count] }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_the_view_are_read_or_skipped_by_name() {
        let mut data = [0; MOST];
        let text = b"  can0  RX - -  123   [2]  01 A0   '..'";
        let message = frame(5, text, &mut data).expect("a line").expect("a frame");
        assert_eq!((message.data, message.interface), ([1, 0xa0].as_slice(), b"can0".as_slice()));
        for (text, skip) in [
            ("can0  123   [4]  remote request", Skip::Remote),
            ("can0  20000088   [8]  00 00 08 00 00 00 00 00   ERRORFRAME", Skip::Error),
            ("can0  123   [0064] 00 (00|01) ..", Skip::Xl),
        ] {
            assert_eq!(frame(5, text.as_bytes(), &mut data).expect("a line").err(), Some(skip), "{text}");
        }
        assert!(frame(5, b"can0  123  [12]  00 01", &mut data).is_none(), "bytes are missing");
    }

    #[test]
    fn differences_are_told_from_times() {
        assert!(has_differences(b" (000.000000) a\n (000.010000) a\n (000.002000) a\n (000.008000) a\n"));
        assert!(!has_differences(b" (000.000000) a\n (000.010000) a\n (000.012000) a\n (000.020000) a\n"));
        assert!(begins_at_zero(b" (000.000000) a\n") && !begins_at_zero(b" (2023-11-14 22:13:20.5) a\n"));
    }
}
