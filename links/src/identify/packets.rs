//! [`Packets`]: the packets of a log in the order sent, a few bytes each.

use super::bytes::{Place, Rows, put, put_time, put_time_or_never, take, take_time, take_time_or_never};

/// One packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet {
    /// Its number.
    pub sequence: u64,
    /// When it was sent, in nanoseconds; unknown for one that only a gap tells of.
    pub sent: Option<i64>,
    /// When it arrived, in nanoseconds; never, if it was lost.
    pub received: Option<i64>,
}

/// Packets that were sent, by ascending number.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Packets {
    rows: Rows,
    sequence: u64,
    sent: i64,
    /// How many.
    pub(super) len: u64,
}

impl Packets {
    pub(super) fn push(&mut self, sequence: u64, sent: i64, received: Option<i64>) {
        let row = self.rows.row();
        put(row, sequence.wrapping_sub(self.sequence) as i64);
        put_time(row, sent - self.sent);
        put_time_or_never(row, received.map(|received| received - sent));
        (self.sequence, self.sent) = (sequence, sent);
        self.len += 1;
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (u64, i64, Option<i64>)> + '_ {
        let (mut place, mut sequence, mut sent) = (Place::default(), 0_u64, 0_i64);
        std::iter::from_fn(move || {
            let row = self.rows.at(&mut place)?;
            sequence = sequence.wrapping_add(take(row, &mut place.byte) as u64);
            sent += take_time(row, &mut place.byte);
            let delay = take_time_or_never(row, &mut place.byte);
            Some((sequence, sent, delay.map(|delay| sent + delay)))
        })
    }
}
