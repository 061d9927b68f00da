//! Logs that python-can writes as text: its printed messages, and its CSV.

use super::{
    super::{about::Skip, collector::Collector, time},
    Lines,
    message::{Message, Stream},
    words::{MOST, Words, can_id, decimal, direction, hex, quoted, spread},
};

/// First line of the CSV.
pub(in super::super) const CSV_HEADER: &[u8] = b"timestamp,arbitration_id,extended,remote,error,dlc,data";

/// `Timestamp: 1.5    ID:      123    S Rx    DL:  2    01 02     Channel: 0`
pub(in super::super) struct Printed {
    pub(in super::super) data: [u8; MOST],
}

impl Lines for Printed {
    fn line(&mut self, text: &[u8], collector: &mut Collector<'_>) -> Result<(), String> {
        match printed(text, &mut self.data) {
            Some(Ok(message)) => collector.message(&message),
            Some(Err(skip)) => collector.skip(skip),
            None => {
                return Err(format!(
                    "found {}; give messages as python-can prints them: Timestamp: 1.5 ID: 123 S Rx DL: 2 01 02 Channel: 0",
                    quoted(text)
                ));
            }
        }
        Ok(())
    }
}

fn printed<'a>(text: &'a [u8], data: &'a mut [u8; MOST]) -> Option<Result<Message<'a>, Skip>> {
    let mut words = Words(text);
    (words.next()? == b"Timestamp:").then_some(())?;
    let time = time::parse_bytes(words.next()?)?;
    (words.next()? == b"ID:").then_some(())?;
    let number = hex(words.next()?)?;
    let (mut is_extended, mut towards, mut skip) = (false, None, None);
    loop {
        match words.next()? {
            b"DL:" => break,
            b"X" => is_extended = true,
            b"E" => skip = Some(Skip::Error),
            b"R" => skip = skip.or(Some(Skip::Remote)),
            word => towards = direction(word).or(towards),
        }
    }
    let count = decimal(words.next()?)? as usize;
    if let Some(skip) = skip {
        return Some(Err(skip));
    }
    spread(&mut words, count, 16, data)?;
    // What can be printed of the data may stand between.
    let at = memchr::memmem::rfind(words.0, b"Channel:")?;
    let interface = Words(&words.0[at + 8..]).next()?;
    let stream = Stream::Can(can_id(number, is_extended));
    Some(Ok(Message { time, interface, direction: towards, stream, data: &data[..count] }))
}

/// The CSV: no channel, no direction; so each end has a file of its own.
pub(in super::super) struct Csv {
    pub(in super::super) data: [u8; MOST],
}

impl Lines for Csv {
    fn line(&mut self, text: &[u8], collector: &mut Collector<'_>) -> Result<(), String> {
        if text.starts_with(b"timestamp,") {
            return Ok(());
        }
        match row(text, &mut self.data) {
            Some(Ok(message)) => collector.message(&message),
            Some(Err(skip)) => collector.skip(skip),
            None => {
                return Err(format!(
                    "found {}; give rows of python-can's CSV, as 1700000000.5,0x123,0,0,0,2,AQI=",
                    quoted(text)
                ));
            }
        }
        Ok(())
    }
}

fn row<'a>(text: &'a [u8], data: &'a mut [u8; MOST]) -> Option<Result<Message<'a>, Skip>> {
    let mut cells = text.trim_ascii().split(|byte| *byte == b',');
    // A number of 64 bits in Python holds quarters of a microsecond.
    let time = time::to_microseconds(time::parse_bytes(cells.next()?)?);
    let number = hex(cells.next()?.strip_prefix(b"0x")?)?;
    let mut flag = || match cells.next()? {
        b"0" => Some(false),
        b"1" => Some(true),
        _ => None,
    };
    let (is_extended, is_remote, is_error) = (flag()?, flag()?, flag()?);
    decimal(cells.next()?)?;
    if is_error || is_remote {
        return Some(Err(if is_error { Skip::Error } else { Skip::Remote }));
    }
    let len = base64(cells.next()?, data)?;
    let stream = Stream::Can(can_id(number, is_extended));
    Some(Ok(Message { time, interface: b"", direction: None, stream, data: &data[..len] }))
}

/// Bytes in the alphabet of RFC 4648, section 4; how many they are.
fn base64(text: &[u8], data: &mut [u8; MOST]) -> Option<usize> {
    let text = text.strip_suffix(b"==").or_else(|| text.strip_suffix(b"=")).unwrap_or(text);
    let (mut bits, mut held, mut len) = (0_u32, 0, 0);
    for byte in text {
        let digit = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        (bits, held) = (bits << 6 | u32::from(digit), held + 6);
        if held >= 8 {
            held -= 8;
            *data.get_mut(len)? = (bits >> held) as u8;
            len += 1;
        }
    }
    Some(len)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_messages_are_read() {
        let mut data = [0; MOST];
        let text = b"Timestamp: 1700000000.500100    ID: 00000123    X Rx     F BS       DL:  2    41 42    'AB'     Channel: can1";
        let message = printed(text, &mut data).expect("a line").expect("a frame");
        assert_eq!((message.interface, message.data), (b"can1".as_slice(), b"AB".as_slice()));
        assert_eq!(message.stream.to_string(), "identifier 00000123");
        let text = b"Timestamp: 1.5    ID:      123    S Rx   R            DL:  8    Channel: 0";
        assert_eq!(printed(text, &mut data).expect("a line").err(), Some(Skip::Remote));
    }

    #[test]
    fn rows_are_read() {
        let mut data = [0; MOST];
        let message = row(b"1700000000.5000999,0x123,0,0,0,8,AQAAAAdVAAA=", &mut data)
            .expect("a row")
            .expect("a frame");
        assert_eq!(
            (message.time, message.data),
            (1_700_000_000_500_100_000, [1, 0, 0, 0, 7, 0x55, 0, 0].as_slice())
        );
        assert_eq!(row(b"1.5,0x123,0,0,1,0,", &mut data).expect("a row").err(), Some(Skip::Error));
        assert!(row(b"1.5,0x123,0,0,0,1,*", &mut data).is_none());
    }
}
