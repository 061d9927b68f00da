//! The bytes of the handshake.

use super::{Association, HELLO, Side, TAG_LEN, mac::Mac};

/// Bytes of a hello.
pub const HELLO_LEN: usize = CONTENT_LEN + TAG_LEN;
const CONTENT_LEN: usize = 19;
const HAS_SESSION: u8 = 2;

/// What an end says of itself. Both nonces in one hello prove that its sender has heard the other end's, and is alive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Hello {
    pub(super) association: Association,
    pub(super) sender: Side,
    /// Whether the sender holds the session of these nonces for agreed, and needs no answer.
    pub(super) has_session: bool,
    /// The sender's nonce.
    pub(super) own: u64,
    /// The nonce it has heard; zero if none.
    pub(super) echo: u64,
}

impl Hello {
    pub(super) fn write(&self, mac: &Mac) -> [u8; HELLO_LEN] {
        let mut bytes = [0; HELLO_LEN];
        let (content, tag) = bytes.split_at_mut(CONTENT_LEN);
        content[0] = HELLO;
        content[1] = self.association as u8;
        content[2] = self.sender as u8 | if self.has_session { HAS_SESSION } else { 0 };
        content[3..11].copy_from_slice(&self.own.to_le_bytes());
        content[11..].copy_from_slice(&self.echo.to_le_bytes());
        tag.copy_from_slice(&mac.tag(content));
        bytes
    }

    /// Reads a hello that `sender` has sent; `None` if it is none, or its tag does not fit.
    pub(super) fn read(
        bytes: &[u8; HELLO_LEN],
        association: Association,
        sender: Side,
        mac: &Mac,
    ) -> Option<Self> {
        let (content, tag) = bytes.split_last_chunk::<TAG_LEN>()?;
        if !mac.fits(content, tag) {
            return None;
        }
        let [_, number, flags, nonces @ ..] = bytes;
        let (own, rest) = nonces.split_first_chunk()?;
        let (echo, _) = rest.split_first_chunk()?;
        let is_from_sender = *number == association as u8 && flags & !HAS_SESSION == sender as u8;
        is_from_sender.then_some(Self {
            association,
            sender,
            has_session: flags & HAS_SESSION != 0,
            own: u64::from_le_bytes(*own),
            echo: u64::from_le_bytes(*echo),
        })
    }

    /// Which association bytes say they are a hello of.
    pub(super) fn association_of(bytes: &[u8]) -> Option<u8> {
        bytes.get(1).copied()
    }
}
