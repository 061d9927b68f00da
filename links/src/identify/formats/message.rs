//! [`Message`]: a CAN frame or the payload of a UDP packet, as a log shows it.

use super::super::time::Nanoseconds;
use std::fmt;

/// Identifier of a CAN frame: the same number with 11 and with 29 bits is two messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CanId {
    /// At most 11 bits, or 29 if `is_extended`.
    pub number: u32,
    /// Whether the identifier has 29 bits.
    pub is_extended: bool,
}

/// Largest identifier of 11 bits.
const STANDARD: u32 = 0x7ff;
const EXTENDED: u32 = 0x1fff_ffff;

impl CanId {
    /// The identifier with the least bits for a number.
    pub fn of(number: u32) -> Self {
        Self { number, is_extended: number > STANDARD }
    }

    /// Up to three hexadecimal digits are 11 bits, more are 29, as candump writes them: 123 and 00000123.
    ///
    /// # Errors
    /// No hexadecimal digits, or more than 29 bits.
    pub fn parse(text: &str) -> Result<Self, &'static str> {
        let digits = text.strip_prefix("0x").unwrap_or(text);
        let number = u32::from_str_radix(digits, 16).ok().filter(|number| *number <= EXTENDED);
        let number = number.ok_or("give a hexadecimal number, as 123 (11 bits) or 00000123 (29 bits)")?;
        Ok(Self { number, is_extended: digits.len() > 3 || number > STANDARD })
    }
}

impl fmt::Display for CanId {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.is_extended {
            true => write!(out, "{:08X}", self.number),
            false => write!(out, "{:03X}", self.number),
        }
    }
}

/// What belongs together in a log: one message on a bus, or one port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stream {
    /// CAN frames with an identifier.
    Can(CanId),
    /// UDP packets to a port.
    Udp(u16),
}

impl fmt::Display for Stream {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Can(id) => write!(out, "identifier {id}"),
            Self::Udp(port) => write!(out, "port {port}"),
        }
    }
}

/// Which way a logger says a frame went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// The logging computer sent it.
    Sent,
    /// The logging computer heard it.
    Heard,
}

/// One frame or packet.
#[derive(Debug, Clone, Copy)]
pub struct Message<'a> {
    /// Since whatever the log counts from.
    pub time: Nanoseconds,
    /// Name or number of the interface; empty where the log has none.
    pub interface: &'a [u8],
    /// Where the log tells.
    pub direction: Option<Direction>,
    /// What it belongs to.
    pub stream: Stream,
    /// Payload; its end may be missing.
    pub data: &'a [u8],
}
