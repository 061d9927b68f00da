//! [`Id`]: what a frame is called and how urgent it is. Not who may send it.

use std::{cmp::Ordering, fmt};

/// Identifier of a frame, 11 bits (base format) or 29 bits (extended format).
///
/// Ordered as arbitration orders them: the smaller one wins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Id {
    value: u32,
    extended: bool,
}

/// An identifier that does not fit its format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("found identifier {value:#x}: a {bits}-bit identifier is at most {:#x}", (1u32 << bits) - 1)]
pub struct IdError {
    /// What was found.
    pub value: u32,
    /// 11 or 29.
    pub bits: u32,
}

impl Id {
    /// An identifier of 11 bits.
    ///
    /// # Errors
    /// A value above 0x7FF.
    pub const fn base(value: u16) -> Result<Self, IdError> {
        if value < 1 << 11 {
            Ok(Id { value: value as u32, extended: false })
        } else {
            Err(IdError { value: value as u32, bits: 11 })
        }
    }

    /// An identifier of 29 bits.
    ///
    /// # Errors
    /// A value above 0x1FFF_FFFF.
    pub const fn extended(value: u32) -> Result<Self, IdError> {
        if value < 1 << 29 { Ok(Id { value, extended: true }) } else { Err(IdError { value, bits: 29 }) }
    }

    /// The number.
    pub const fn value(self) -> u32 {
        self.value
    }

    /// Whether it has 29 bits.
    pub const fn is_extended(self) -> bool {
        self.extended
    }

    /// The bits that arbitrate, first sent first: 11 identifier bits, RTR or SRR, IDE, 18 further identifier bits.
    ///
    /// A base frame is dominant (0) in RTR and IDE, an extended one recessive (1) in SRR and IDE: of two frames with the
    /// same first 11 bits the base frame wins. What follows IDE in a base frame meets no other frame any more.
    pub const fn priority(self) -> u32 {
        if self.extended {
            (self.value >> 18) << 20 | 0b11 << 18 | self.value & 0x3_FFFF
        } else {
            self.value << 20
        }
    }
}

impl Ord for Id {
    fn cmp(&self, other: &Self) -> Ordering {
        self.priority().cmp(&other.priority())
    }
}

impl PartialOrd for Id {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl fmt::Display for Id {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = if self.extended { format!("{:08X}x", self.value) } else { format!("{:03X}", self.value) };
        out.pad(&text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_base_frame_wins_over_an_extended_one_with_the_same_first_bits() {
        let base = Id::base(0x123).unwrap();
        let extended = |value| Id::extended(value).unwrap();
        assert!(base < extended(0x123 << 18));
        assert!(extended((0x123 << 18) - 1) < base);
        assert!(extended(0x123 << 18 | 0x3_FFFF) < Id::base(0x124).unwrap());
        assert!(extended(5) < extended(6));
    }

    #[test]
    fn an_identifier_that_does_not_fit_is_refused() {
        assert_eq!(Id::base(0x800), Err(IdError { value: 0x800, bits: 11 }));
        assert_eq!(Id::extended(1 << 29), Err(IdError { value: 1 << 29, bits: 29 }));
        assert!(Id::base(0x7FF).is_ok() && Id::extended((1 << 29) - 1).is_ok());
    }
}
