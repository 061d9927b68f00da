//! `Tick`: the wrapping control-cycle counter, the only time there is.
//!
//! Seconds do not exist in this crate: a tick times the design's sample time is a time in seconds.

use core::ops::{Add, AddAssign, Sub};
use serde::{Deserialize, Serialize};

/// Number of a control cycle, modulo 2^32, ordered by serial-number arithmetic (RFC 1982).
///
/// A 1 kHz loop wraps after 49 days. Two ticks compare meaningfully while they are less than 2^31 cycles
/// apart; whoever keeps a tick for longer than that must drop it before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Tick(#[serde(with = "postcard::fixint::le")] pub u32);

impl Tick {
    /// Cycles from `earlier` to `self`; negative if `self` came first.
    ///
    /// In -2^31..2^31; for ticks exactly 2^31 apart, where RFC 1982 leaves the order open, it is -2^31.
    #[inline]
    pub const fn since(self, earlier: Tick) -> i32 {
        self.0.wrapping_sub(earlier.0) as i32
    }

    /// Age at `self` of something made at `made`, in cycles; `None` if that lies in the future.
    #[inline]
    pub const fn age_of(self, made: Tick) -> Option<u32> {
        let age = self.since(made);
        if age >= 0 { Some(age as u32) } else { None }
    }

    /// Whether `self` came after `other`.
    #[inline]
    pub const fn is_after(self, other: Tick) -> bool {
        self.since(other) > 0
    }
}

impl Add<u32> for Tick {
    type Output = Tick;
    #[inline]
    fn add(self, cycles: u32) -> Tick {
        Tick(self.0.wrapping_add(cycles))
    }
}

impl Sub<u32> for Tick {
    type Output = Tick;
    #[inline]
    fn sub(self, cycles: u32) -> Tick {
        Tick(self.0.wrapping_sub(cycles))
    }
}

impl AddAssign<u32> for Tick {
    #[inline]
    fn add_assign(&mut self, cycles: u32) {
        *self = *self + cycles;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_survives_the_wrap() {
        let before = Tick(u32::MAX);
        let after = before + 1;
        assert_eq!(after, Tick(0));
        assert!(after.is_after(before));
        assert_eq!(after.age_of(before), Some(1));
        assert_eq!(before.age_of(after), None);
        assert_eq!(before.since(after), -1);
    }

    #[test]
    fn a_tick_is_not_after_itself() {
        assert!(!Tick(7).is_after(Tick(7)));
        assert_eq!(Tick(7).age_of(Tick(7)), Some(0));
    }

    #[test]
    fn half_the_circle_away_counts_as_before() {
        assert_eq!(Tick(0x8000_0000).since(Tick(0)), i32::MIN);
        assert!(!Tick(0x8000_0000).is_after(Tick(0)));
    }
}
