//! A classic CAN frame as bits, and what a receiver makes of bits: destuffing, form and CRC (ISO 11898-1:2015), written down
//! anew beside `slqg_links::can::bits`, which only sends.

use crc::{CRC_15_CAN, Crc};

static CRC_15: Crc<u16> = Crc::<u16>::new(&CRC_15_CAN);

/// SOF, identifier, RTR, IDE, r0 and data length.
pub(crate) const HEADER: usize = 19;
pub(crate) const CRC: usize = 15;
/// CRC delimiter, acknowledgement slot and delimiter, end of frame but its last bit, which receivers do not look at.
const TAIL: [u8; 9] = [1, 0, 1, 1, 1, 1, 1, 1, 1];

/// The bits of a frame, without stuff bits, from SOF to the CRC.
pub(crate) fn plain(id: u16, data: &[u8]) -> Vec<u8> {
    let mut bits = Vec::with_capacity(HEADER + 64 + CRC);
    let mut put =
        |value: u64, width: u32| bits.extend((0..width).rev().map(|place| (value >> place & 1) as u8));
    put(u64::from(id), 12);
    put(data.len() as u64, 7);
    data.iter().for_each(|byte| put(u64::from(*byte), 8));
    let crc = checksum(&bits);
    bits.extend((0..CRC).rev().map(|place| (crc >> place & 1) as u8));
    bits
}

fn checksum(bits: &[u8]) -> u16 {
    // The register starts at 0, so that zeros ahead, up to whole bytes, change nothing.
    let value = bits.iter().fold(0_u128, |value, bit| value << 1 | u128::from(*bit));
    CRC_15.checksum(&value.to_be_bytes())
}

/// Run of equal bits: after five of them comes a stuff bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Run {
    last: u8,
    length: u8,
}

/// What a bit is to a receiver that destuffs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Bit {
    Plain,
    Stuffed,
    /// The sixth equal one.
    Wrong,
}

impl Run {
    pub(crate) const START: Self = Self { last: 2, length: 0 };

    pub(crate) fn take(&mut self, bit: u8) -> Bit {
        let comes_after_five = self.length == 5;
        self.length = if bit == self.last { self.length + 1 } else { 1 };
        self.last = bit;
        match comes_after_five {
            true if self.length == 6 => Bit::Wrong,
            true => Bit::Stuffed,
            false => Bit::Plain,
        }
    }
}

/// All that is sent up to the CRC, stuffed; how many bits that are; then the end of the frame.
pub(crate) fn stuffed(plain: &[u8]) -> (Vec<u8>, usize) {
    let mut line = Vec::with_capacity(160);
    let mut run = Run::START;
    for bit in plain {
        run.take(*bit);
        line.push(*bit);
        if run.length == 5 {
            run.take(1 - bit);
            line.push(1 - bit);
        }
    }
    let covered = line.len();
    line.extend(TAIL);
    (line, covered)
}

/// The identifier and the data that a receiver takes from the line, if it takes a data frame with eleven bits of identifier.
pub(crate) fn received(line: &[u8]) -> Option<(u16, [u8; 8], usize)> {
    let mut bits = [0_u8; HEADER + 64 + CRC];
    let (mut run, mut count, mut total) = (Run::START, 0, HEADER);
    let mut rest = line.iter();
    while count < total {
        let bit = *rest.next()?;
        match run.take(bit) {
            Bit::Plain => {
                bits[count] = bit;
                count += 1;
            }
            Bit::Stuffed => (),
            Bit::Wrong => return None,
        }
        if count == HEADER && total == HEADER {
            // SOF, RTR and IDE; the reserved bit is not looked at.
            if bits[0] != 0 || bits[12] != 0 || bits[13] != 0 {
                return None;
            }
            total = HEADER + 8 * data_len(&bits) + CRC;
        }
    }
    if run.length == 5 && run.take(*rest.next()?) == Bit::Wrong {
        return None;
    }
    // The acknowledgement slot may be either.
    let tail_fits =
        TAIL.iter().enumerate().all(|(at, bit)| rest.next().is_some_and(|found| at == 1 || found == bit));
    let (content, told) = bits[..total].split_at(total - CRC);
    let told = told.iter().fold(0, |value, bit| value << 1 | u16::from(*bit));
    if !tail_fits || checksum(content) != told {
        return None;
    }
    let mut data = [0; 8];
    for (byte, bits) in data.iter_mut().zip(content[HEADER..].chunks(8)) {
        *byte = bits.iter().fold(0, |value, bit| value << 1 | bit);
    }
    let id = content[1..12].iter().fold(0, |value, bit| value << 1 | u16::from(*bit));
    Some((id, data, data_len(content)))
}

fn data_len(bits: &[u8]) -> usize {
    bits[15..HEADER].iter().fold(0, |value, bit| value << 1 | usize::from(*bit)).min(8)
}
