//! Counters in payloads: where they are, how wide, and how they go on when they wrap.
//!
//! | room | what lives there |
//! |---|---|
//! | [`Counter`] | a place in a payload, and how its number is written |
//! | `find` | the counter that a log shows by itself |
//! | `rounds` | numbers that wrap become numbers that do not |

pub(super) mod find;
pub(super) mod rounds;

use std::{fmt, str::FromStr};

/// How a number is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Shape {
    /// The lower four bits of a byte.
    LowNibble,
    /// The upper four bits of a byte.
    HighNibble,
    /// One byte.
    U8,
    /// Two bytes, the lower one first.
    U16Le,
    /// Two bytes, the higher one first.
    U16Be,
    /// Four bytes, the lowest one first.
    U32Le,
    /// Four bytes, the highest one first.
    U32Be,
}

impl Shape {
    pub(super) const ALL: [Self; 7] =
        [Self::U32Le, Self::U32Be, Self::U16Le, Self::U16Be, Self::U8, Self::LowNibble, Self::HighNibble];

    fn name(self) -> &'static str {
        match self {
            Self::LowNibble => "nibble",
            Self::HighNibble => "high-nibble",
            Self::U8 => "u8",
            Self::U16Le => "u16le",
            Self::U16Be => "u16be",
            Self::U32Le => "u32le",
            Self::U32Be => "u32be",
        }
    }

    /// How many numbers there are before it begins anew.
    pub(super) fn modulus(self) -> u64 {
        match self {
            Self::LowNibble | Self::HighNibble => 16,
            Self::U8 => 1 << 8,
            Self::U16Le | Self::U16Be => 1 << 16,
            Self::U32Le | Self::U32Be => 1 << 32,
        }
    }

    fn read(self, payload: &[u8], byte: usize) -> Option<u32> {
        let rest = payload.get(byte..)?;
        Some(match self {
            Self::LowNibble => u32::from(*rest.first()? & 15),
            Self::HighNibble => u32::from(*rest.first()? >> 4),
            Self::U8 => u32::from(*rest.first()?),
            Self::U16Le => u32::from(u16::from_le_bytes(*rest.first_chunk()?)),
            Self::U16Be => u32::from(u16::from_be_bytes(*rest.first_chunk()?)),
            Self::U32Le => u32::from_le_bytes(*rest.first_chunk()?),
            Self::U32Be => u32::from_be_bytes(*rest.first_chunk()?),
        })
    }
}

/// A counter in a payload. It goes up by one with each packet, from `first` over `modulus` numbers, and begins anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Counter {
    /// How it is written.
    pub shape: Shape,
    /// Its first byte, from 0.
    pub byte: usize,
    /// The smallest number.
    pub first: u32,
    /// How many numbers there are: those of E2E profile 1 have four bits and stop at 14.
    pub modulus: u64,
}

impl Counter {
    /// One that uses all numbers of its shape.
    pub fn new(shape: Shape, byte: usize) -> Self {
        Self { shape, byte, first: 0, modulus: shape.modulus() }
    }

    /// The number in a payload, from 0.
    pub(super) fn read(&self, payload: &[u8]) -> Option<u32> {
        self.shape.read(payload, self.byte)?.checked_sub(self.first)
    }
}

/// How counters are given, as for `--counter`.
pub const FORM: &str = "give a shape and the byte it begins at: u8@7, u16le@0, u16be@2, u32le@0, u32be@4, nibble@6 (lower four \
                        bits) or high-nibble@6";

impl FromStr for Counter {
    type Err = &'static str;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (shape, byte) = text.split_once('@').ok_or(FORM)?;
        let shape = Shape::ALL.into_iter().find(|known| known.name() == shape).ok_or(FORM)?;
        let byte = byte.parse().ok().filter(|byte| *byte < 64).ok_or(FORM)?;
        Ok(Self::new(shape, byte))
    }
}

impl fmt::Display for Counter {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}@{}", self.shape.name(), self.byte)?;
        match self.modulus == self.shape.modulus() {
            true => Ok(()),
            false => write!(out, " ({} .. {})", self.first, u64::from(self.first) + self.modulus - 1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_are_written_as_they_are_given() {
        for (text, payload, number) in [
            ("u8@1", [0, 7, 0, 0, 0, 0, 0, 0], 7),
            ("nibble@1", [0, 0xa7, 0, 0, 0, 0, 0, 0], 7),
            ("high-nibble@1", [0, 0xa7, 0, 0, 0, 0, 0, 0], 10),
            ("u16le@2", [0, 0, 1, 2, 0, 0, 0, 0], 0x201),
            ("u16be@2", [0, 0, 1, 2, 0, 0, 0, 0], 0x102),
            ("u32le@4", [0, 0, 0, 0, 1, 0, 0, 2], 0x0200_0001),
            ("u32be@4", [0, 0, 0, 0, 1, 0, 0, 2], 0x0100_0002),
        ] {
            let counter: Counter = text.parse().expect(text);
            assert_eq!((counter.to_string().as_str(), counter.read(&payload)), (text, Some(number)));
        }
        for wrong in ["u8", "u24@0", "u8@64", "u8@-1", "@1"] {
            assert_eq!(wrong.parse::<Counter>(), Err(FORM), "{wrong}");
        }
        assert_eq!(Counter::new(Shape::U32Le, 5).read(&[0; 8]), None);
    }
}
