//! [`Source`]: the bytes of a log from its beginning, unpacked, and its lines.

use flate2::read::MultiGzDecoder;
use ruzstd::decoding::StreamingDecoder;
use std::io::{self, Cursor, ErrorKind, Read};

const GZIP: [u8; 3] = [0x1f, 0x8b, 8];
const ZSTANDARD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];
/// Bytes by which a format is recognised.
const HEAD: usize = 1 << 16;
const BLOCK: usize = 1 << 18;
/// A line that is longer is none of a log.
const LONGEST_LINE: usize = 1 << 20;

/// The bytes of a log.
pub(super) struct Source<'r> {
    input: Box<dyn Read + 'r>,
    /// What was read and not yet taken is from `from` to `to`; what is behind it is room.
    buffer: Vec<u8>,
    from: usize,
    to: usize,
    is_read: bool,
    lines: u64,
}

/// A line, without its end.
pub(super) struct Line<'s> {
    /// Counted from 1.
    pub(super) number: u64,
    pub(super) text: &'s [u8],
    /// Whether the line has an end: the last one of a log may be cut off.
    pub(super) is_whole: bool,
}

impl<'r> Source<'r> {
    /// Begins to read; gzip and zstd are unpacked.
    pub(super) fn new(input: impl Read + 'r) -> io::Result<Self> {
        let mut source = Self::of(Box::new(input))?;
        if source.head().starts_with(&GZIP) {
            source = Self::of(Box::new(MultiGzDecoder::new(source.into_read())))?;
        } else if source.head().starts_with(&ZSTANDARD) {
            let decoder = StreamingDecoder::new(source.into_read()).map_err(io::Error::other)?;
            source = Self::of(Box::new(decoder))?;
        }
        Ok(source)
    }

    fn of(input: Box<dyn Read + 'r>) -> io::Result<Self> {
        let mut source = Self { input, buffer: vec![0; BLOCK], from: 0, to: 0, is_read: false, lines: 0 };
        while source.to < HEAD && !source.is_read {
            source.fill()?;
        }
        Ok(source)
    }

    /// How the log begins.
    pub(super) fn head(&self) -> &[u8] {
        &self.buffer[self.from..self.to]
    }

    /// All that has not been read yet.
    pub(super) fn into_read(mut self) -> impl Read + 'r {
        self.buffer.truncate(self.to);
        let mut head = Cursor::new(self.buffer);
        head.set_position(self.from as u64);
        head.chain(self.input)
    }

    /// The rest as a whole.
    pub(super) fn rest(self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.into_read().read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// The next line.
    pub(super) fn line(&mut self) -> io::Result<Option<Line<'_>>> {
        let mut searched = 0;
        let end = loop {
            if let Some(at) = memchr::memchr(b'\n', &self.buffer[self.from + searched..self.to]) {
                break Some(self.from + searched + at);
            }
            searched = self.to - self.from;
            if self.is_read {
                break None;
            }
            if searched > LONGEST_LINE {
                return Err(io::Error::new(ErrorKind::InvalidData, "a line of more than a million bytes"));
            }
            self.fill()?;
        };
        let (from, to) = (self.from, end.unwrap_or(self.to));
        if end.is_none() && from == to {
            return Ok(None);
        }
        self.from = end.map_or(to, |end| end + 1);
        self.lines += 1;
        let text = &self.buffer[from..to];
        let text = text.strip_suffix(b"\r").unwrap_or(text);
        Ok(Some(Line { number: self.lines, text, is_whole: end.is_some() }))
    }

    /// Reads more behind what is left.
    fn fill(&mut self) -> io::Result<()> {
        self.buffer.copy_within(self.from..self.to, 0);
        (self.from, self.to) = (0, self.to - self.from);
        if self.to == self.buffer.len() {
            self.buffer.resize(2 * self.to, 0);
        }
        let read = loop {
            match self.input.read(&mut self.buffer[self.to..]) {
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                other => break other?,
            }
        };
        self.to += read;
        self.is_read = read == 0;
        Ok(())
    }
}
