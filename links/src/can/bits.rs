//! The bits of a frame as the bus sees them, CRC and stuff bits included (ISO 11898-1:2015). Not how long they last.

use super::frame::{Format, Frame};
use crc::{CRC_15_CAN, CRC_17_CAN_FD, CRC_21_CAN_FD, Crc};

/// CRC delimiter, acknowledgement slot, acknowledgement delimiter, end of frame: never stuffed.
pub(super) const TAIL: u32 = 1 + 1 + 1 + 7;
/// Longest payload, in bytes, that CRC-17 covers; above it is CRC-21.
const CRC_17_BYTES: usize = 16;
/// Bits of the stuff bit count with its parity.
const STUFF_COUNT: u32 = 4;

static CRC_15: Crc<u16> = Crc::<u16>::new(&CRC_15_CAN);
static CRC_17: Crc<u32> = Crc::<u32>::new(&CRC_17_CAN_FD);
static CRC_21: Crc<u32> = Crc::<u32>::new(&CRC_21_CAN_FD);

/// Dynamic bit stuffing: after five equal bits, stuff bits included, follows one of the other value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stuffer {
    last: u8,
    run: u8,
    /// Whether a stuff bit follows the last bit.
    pub(super) stuffed: bool,
    /// Stuff bits so far.
    pub(super) count: u32,
}

impl Stuffer {
    /// Before SOF: the bus is recessive, and no earlier bit counts.
    pub(super) fn new() -> Self {
        Stuffer { last: 1, run: 0, stuffed: false, count: 0 }
    }

    /// Sends one bit; true if a stuff bit of the other value follows.
    pub(super) fn push(&mut self, bit: bool) -> bool {
        // Without branches: the bits of real payloads cannot be predicted.
        let bit = u8::from(bit);
        let run = if bit == self.last { self.run + 1 } else { 1 };
        self.stuffed = run == 5;
        self.count += u32::from(self.stuffed);
        self.last = bit ^ u8::from(self.stuffed);
        self.run = if self.stuffed { 1 } else { run };
        self.stuffed
    }

    /// Sends the low `width` bits of `value`, highest first.
    pub(super) fn push_all(&mut self, value: u64, width: u32) {
        for place in (0..width).rev() {
            self.push(value >> place & 1 == 1);
        }
    }
}

/// From SOF to DLC, without stuff bits: value and number of bits.
pub(super) fn header(frame: &Frame) -> (u64, u32) {
    let id = u64::from(frame.id().value());
    let dlc = u64::from(frame.dlc());
    // SOF is the leading 0. Data frames only: RTR (in FD: RRS) is 0.
    let (value, width) = match frame.id().is_extended() {
        // ID, RTR, IDE
        false => (id << 2, 1 + 11 + 2),
        // first 11 bits of ID, SRR, IDE, 18 bits of ID, RTR
        true => ((id >> 18) << 21 | 0b11 << 19 | (id & 0x3_FFFF) << 1, 1 + 11 + 2 + 18 + 1),
    };
    match frame.format() {
        // r0; an extended frame has r1 too
        Format::Classic if frame.id().is_extended() => (value << 6 | dlc, width + 6),
        Format::Classic => (value << 5 | dlc, width + 5),
        // FDF 1, res 0, BRS, ESI 0 (error active)
        Format::Fd { bit_rate_switch } => {
            let control = 0b1000 | u64::from(bit_rate_switch) << 1;
            (value << 8 | control << 4 | dlc, width + 8)
        }
    }
}

/// Bits of the header up to BRS, which are sent at the nominal bit rate in any case.
pub(super) fn header_to_switch(extended: bool) -> u32 {
    if extended { 36 } else { 17 }
}

/// Bits from the stuff bit count to the end of the CRC, fixed stuff bits included: one before every four bits.
pub(super) fn fd_crc_field(bytes: usize) -> u32 {
    let plain = STUFF_COUNT + fd_crc_width(bytes);
    plain + plain.div_ceil(4)
}

fn fd_crc_width(bytes: usize) -> u32 {
    if bytes <= CRC_17_BYTES { 17 } else { 21 }
}

/// CRC of a classical frame, over its unstuffed bits from SOF to the last data bit.
pub(super) fn classic_crc(frame: &Frame) -> u16 {
    let (header, _) = header(frame);
    let start = u128::from(header);
    let body = frame.data().iter().fold(start, |bits, &byte| bits << 8 | u128::from(byte));
    // The register starts at 0, so the leading zeros that fill up to whole bytes change nothing.
    CRC_15.checksum(&body.to_be_bytes())
}

/// Every bit on the bus from SOF to the end of EOF; true is recessive. The acknowledgement slot is dominant.
pub fn bits(frame: &Frame) -> Vec<bool> {
    let mut line = Vec::new();
    let mut stuffer = Stuffer::new();
    let mut send = |value: u64, width: u32| {
        for place in (0..width).rev() {
            let bit = value >> place & 1 == 1;
            line.push(bit);
            if stuffer.push(bit) {
                line.push(!bit);
            }
        }
    };
    let (value, width) = header(frame);
    send(value, width);
    frame.data().iter().for_each(|&byte| send(u64::from(byte), 8));
    match frame.format() {
        Format::Classic => send(u64::from(classic_crc(frame)), 15),
        Format::Fd { .. } => finish_fd(&mut line, stuffer, frame.data().len()),
    }
    // CRC delimiter, acknowledgement slot and delimiter, EOF
    line.extend([true, false, true]);
    line.extend([true; 7]);
    line
}

/// Stuff bit count and CRC with fixed stuff bits, after header and data as sent.
fn finish_fd(line: &mut Vec<bool>, stuffer: Stuffer, bytes: usize) {
    let mut count = stuffer.count;
    // Five equal bits at the very end of the data: the fixed stuff bit takes the place of the dynamic one.
    if stuffer.stuffed {
        line.pop();
        count -= 1;
    }
    let count = count % 8;
    let gray = count ^ (count >> 1);
    let counted = (gray << 1) | (gray.count_ones() % 2);
    let mut covered = line.clone();
    covered.extend((0..STUFF_COUNT).rev().map(|place| counted >> place & 1 == 1));
    // The register starts with its highest bit set, which is the same as a recessive SOF and a register of zeros.
    covered[0] = true;
    let width = fd_crc_width(bytes);
    let crc =
        if width == 17 { CRC_17.checksum(&packed(&covered)) } else { CRC_21.checksum(&packed(&covered)) };
    let field = u64::from(counted) << width | u64::from(crc);
    for (index, place) in (0..STUFF_COUNT + width).rev().enumerate() {
        if index % 4 == 0 {
            line.push(!line[line.len() - 1]);
        }
        line.push(field >> place & 1 == 1);
    }
}

/// Bits to bytes, filled up with zeros in front.
fn packed(bits: &[bool]) -> Vec<u8> {
    let mut bytes = vec![0; bits.len().div_ceil(8)];
    let places = bytes.len() * 8;
    for (index, _) in bits.iter().enumerate().filter(|&(_, &bit)| bit) {
        let place = places - bits.len() + index;
        bytes[place / 8] |= 0x80 >> (place % 8);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_four_after_one_of_five_reach_the_formula_of_the_worst_case() {
        for bits in 1..=600u32 {
            let mut stuffer = Stuffer::new();
            for index in 0..bits {
                // 00000 1111 0000 1111: every stuff bit is the first of the next five.
                stuffer.push(index > 0 && (index - 1) / 4 % 2 == 1);
            }
            assert_eq!(stuffer.count, (bits - 1) / 4, "{bits} bits");
        }
    }
}
