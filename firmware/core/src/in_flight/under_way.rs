//! Packets that were sent after the one that is played, and how likely they arrive.

use super::InFlight;
use crate::{Scalar, arrival, gains::Gains, played::Age};
use nalgebra::SVector;

/// A packet that may yet arrive.
pub(super) struct Packet<'p, T: Scalar, const NU: usize> {
    /// How many cycles before the current one it was sent.
    pub(super) sent_ago: usize,
    /// Its inputs from the current cycle on; `None` if nothing was sent.
    pub(super) inputs: Option<&'p [SVector<T, NU>]>,
    /// `r(a, 0), r(a, 1), ..`, as many.
    pub(super) arrivals: &'p [T],
}

/// See [`InFlight::newer_than`].
pub(super) struct UnderWay<'p, T: Scalar, const NU: usize> {
    in_flight: &'p InFlight<'p, T, NU>,
    /// How many cycles before the current one the packet to come was sent.
    sent_ago: usize,
    length: usize,
    /// Rows of the packets to come, newest first.
    rows: &'p [T],
}

impl<T: Scalar, const NU: usize> InFlight<'_, T, NU> {
    /// What was sent less than `packet` cycles ago, `1..=length`, oldest first.
    #[inline(always)]
    pub(super) fn newer_than<'p, const NX: usize>(
        &'p self,
        packet: usize,
        gains: &Gains<'p, T, NX, NU>,
    ) -> UnderWay<'p, T, NU> {
        let length = self.length;
        // Rows of older packets are a table themselves, at the end of the whole.
        let older = arrival::table_len((length + 1).saturating_sub(packet));
        let rows = gains.arrival_table();
        let rows = rows.get(..rows.len().saturating_sub(older)).unwrap_or_default();
        UnderWay { in_flight: self, sent_ago: packet, length, rows }
    }
}

impl<'p, T: Scalar, const NU: usize> Iterator for UnderWay<'p, T, NU> {
    type Item = Packet<'p, T, NU>;

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let sent_ago = self.sent_ago.checked_sub(1).filter(|ago| *ago > 0)?;
        self.sent_ago = sent_ago;
        let newer = self.rows.len().checked_sub(self.length.checked_sub(sent_ago)?)?;
        let (rows, arrivals) = self.rows.split_at_checked(newer)?;
        self.rows = rows;
        let inputs = self.in_flight.sent(sent_ago - 1).and_then(|inputs| inputs.get(sent_ago..));
        Some(Packet { sent_ago, inputs, arrivals })
    }
}

/// How many cycles before the current one the packet was sent that had `age` in the last cycle; `length` if the buffer had run
/// out: of either nothing is left.
#[inline]
pub(super) fn packet_played(age: Age, length: usize) -> usize {
    age.steps().map_or(length, |steps| (steps + 1).min(length))
}

/// The age that the packet sent `packet` cycles before the current one had in the last cycle.
#[inline]
pub(super) fn age_of(packet: usize) -> Age {
    packet.checked_sub(1).and_then(|steps| u8::try_from(steps).ok()).map_or(Age::Empty, Age::Steps)
}
