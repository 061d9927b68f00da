//! [`Time`] and [`Rates`]: nanoseconds, and how many of them a bit lasts.

/// A point in time, or a length of time, in nanoseconds. 2^64 of them are 584 years.
///
/// Nanoseconds and not bits, so that bits of both bit rates of CAN FD and the periods of the nodes are whole numbers.
pub type Time = u64;

/// Nanoseconds in a second.
pub const SECOND: Time = 1_000_000_000;

/// Intermission between two frames, in nominal bits.
pub const INTERMISSION: u32 = 3;

/// How long bits last.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rates {
    /// At the nominal bit rate, in nanoseconds.
    pub bit: Time,
    /// At the data bit rate, in nanoseconds; the same as `bit` on a bus without one.
    pub data_bit: Time,
}

/// A bit rate whose bits do not last whole nanoseconds, or a data bit rate below the nominal one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum RateError {
    /// Zero, above 10^9, or no divisor of 10^9.
    #[error(
        "found a bit rate of {0} bit/s: a bit must last a whole number of nanoseconds, as at 125000, 250000, 500000, \
         1000000, 2000000, 4000000, 5000000 or 8000000 bit/s"
    )]
    NotWhole(u32),
    /// The data phase is slower than arbitration.
    #[error(
        "found a data bit rate of {data} bit/s below the nominal bit rate of {nominal} bit/s: it must be at least that"
    )]
    SlowData {
        /// Nominal bit rate, in bit/s.
        nominal: u32,
        /// Data bit rate, in bit/s.
        data: u32,
    },
}

impl Rates {
    /// From bit rates in bit/s.
    ///
    /// # Errors
    /// Bits that do not last whole nanoseconds; a data bit rate below the nominal one.
    pub fn new(bit_rate: u32, data_bit_rate: Option<u32>) -> Result<Self, RateError> {
        let whole = |rate: u32| {
            let exact = rate > 0 && SECOND.is_multiple_of(Time::from(rate));
            if exact { Ok(SECOND / Time::from(rate)) } else { Err(RateError::NotWhole(rate)) }
        };
        let data = data_bit_rate.unwrap_or(bit_rate);
        let rates = Rates { bit: whole(bit_rate)?, data_bit: whole(data)? };
        if data < bit_rate {
            return Err(RateError::SlowData { nominal: bit_rate, data });
        }
        Ok(rates)
    }

    /// Time of so many nominal bits.
    pub fn bits(self, nominal: u32) -> Time {
        Time::from(nominal) * self.bit
    }
}
