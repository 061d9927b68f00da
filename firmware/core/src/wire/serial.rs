//! Frames on a serial line: consistent overhead byte stuffing, a zero after each frame.
//!
//! No byte of a stuffed frame is zero, so that a receiver that joins in the middle, or has lost a byte, is in step again
//! with the next zero. Stuffing is the `cobs` crate's; what a frame says is not known here.

use super::EncodeError;
use cobs::{DecodeResult, DecoderState};
use heapless::Vec;

/// Most bytes that a frame of `len` bytes takes on the line, its zero included.
pub const fn stuffed_len(len: usize) -> usize {
    cobs::max_encoding_length(len) + 1
}

/// Writes `frame` as it goes over the line into `buffer`, and returns its bytes: [`stuffed_len`] of them or one less.
/// Of a frame of no byte nothing gets through: frames have some.
///
/// # Errors
/// If `buffer` is too small.
// Once in flash, whoever sends.
#[inline(never)]
pub fn stuff<'b>(frame: &[u8], buffer: &'b mut [u8]) -> Result<&'b [u8], EncodeError> {
    let len = cobs::try_encode(frame, buffer).map_err(|_| EncodeError::BufferTooSmall)?;
    *buffer.get_mut(len).ok_or(EncodeError::BufferTooSmall)? = 0;
    buffer.get(..=len).ok_or(EncodeError::BufferTooSmall)
}

/// Takes bytes from the line and finds the frames in them, of up to `C` bytes.
#[derive(Debug)]
pub struct Unstuffer<const C: usize> {
    state: DecoderState,
    frame: Vec<u8, C>,
    /// Whether `frame` is one that was handed out, and the next byte begins another.
    is_over: bool,
    /// Whether the present frame is too long to be kept.
    is_lost: bool,
    lost: u32,
}

impl<const C: usize> Default for Unstuffer<C> {
    fn default() -> Self {
        Self { state: DecoderState::Idle, frame: Vec::new(), is_over: false, is_lost: false, lost: 0 }
    }
}

impl<const C: usize> Unstuffer<C> {
    /// Takes the next byte; returns the frame that it ends, if it ends one. Bytes that are no stuffed frame, or one of more
    /// than `C` bytes, are dropped up to the next zero.
    pub fn take(&mut self, byte: u8) -> Option<&[u8]> {
        if self.is_over {
            self.frame.clear();
            self.is_over = false;
        }
        match self.state.feed(byte) {
            Ok(DecodeResult::NoData) => None,
            Ok(DecodeResult::DataContinue(value)) => {
                self.is_lost |= self.frame.push(value).is_err();
                None
            }
            Ok(DecodeResult::DataComplete) if !self.is_lost => {
                self.is_over = true;
                Some(&self.frame)
            }
            Ok(DecodeResult::DataComplete) | Err(_) => {
                self.is_over = true;
                self.is_lost = false;
                self.lost = self.lost.saturating_add(1);
                None
            }
        }
    }

    /// Frames that were dropped, since the start; saturates.
    pub fn lost(&self) -> u32 {
        self.lost
    }
}
