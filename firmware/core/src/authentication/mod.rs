//! `authentication`: frames that only holders of a key can make, each taken once.
//!
//! A sealed frame is a plain one with a tag before it: AES-128-CMAC (RFC 4493, NIST SP 800-38B), cut to eight bytes, under a
//! key that is derived for one session, direction, loop and plant. `docs/wire-format.md` has the bytes, `docs/safety.md` what
//! an attacker is kept from and what not.
//!
//! | file | what lives there |
//! |---|---|
//! | `key` | a key, which nothing prints |
//! | `mac` | tags, and keys that are derived from keys |
//! | `cipher` | AES-128 as the tags take it |
//! | `association` | who speaks with whom, and which kinds of frame |
//! | `hello` | the bytes of the handshake |
//! | `freshness` | a frame is taken once |
//! | `session` | the handshake between two ends, sealing and opening |
//! | `failures` | what was refused, and when that is an alarm |
//! | `guard` | all sessions of an end |
//! | `guarded` | a controller or an actuator behind its guard |
//!
//! Nothing of a control law is here, and a plain frame is opened before anybody decodes it: [`crate::controller`] and
//! [`crate::actuator`] are those of any loop. What costs time is bounded for each frame, whatever its bytes are.

mod association;
mod cipher;
mod failures;
mod freshness;
mod guard;
mod guarded;
mod hello;
mod key;
mod mac;
mod session;

pub use association::{Association, Identity, Keys, Side};
pub use failures::{Alarm, AlarmSettings, Failures};
pub use guard::{Guard, Opened, sealed_len};
pub use guarded::{Guarded, NotTaken};
pub use hello::HELLO_LEN;
pub use key::Key;
pub use session::{Nonces, Session};

/// First byte of a sealed frame.
pub const SEALED: u8 = 0xa1;
/// First byte of a hello, the frame of the handshake.
pub const HELLO: u8 = 0xa2;
/// Bytes of a tag.
pub const TAG_LEN: usize = 8;
/// Bytes that a sealed frame has before the plain one.
pub const HEAD_LEN: usize = 1 + TAG_LEN;

/// Why bytes were not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refused {
    /// They are neither a sealed frame nor a hello.
    Form,
    /// The plain frame's checksum does not fit: damaged on the way.
    Damaged,
    /// A kind of frame that this end does not take.
    Kind,
    /// There is no session that it could be of.
    NoSession,
    /// The tag does not fit: it was made without the key, for another loop, plant, direction or session, or was changed.
    Forged,
    /// It was taken before, or is too old to tell.
    Repeated,
    /// Gains of this version or of a later one are in force.
    Version,
}

impl core::fmt::Display for Refused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Form => "neither a sealed frame nor a hello",
            Self::Damaged => "checksum does not fit",
            Self::Kind => "a kind of frame that this end does not take",
            Self::NoSession => "no session with who may send this",
            Self::Forged => {
                "the tag does not fit: another key, loop, plant, direction or session, or changed on the way"
            }
            Self::Repeated => "a frame that was taken before, or is too old to tell",
            Self::Version => "gains that are not newer than the newest there were",
        })
    }
}

impl core::error::Error for Refused {}

/// Why a frame is not sealed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NotSealed {
    /// A kind of frame that this end does not send sealed.
    Kind,
    /// There is no session yet, or it has ended.
    NoSession,
    /// A frame of this cycle or of a later one was sealed before: cycles are counted anew, and a session must be, too.
    Repeated,
    /// The buffer is shorter than the sealed frame.
    BufferTooSmall,
}

impl core::fmt::Display for NotSealed {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Kind => "a kind of frame that this end does not seal",
            Self::NoSession => "no session with who is to receive it",
            Self::Repeated => "a frame of this cycle or a later one was sealed before",
            Self::BufferTooSmall => "the buffer is shorter than the sealed frame",
        })
    }
}

impl core::error::Error for NotSealed {}
