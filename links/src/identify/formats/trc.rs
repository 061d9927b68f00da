//! PEAK TRC, versions 1.0 to 2.1: milliseconds since the start, in columns that the version or `$COLUMNS` tells.

use super::{
    super::{
        about::Skip,
        collector::Collector,
        time::{self, Nanoseconds},
    },
    Lines,
    message::{Direction, Message, Stream},
    words::{MOST, Words, can_id, decimal, direction, hex, quoted, spread},
};

const MILLISECOND: i64 = 1_000_000;
/// Columns of version 2.0 where the header does not tell.
const DEFAULT: &[u8] = b"NOTIdlD";

/// Lines of a log.
pub(in super::super) struct Trc {
    /// Letters of the columns, as `$COLUMNS` has them; versions below 2 have letters of this reader.
    columns: Vec<u8>,
    data: [u8; MOST],
}

impl Trc {
    pub(in super::super) fn new() -> Self {
        // Version 1.0 does not say that it is: number, time, identifier, length, data.
        Self { columns: b"NOIlD".to_vec(), data: [0; MOST] }
    }

    fn header(&mut self, text: &[u8]) -> Result<(), String> {
        let text = text.trim_ascii();
        if let Some(version) = text.strip_prefix(b";$FILEVERSION=") {
            let columns: &[u8] = match version {
                b"1.0" => b"NOIlD",
                b"1.1" => b"NOTIlD",
                b"1.2" => b"NOBTIlD",
                b"1.3" => b"NOBTIRlD",
                [b'2', ..] => DEFAULT,
                _ => return Err(format!("found {}; give PEAK TRC 1.0 to 2.1", quoted(text))),
            };
            self.columns = columns.to_vec();
        } else if let Some(columns) = text.strip_prefix(b";$COLUMNS=") {
            self.columns = columns.iter().copied().filter(u8::is_ascii_alphabetic).collect();
        }
        Ok(())
    }
}

impl Lines for Trc {
    fn line(&mut self, text: &[u8], collector: &mut Collector<'_>) -> Result<(), String> {
        if text.trim_ascii_start().starts_with(b";") {
            return self.header(text);
        }
        match frame(Words(text), &self.columns, &mut self.data) {
            Some(Ok(message)) => collector.message(&message),
            Some(Err(skip)) => collector.skip(skip),
            None => {
                return Err(format!(
                    "found {}; give lines of PEAK TRC with the columns of their header",
                    quoted(text)
                ));
            }
        }
        Ok(())
    }
}

fn frame<'a>(
    mut words: Words<'a>,
    columns: &[u8],
    data: &'a mut [u8; MOST],
) -> Option<Result<Message<'a>, Skip>> {
    let (mut time, mut interface, mut towards, mut id, mut count): (Option<Nanoseconds>, &[u8], _, _, _) =
        (None, b"", None, None, None);
    for column in columns {
        match column {
            b'D' => break,
            b'O' => time = Some(time::scaled(words.next()?, MILLISECOND)?),
            b'B' => interface = words.next()?,
            b'd' => towards = direction(words.next()?),
            b'T' => match words.next()? {
                b"DT" | b"FD" | b"FB" | b"FE" | b"BI" => {}
                word @ (b"Rx" | b"Tx") => towards = direction(word),
                b"RR" => return Some(Err(Skip::Remote)),
                b"ER" | b"Error" | b"Warng" => return Some(Err(Skip::Error)),
                _ => return Some(Err(Skip::Comment)),
            },
            b'I' => {
                let word = words.next()?;
                // Four digits are 11 bits, eight are 29; events without an identifier have a line in place of it.
                let Some(number) = hex(word) else { return Some(Err(Skip::Comment)) };
                id = Some(can_id(number, word.len() > 4));
            }
            b'l' => count = Some(decimal(words.next()?)? as usize),
            b'L' => count = Some(length(decimal(words.next()?)?)?),
            _ => {
                words.next()?;
            }
        }
    }
    if words.clone().next() == Some(b"RTR".as_slice()) {
        return Some(Err(Skip::Remote));
    }
    let (id, count) = (id?, count?);
    // Version 1.0 has error frames as an identifier of ones.
    if id.is_extended && count > 8 && columns == b"NOIlD" {
        return Some(Err(Skip::Error));
    }
    spread(&mut words, count, 16, data)?;
    let direction: Option<Direction> = towards;
    Some(Ok(Message { time: time?, interface, direction, stream: Stream::Can(id), data: &data[..count] }))
}

/// Bytes for a data length code.
fn length(code: u32) -> Option<usize> {
    const LONGER: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];
    match code {
        0..=8 => Some(code as usize),
        9..=15 => Some(LONGER[code as usize - 9]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_version_is_read() {
        for (columns, text) in [
            ("NOIlD", "     1)      1059.9         0300  2  00 A0"),
            ("NOTIlD", "     1)      1059.9  Rx         0300  2  00 A0"),
            ("NOBTIlD", "     1)      1059.900 1  Rx         0300  2  00 A0"),
            ("NOBTIRlD", "     1)      1059.900 1  Rx        0300 -  2    00 A0"),
            ("NOTIdlD", "      1      1059.900 DT     0300 Rx 2  00 A0"),
            ("NOTBIdRLD", "      1      1059.900 DT 1      0300 Rx -  2    00 A0"),
        ] {
            let mut data = [0; MOST];
            let message =
                frame(Words(text.as_bytes()), columns.as_bytes(), &mut data).expect(text).expect(text);
            assert_eq!((message.time, message.data), (1_059_900_000, [0, 0xa0].as_slice()), "{text}");
            assert_eq!(message.stream.to_string(), "identifier 300", "{text}");
        }
    }

    #[test]
    fn remote_and_error_frames_are_skipped() {
        for (text, skip) in [
            ("      1      1059.900 RR     0300 Rx 2", Skip::Remote),
            ("      1      1059.900 ER            Rx 5  00 00 00 00 00", Skip::Error),
            ("      1      1059.900 ST            Rx    00 00 00 08", Skip::Comment),
        ] {
            let mut data = [0; MOST];
            assert_eq!(
                frame(Words(text.as_bytes()), DEFAULT, &mut data).expect(text).err(),
                Some(skip),
                "{text}"
            );
        }
        assert_eq!((length(13), length(16)), (Some(32), None));
    }
}
