//! A key, which nothing prints.

/// Bytes of a key.
const LEN: usize = 16;

/// An AES-128 key. It has neither a text form nor an order, and `Debug` tells none of it.
///
/// It must come from a source of random numbers, and be known to those alone who are to speak under it.
#[derive(Clone)]
pub struct Key([u8; LEN]);

impl Key {
    /// A key of these bytes.
    pub const fn new(bytes: [u8; LEN]) -> Self {
        Self(bytes)
    }

    /// The key of 32 hexadecimal digits, in either case; `None` for any other text.
    ///
    /// A constant: firmware is given its keys by environment variables of its build.
    pub const fn from_hex(text: &str) -> Option<Self> {
        let text = text.as_bytes();
        if text.len() != 2 * LEN {
            return None;
        }
        let mut bytes = [0; LEN];
        let mut at = 0;
        while at < LEN {
            let (Some(high), Some(low)) = (digit(text[2 * at]), digit(text[2 * at + 1])) else { return None };
            bytes[at] = high << 4 | low;
            at += 1;
        }
        Some(Self(bytes))
    }

    pub(super) const fn bytes(&self) -> &[u8; LEN] {
        &self.0
    }
}

const fn digit(sign: u8) -> Option<u8> {
    match sign {
        b'0'..=b'9' => Some(sign - b'0'),
        b'a'..=b'f' => Some(sign - b'a' + 10),
        b'A'..=b'F' => Some(sign - b'A' + 10),
        _ => None,
    }
}

impl core::fmt::Debug for Key {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Key(..)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_read_from_hexadecimal_digits_and_from_nothing_else() {
        let key = Key::from_hex("000102030405060708090a0b0C0D0E0F").unwrap();
        assert_eq!(key.bytes(), &core::array::from_fn(|at| at as u8));
        assert!(Key::from_hex("000102030405060708090a0b0c0d0e0").is_none());
        assert!(Key::from_hex("000102030405060708090a0b0c0d0e0g").is_none());
        assert!(Key::from_hex("000102030405060708090a0b0c0d0e0f00").is_none());
    }
}
