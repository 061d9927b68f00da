//! Counts of a grid as the bytes of a compact frame: 16 bits each, or 13 where there are three of them.

use super::{Grid, LARGEST_OF_FULL_FRAME, MOST_VALUES, PackError, UnpackError, compact::Data};
use crate::{Scalar, wire::DecodeError};
use heapless::Vec;
use nalgebra::SVector;

const BYTES: usize = 2;
/// Bits of a count in a full frame.
const BITS: usize = 13;
/// Bytes of a full frame's counts: 39 bits, the last one is zero.
const FULL: usize = (BITS * MOST_VALUES).div_ceil(8);

/// Bytes of the counts of `values` values.
pub(super) const fn counts_len(values: usize) -> usize {
    if values < MOST_VALUES { values * BYTES } else { (values * BITS).div_ceil(8) }
}

/// Whether a frame of `values` values has room for the largest count of `grid`.
pub(super) fn has_room<T, const D: usize>(grid: &Grid<T, D>, values: usize) -> bool {
    grid.largest_count <= super::largest_count(values)
}

/// Puts the counts of `vectors` behind what is in `data`.
pub(super) fn put<T: Scalar, const D: usize>(
    data: &mut Data,
    grid: &Grid<T, D>,
    vectors: &[SVector<T, D>],
) -> Result<(), PackError> {
    let found = D * vectors.len();
    if !(1..=MOST_VALUES).contains(&found) {
        return Err(PackError::Values(found));
    }
    if !has_room(grid, found) {
        return Err(PackError::Counts(found));
    }
    let mut counts = Vec::<i16, MOST_VALUES>::new();
    for (&value, &step) in vectors.iter().flat_map(|vector| vector.iter().zip(grid.step.iter())) {
        let count = grid.count(value, step).ok_or(PackError::Decode(DecodeError::NotFinite))?;
        counts.push(count).map_err(|_| PackError::Values(found))?;
    }
    let written = if let &[a, b, c] = counts.as_slice() {
        let mask = (1 << BITS) - 1;
        let bits = [a, b, c].iter().rev().fold(0_u64, |bits, &count| bits << BITS | (count as u64 & mask));
        data.extend_from_slice(&bits.to_le_bytes()[..FULL])
    } else {
        counts.iter().try_for_each(|count| data.extend_from_slice(&count.to_le_bytes()))
    };
    written.map_err(|_| PackError::Values(found))
}

/// The vectors, at least one, that `bytes` count; `Ok(None)` if there are none of such a length.
pub(super) fn vectors<T: Scalar, const D: usize>(
    grid: &Grid<T, D>,
    bytes: &[u8],
) -> Result<Option<Vec<SVector<T, D>, MOST_VALUES>>, UnpackError> {
    let mut counts = Vec::<i16, MOST_VALUES>::new();
    if let &[a, b, c, d, e] = bytes {
        let bits = u64::from_le_bytes([a, b, c, d, e, 0, 0, 0]);
        if bits >> (BITS * MOST_VALUES) != 0 {
            return Err(UnpackError::Count);
        }
        // The sign of 13 bits is put where that of 16 is, and comes back with the shift.
        let unused = i16::BITS as usize - BITS;
        let count = |place: usize| ((bits >> (BITS * place)) as u16 as i16) << unused >> unused;
        counts.extend((0..MOST_VALUES).map(count));
        // -4096 is none, whatever the grid.
        if counts.iter().any(|count| *count < -LARGEST_OF_FULL_FRAME) {
            return Err(UnpackError::Count);
        }
    } else if matches!(bytes.len(), 2 | 4) {
        counts.extend(bytes.chunks_exact(BYTES).map(|count| i16::from_le_bytes([count[0], count[1]])));
    }
    if counts.is_empty() || counts.len().checked_rem(D) != Some(0) || !has_room(grid, counts.len()) {
        return Ok(None);
    }
    let mut vectors = Vec::new();
    for counts in counts.chunks_exact(D) {
        let vector = grid.values(&SVector::from_column_slice(counts)).ok_or(UnpackError::Count)?;
        if vectors.push(vector).is_err() {
            return Ok(None);
        }
    }
    Ok(Some(vectors))
}
