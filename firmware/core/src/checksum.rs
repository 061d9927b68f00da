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

#[cfg(test)]
mod tests {
    use super::checksum;
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
}
