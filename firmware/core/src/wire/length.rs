//! Where a frame ends, for carriers that hand over more bytes than were sent.
//!
//! What the bytes are worth is not judged here: whoever decodes the frame checks all of it.

use super::{Kind, MOST_AGES, RawFrame, acknowledgement_len, control_len, measurement_len};

/// Bytes of the frame that `bytes` begins with. `None` if that is not told: the header is not one of this version, or less is
/// there than it announces.
///
/// Measurements and control frames count their values; what follows them is not looked at. An acknowledgement does not, so
/// that its checksum tells: it ends where that fits and only zeros follow. Zeros behind it, however many, give it no second
/// such place.
pub fn frame_len(bytes: &[u8]) -> Option<usize> {
    let raw = RawFrame::of(bytes)?;
    let scalar_bytes = raw.scalar_bytes();
    if !raw.is_of_this_version() || !matches!(scalar_bytes, 4 | 8) {
        return None;
    }
    let count = |at: usize| raw.payload().get(at).copied().map(usize::from);
    let len = match raw.kind()? {
        Kind::Measurement => measurement_len(count(0)?, scalar_bytes),
        Kind::Control => control_len(count(0)?, count(1)?, scalar_bytes),
        Kind::Acknowledgement => {
            (1..=MOST_AGES).map(acknowledgement_len).find(|&len| is_padded(bytes, len))?
        }
        _ => return None,
    };
    (len <= bytes.len()).then_some(len)
}

/// Whether the first `len` bytes fit their checksum and only zeros follow.
fn is_padded(bytes: &[u8], len: usize) -> bool {
    bytes
        .split_at_checked(len)
        .and_then(|(frame, rest)| Some((RawFrame::of(frame)?, rest)))
        .is_some_and(|(frame, rest)| frame.is_whole() && rest.iter().all(|&byte| byte == 0))
}
