//! The CAN FD form: a full frame, padded with zeros.
//!
//! CAN FD has no frames of 9 to 11 bytes, say. The receiver finds the end of what was sent by [`frame_len`]. Frames of CAN
//! drivers are not known here: for CAN FD they have no common type.

use crate::wire::frame_len;

/// Most bytes in one CAN FD frame.
pub const FD_CAPACITY: usize = 64;

/// The shortest data length of CAN FD that holds `len` bytes: 0 to 8, 12, 16, 20, 24, 32, 48 or 64. `None` beyond 64.
pub const fn fd_len(len: usize) -> Option<usize> {
    Some(match len {
        0..=8 => len,
        9..=12 => 12,
        13..=16 => 16,
        17..=20 => 20,
        21..=24 => 24,
        25..=32 => 32,
        33..=48 => 48,
        49..=FD_CAPACITY => FD_CAPACITY,
        _ => return None,
    })
}

/// The data of the CAN FD frame that carries `frame`, written into `buffer`; `None` if it is too long for one.
pub fn pad<'b>(frame: &[u8], buffer: &'b mut [u8; FD_CAPACITY]) -> Option<&'b [u8]> {
    let data = buffer.get_mut(..fd_len(frame.len())?)?;
    let (content, padding) = data.split_at_mut_checked(frame.len())?;
    content.copy_from_slice(frame);
    padding.fill(0);
    Some(data)
}

/// The frame in `data`, as it was before [`pad`]: for [`crate::controller::Controller::receive`] and
/// [`crate::actuator::Actuator::receive`], which check it. `None` if no frame begins there, or what follows it is not the
/// padding it must have.
pub fn unpad(data: &[u8]) -> Option<&[u8]> {
    let (frame, padding) = data.split_at_checked(frame_len(data)?)?;
    let is_padded = fd_len(frame.len()) == Some(data.len()) && padding.iter().all(|&byte| byte == 0);
    is_padded.then_some(frame)
}
