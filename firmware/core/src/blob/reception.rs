//! A blob that comes over the link in parts.
//!
//! Parts come in order, or again; whatever else comes is answered with what is missing. What becomes of a blob that is whole is
//! the receiver's business: [`crate::bank::Bank::load`].

use super::BlobError;
use crate::wire::{GainsAnswer, GainsPart, Verdict};

/// Room for a blob of up to `C` bytes, and how much of it is there.
#[derive(Debug, Clone)]
pub struct Reception<const C: usize> {
    bytes: [u8; C],
    /// Number of the transfer.
    transfer: u32,
    /// Bytes of the whole blob; zero while none is under way.
    total: usize,
    received: usize,
}

impl<const C: usize> Default for Reception<C> {
    fn default() -> Self {
        Self { bytes: [0; C], transfer: 0, total: 0, received: 0 }
    }
}

impl<const C: usize> Reception<C> {
    /// Takes a part; returns the blob if that was the last one, else what to answer.
    ///
    /// The part at offset 0 begins a transfer, and ends another that was under way. A part that has been received is
    /// answered again, as its answer may have been lost.
    pub fn take(&mut self, part: &GainsPart<'_>) -> Result<&[u8], GainsAnswer> {
        let (offset, total) = (usize::from(part.offset), usize::from(part.total));
        if offset == 0 && (part.transfer, total) != (self.transfer, self.total) {
            (self.transfer, self.total, self.received) = (part.transfer, total, 0);
        }
        if total > C {
            return Err(self.answer(Verdict::TooLong));
        }
        let is_next = (part.transfer, total, offset) == (self.transfer, self.total, self.received);
        let end = offset + part.bytes.len();
        if is_next && end <= total {
            let Some(room) = self.bytes.get_mut(offset..end) else {
                return Err(self.answer(Verdict::TooLong));
            };
            room.copy_from_slice(part.bytes);
            self.received = end;
            if end == total {
                self.total = 0;
                return Ok(self.bytes.get(..end).unwrap_or_default());
            }
        }
        Err(self.answer(Verdict::Incomplete))
    }

    /// What to answer to the last part.
    pub fn answer(&self, verdict: Verdict) -> GainsAnswer {
        // A blob is shorter than 2^16 bytes: its parts say so in two.
        GainsAnswer { received: u16::try_from(self.received).unwrap_or(u16::MAX), verdict }
    }
}

impl From<BlobError> for Verdict {
    fn from(error: BlobError) -> Self {
        match error {
            BlobError::TooShort | BlobError::Checksum | BlobError::Magic | BlobError::Length => Self::Damaged,
            BlobError::Version(_) | BlobError::Scalar(_) | BlobError::DefaultInput(_) => Self::Format,
            BlobError::Design(_) => Self::Design,
            BlobError::States(_) | BlobError::Inputs(_) | BlobError::Sequence => Self::Dimensions,
            BlobError::StorageTooSmall { .. } => Self::TooLong,
            BlobError::Gains(_) => Self::Numbers,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(transfer: u32, offset: u16, bytes: &[u8]) -> GainsPart<'_> {
        GainsPart { transfer, offset, total: 6, bytes }
    }

    #[test]
    fn parts_in_order_make_the_blob() {
        let mut reception = Reception::<8>::default();
        let answer = |received| GainsAnswer { received, verdict: Verdict::Incomplete };
        assert_eq!(reception.take(&part(1, 0, &[1, 2])), Err(answer(2)));
        assert_eq!(reception.take(&part(1, 2, &[3, 4])), Err(answer(4)));
        assert_eq!(reception.take(&part(1, 2, &[3, 4])), Err(answer(4)), "again: its answer was lost");
        assert_eq!(reception.take(&part(1, 5, &[6])), Err(answer(4)), "a part is missing");
        assert_eq!(reception.take(&part(1, 4, &[5, 6])), Ok(&[1, 2, 3, 4, 5, 6][..]));
    }

    #[test]
    fn another_transfer_begins_anew() {
        let mut reception = Reception::<8>::default();
        let _ = reception.take(&part(1, 0, &[1, 2, 3]));
        assert!(reception.take(&part(2, 3, &[9])).is_err_and(|answer| answer.received == 3));
        assert!(reception.take(&part(2, 0, &[7])).is_err_and(|answer| answer.received == 1));
        assert_eq!(reception.take(&part(2, 1, &[8, 9, 10, 11, 12])), Ok(&[7, 8, 9, 10, 11, 12][..]));
    }

    #[test]
    fn what_there_is_no_room_for_is_refused_at_once() {
        let mut reception = Reception::<4>::default();
        let answer = reception.take(&part(1, 0, &[1, 2]));
        assert!(answer.is_err_and(|answer| answer.verdict == Verdict::TooLong));
        let mut reception = Reception::<8>::default();
        let answer = reception.take(&part(1, 0, &[1; 7]));
        assert!(answer.is_err_and(|answer| answer.received == 0), "longer than it says");
    }
}
