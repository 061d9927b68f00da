//! [`Frame`]: identifier, format and bytes of a data frame. Its bits on the bus are `bits` and `length`.

use super::id::Id;
use std::fmt;

/// Most bytes of a CAN FD frame.
pub const LARGEST_PAYLOAD: usize = 64;

/// Payloads a CAN FD frame can carry, in bytes; the index is its DLC.
pub const FD_SIZES: [usize; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64];

/// Frame format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// Classical CAN: up to 8 bytes.
    Classic,
    /// CAN FD: up to 64 bytes.
    Fd {
        /// Whether the part after the bit BRS is sent at the data bit rate.
        bit_rate_switch: bool,
    },
}

/// How often a node tries to send a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Attempts {
    /// Until it is delivered, which is the default of the standard.
    #[default]
    Unlimited,
    /// Until the first error; a lost arbitration is tried again.
    UntilError,
    /// Once: given up at an error or a lost arbitration, as the single-shot mode of most controllers does.
    Once,
}

/// A data frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    id: Id,
    format: Format,
    data: heapless::Vec<u8, LARGEST_PAYLOAD>,
    attempts: Attempts,
}

/// A payload that its format cannot carry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub struct PayloadError {
    /// Bytes found.
    pub bytes: usize,
    /// Of the frame.
    pub format: Format,
}

impl fmt::Display for PayloadError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = self.bytes;
        match self.format {
            Format::Classic => write!(out, "found {bytes} bytes in a classical frame: it carries 0 to 8"),
            Format::Fd { .. } => write!(
                out,
                "found {bytes} bytes in a CAN FD frame: it carries 0 to 8, 12, 16, 20, 24, 32, 48 or 64; pad the payload"
            ),
        }
    }
}

impl Format {
    /// Data length code of a payload.
    ///
    /// # Errors
    /// A payload the format cannot carry.
    pub fn dlc(self, bytes: usize) -> Result<u8, PayloadError> {
        let codes = match self {
            Format::Classic => &FD_SIZES[..=8],
            Format::Fd { .. } => &FD_SIZES[..],
        };
        let code = codes.iter().position(|&size| size == bytes);
        code.map(|code| code as u8).ok_or(PayloadError { bytes, format: self })
    }
}

impl Frame {
    /// A frame that is sent until it is delivered.
    ///
    /// # Errors
    /// A payload the format cannot carry; padding is the caller's.
    pub fn new(id: Id, format: Format, data: &[u8]) -> Result<Self, PayloadError> {
        format.dlc(data.len())?;
        let wrong = PayloadError { bytes: data.len(), format };
        let data = heapless::Vec::from_slice(data).map_err(|_| wrong)?;
        Ok(Frame { id, format, data, attempts: Attempts::default() })
    }

    /// The same frame, tried as often as `attempts` says.
    pub fn with_attempts(mut self, attempts: Attempts) -> Self {
        self.attempts = attempts;
        self
    }

    /// Identifier.
    pub fn id(&self) -> Id {
        self.id
    }

    /// Format.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Payload.
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// How often it is tried.
    pub fn attempts(&self) -> Attempts {
        self.attempts
    }

    /// Data length code.
    pub(super) fn dlc(&self) -> u8 {
        self.format.dlc(self.data.len()).unwrap_or_else(|_| unreachable!("checked at construction"))
    }
}
