//! The one checksum of frames, blobs and ids: CRC-32/ISCSI, `docs/wire-format.md`.
//!
//! The table is that of single bytes, 1 KiB of flash; what is read from memory is four bytes at a time, which takes a
//! Cortex-M4F four instructions a byte instead of seven.

/// The generator polynomial, bit-reversed.
const POLYNOMIAL: u32 = 0x82F6_3B78;

/// A static, so that it is there once.
static TABLE: [u32; 256] = table();

const fn table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < table.len() {
        let mut remainder = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            remainder = (remainder >> 1) ^ if remainder & 1 == 1 { POLYNOMIAL } else { 0 };
            bit += 1;
        }
        table[byte] = remainder;
        byte += 1;
    }
    table
}

/// CRC-32/ISCSI of `content`.
// Once in flash, for all frames, and blobs.
#[inline(never)]
pub(crate) fn checksum(content: &[u8]) -> u32 {
    let shifted = |remainder: u32| TABLE[usize::from(remainder as u8)] ^ (remainder >> 8);
    let (words, bytes) = content.as_chunks();
    let of_words = words.iter().fold(!0, |remainder, word| {
        (0..word.len()).fold(remainder ^ u32::from_le_bytes(*word), |remainder, _| shifted(remainder))
    });
    !bytes.iter().fold(of_words, |remainder, byte| shifted(remainder ^ u32::from(*byte)))
}

/// Remainder before the first word. What remains after the last one, inverted, is the checksum.
pub(crate) const FIRST: u32 = !0;

/// The remainder after another word, its bytes in little-endian order: of constants, and of numbers that are taken one by one.
// Once in flash likewise.
#[inline(never)]
pub(crate) const fn after_word(remainder: u32, word: u32) -> u32 {
    let (mut remainder, mut byte) = (remainder ^ word, 0);
    while byte < size_of::<u32>() {
        remainder = TABLE[(remainder & 0xff) as usize] ^ (remainder >> 8);
        byte += 1;
    }
    remainder
}

#[cfg(test)]
mod tests {
    use super::{FIRST, after_word, checksum};
    use crc::{CRC_32_ISCSI, Crc};

    #[test]
    fn it_is_that_of_the_catalogue_whatever_the_length() {
        assert_eq!(checksum(b"123456789"), CRC_32_ISCSI.check);
        let reference = Crc::<u32>::new(&CRC_32_ISCSI);
        let mut bytes = [0u8; 70];
        for (place, byte) in bytes.iter_mut().enumerate() {
            *byte = (place * place * 37 + 11) as u8;
        }
        for length in 0..=bytes.len() {
            assert_eq!(checksum(&bytes[..length]), reference.checksum(&bytes[..length]), "{length} bytes");
        }
    }

    #[test]
    fn word_by_word_it_is_the_same() {
        let words = [0x0302_0100, 0xffff_ffff, 0, 0x8000_0001_u32];
        let bytes = words.map(u32::to_le_bytes);
        assert_eq!(!words.into_iter().fold(FIRST, after_word), checksum(bytes.as_flattened()));
    }
}
