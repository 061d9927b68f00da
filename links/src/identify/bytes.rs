//! Rows of whole numbers in few bytes: seven bits to a byte, the small ones in one. A log of a gigabyte has tens of millions
//! of packets, and all of them are needed until the figures are computed.

use std::collections::VecDeque;

const CHUNK: usize = 1 << 16;
/// No row is longer: at most four numbers of ten bytes each.
const ROW: usize = 40;
const MICROSECOND: i64 = 1000;
/// Odd numbers stand for something else than whole microseconds: nanoseconds follow, or no time.
const NANOSECONDS: i64 = 1;
const NEVER: i64 = 3;

/// Rows one after the other, in chunks that are given back one by one while they are drained.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Rows {
    chunks: VecDeque<Vec<u8>>,
}

impl Rows {
    /// Where the next row goes: a row lies in one chunk.
    #[inline]
    pub(super) fn row(&mut self) -> &mut Vec<u8> {
        if self.chunks.back().is_none_or(|chunk| chunk.len() + ROW > CHUNK) {
            self.chunks.push_back(Vec::with_capacity(CHUNK));
        }
        let last = self.chunks.len() - 1;
        &mut self.chunks[last]
    }

    /// The chunk and the place in it where a row begins, if there is one at or after `place`.
    #[inline]
    pub(super) fn at(&self, place: &mut Place) -> Option<&[u8]> {
        let mut chunk = self.chunks.get(place.chunk)?;
        if place.byte >= chunk.len() {
            *place = Place { chunk: place.chunk + 1, byte: 0 };
            chunk = self.chunks.get(place.chunk)?;
        }
        Some(chunk)
    }

    /// Gives back the chunks before `place`.
    pub(super) fn forget(&mut self, place: &mut Place) {
        while place.chunk > 0 {
            self.chunks.pop_front();
            place.chunk -= 1;
        }
    }
}

/// A place in [`Rows`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Place {
    chunk: usize,
    pub(super) byte: usize,
}

/// Writes a number.
#[inline]
pub(super) fn put(row: &mut Vec<u8>, number: i64) {
    // The sign comes last, so that small negative numbers are short too.
    let mut rest = (number << 1 ^ number >> 63) as u64;
    while rest >= 0x80 {
        row.push(rest as u8 | 0x80);
        rest >>= 7;
    }
    row.push(rest as u8);
}

/// Reads what [`put`] wrote.
#[inline]
pub(super) fn take(row: &[u8], at: &mut usize) -> i64 {
    // Most are small.
    if let Some(&byte) = row.get(*at)
        && byte < 0x80
    {
        *at += 1;
        return i64::from(byte >> 1) ^ -i64::from(byte & 1);
    }
    let (mut rest, mut shift) = (0_u64, 0);
    while let Some(&byte) = row.get(*at) {
        *at += 1;
        rest |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            break;
        }
        shift += 7;
    }
    (rest >> 1) as i64 ^ -((rest & 1) as i64)
}

/// Writes a difference of times: most logs have whole microseconds.
#[inline]
pub(super) fn put_time(row: &mut Vec<u8>, nanoseconds: i64) {
    match nanoseconds % MICROSECOND {
        0 => put(row, nanoseconds / MICROSECOND * 2),
        _ => {
            put(row, NANOSECONDS);
            put(row, nanoseconds);
        }
    }
}

/// Reads what [`put_time`] wrote.
#[inline]
pub(super) fn take_time(row: &[u8], at: &mut usize) -> i64 {
    match take(row, at) {
        NANOSECONDS => take(row, at),
        twice => twice / 2 * MICROSECOND,
    }
}

/// Writes a time that may never have come.
pub(super) fn put_time_or_never(row: &mut Vec<u8>, nanoseconds: Option<i64>) {
    match nanoseconds {
        Some(nanoseconds) => put_time(row, nanoseconds),
        None => put(row, NEVER),
    }
}

/// Reads what [`put_time_or_never`] wrote.
pub(super) fn take_time_or_never(row: &[u8], at: &mut usize) -> Option<i64> {
    let before = *at;
    if take(row, at) == NEVER {
        return None;
    }
    *at = before;
    Some(take_time(row, at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_as_they_were_written() {
        let numbers = [0, 1, -1, 63, -64, 64, 1_000_000, -1_234_567, i64::MAX / 2, i64::MIN / 2, 999, 1001];
        let mut rows = Rows::default();
        for round in 0..5000 {
            let row = rows.row();
            put(row, numbers[round % 12]);
            put_time(row, numbers[(round + 5) % 12]);
        }
        let mut place = Place::default();
        for round in 0..5000 {
            let row = rows.at(&mut place).expect("a row");
            let mut at = place.byte;
            assert_eq!(take(row, &mut at), numbers[round % 12]);
            assert_eq!(take_time(row, &mut at), numbers[(round + 5) % 12]);
            place.byte = at;
            rows.forget(&mut place);
        }
        assert!(rows.at(&mut place).is_none());
    }
}
