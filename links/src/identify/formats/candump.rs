//! Logs of `candump -L` and `-l`, asc2log and python-can: `(seconds) interface id#data`, CAN FD as `id##` with one digit of flags
//! before the data.

use super::{
    super::{about::Skip, collector::Collector, time},
    Lines,
    message::{Direction, Message, Stream},
    words::{MOST, Words, can_id, decimal, identifier, packed, quoted},
};

/// Bit of SocketCAN's identifiers that says it is an error frame.
pub(super) const ERROR: u32 = 0x2000_0000;
const CLASSIC: usize = 8;
const WANTED: &str = "give lines of candump -L, as (1436509052.249713) can0 123#0102030405060708";

/// Lines of `candump -L`.
pub(in super::super) struct Candump {
    pub(in super::super) data: [u8; MOST],
}

impl Lines for Candump {
    fn line(&mut self, text: &[u8], collector: &mut Collector<'_>) -> Result<(), String> {
        if let Some(count) = dropped(text) {
            collector.dropped(count);
            return Ok(());
        }
        if text.starts_with(b"#") || text.starts_with(b";") {
            collector.skip(Skip::Comment);
            return Ok(());
        }
        match frame(text, &mut self.data) {
            Some(Ok(message)) => collector.message(&message),
            Some(Err(skip)) => collector.skip(skip),
            None => return Err(format!("found {}; {WANTED}", quoted(text))),
        }
        Ok(())
    }
}

/// Frames that candump says it missed: `DROPCOUNT: dropped 3 CAN frames on 'can1' socket (total drops 3)`.
pub(super) fn dropped(text: &[u8]) -> Option<u64> {
    let rest = text.trim_ascii_start().strip_prefix(b"DROPCOUNT:")?;
    let count = Words(rest).find_map(decimal).unwrap_or(1);
    Some(u64::from(count))
}

/// The frame of a line, or why it is none of the link.
fn frame<'a>(text: &'a [u8], data: &'a mut [u8; MOST]) -> Option<Result<Message<'a>, Skip>> {
    let rest = text.trim_ascii_start().strip_prefix(b"(")?;
    // Ten digits, a point and six are the usual time.
    let end = if rest.get(17) == Some(&b')') { 17 } else { memchr::memchr(b')', rest)? };
    let time = time::parse_bytes(&rest[..end])?;
    let (interface, rest) = word(rest[end + 1..].strip_prefix(b" ")?);
    let (frame, rest) = word(rest);
    let direction = match rest.trim_ascii() {
        [] => None,
        b"T" => Some(Direction::Sent),
        b"R" => Some(Direction::Heard),
        _ => return None,
    };
    let at = frame.iter().position(|byte| *byte == b'#')?;
    let (number, is_extended) = identifier(&frame[..at])?;
    let payload = &frame[at + 1..];
    if is_extended && number & ERROR != 0 {
        return Some(Err(Skip::Error));
    }
    if let Some(rest) = payload.strip_prefix(b"R") {
        let plain = rest.iter().all(|byte| byte.is_ascii_hexdigit() || *byte == b'_');
        return plain.then_some(Err(Skip::Remote));
    }
    let (digits, most) = match payload.strip_prefix(b"#") {
        // CAN XL: three times the sign.
        Some([b'#', ..]) => return Some(Err(Skip::Xl)),
        Some([flags, digits @ ..]) if flags.is_ascii_hexdigit() => (digits, MOST),
        Some(_) => return None,
        None => (payload, CLASSIC),
    };
    let len = match packed(digits, data) {
        Some(len) => len,
        // A classic frame may name its raw length after the data.
        None => packed(&digits[..digits.iter().rposition(|byte| *byte == b'_')?], data)?,
    };
    if len > most {
        return None;
    }
    let stream = Stream::Can(can_id(number, is_extended));
    Some(Ok(Message { time, interface, direction, stream, data: &data[..len] }))
}

/// The next word, and what is behind it.
fn word(text: &[u8]) -> (&[u8], &[u8]) {
    let text = text.trim_ascii_start();
    text.split_at(text.iter().position(|byte| matches!(byte, b' ' | b'\t')).unwrap_or(text.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classic_and_flexible_frames_are_read() {
        let mut data = [0; MOST];
        let classic =
            frame(b"(1436509052.249713) vcan0 123#0102a0FF", &mut data).expect("a frame").expect("classic");
        assert_eq!((classic.time, classic.interface), (1_436_509_052_249_713_000, b"vcan0".as_slice()));
        assert_eq!(
            (classic.stream, classic.data),
            (Stream::Can(can_id(0x123, false)), [1, 2, 0xa0, 0xff].as_slice())
        );
        let flexible = frame(b"(0.5) can1 18DAF110##1000102030405060708 R", &mut data);
        let flexible = flexible.expect("a frame").expect("CAN FD");
        assert_eq!((flexible.data.len(), flexible.direction), (9, Some(Direction::Heard)));
        assert_eq!(flexible.stream, Stream::Can(can_id(0x18da_f110, true)));
    }

    #[test]
    fn what_is_no_data_frame_is_skipped_by_name() {
        let mut data = [0; MOST];
        for (text, skip) in [
            ("(0.5) can1 123#R8", Skip::Remote),
            ("(0.5) can1 20000004#0004000000000000", Skip::Error),
            ("(0.5) can1 123###0500#aabb", Skip::Xl),
        ] {
            assert_eq!(frame(text.as_bytes(), &mut data).expect("a line").err(), Some(skip), "{text}");
        }
        let dropped = dropped(b"DROPCOUNT: dropped 3 CAN frames on 'can1' socket (total drops 3)");
        assert_eq!(dropped, Some(3));
    }

    #[test]
    fn other_lines_are_refused() {
        for wrong in [
            "vcan0  123   [4]  01 02 03 04",
            "(1.5) vcan0",
            "(1.5 vcan0 123#00",
            "(1.5) vcan0 xyz#00",
            "(1.5) vcan0 123#0",
            "(1.5) vcan0 123#0g",
            "(1.5) vcan0 123##",
            "(1.5) vcan0 123#000102030405060708",
            "(1.5) vcan0 123#00 T x",
            "(1.5) vcan0 123#é",
        ] {
            assert!(frame(wrong.as_bytes(), &mut [0; MOST]).is_none(), "{wrong}");
        }
    }
}
