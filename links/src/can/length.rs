//! [`Length`]: how many bits a frame takes at which bit rate, as it is or at worst.

use super::{
    bits::{Stuffer, TAIL, classic_crc, fd_crc_field, header, header_to_switch},
    frame::{Format, Frame, PayloadError},
    time::{Rates, Time},
};

/// Bits of a frame from SOF to the end of EOF, stuff bits included, in the three parts they are sent in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Length {
    /// At the nominal bit rate: SOF to BRS, or to the end of the CRC if there is no switch.
    pub head: u32,
    /// At the data bit rate: ESI to the end of the CRC; 0 without a switch.
    pub fast: u32,
    /// At the nominal bit rate again: CRC delimiter, acknowledgement slot and delimiter, EOF.
    pub tail: u32,
}

impl Length {
    /// Of this very frame: its own identifier, data and CRC decide on the stuff bits.
    pub fn actual(frame: &Frame) -> Self {
        let mut stuffer = Stuffer::new();
        let (value, width) = header(frame);
        match frame.format() {
            Format::Classic => {
                stuffer.push_all(value, width);
                frame.data().iter().for_each(|&byte| stuffer.push_all(u64::from(byte), 8));
                stuffer.push_all(u64::from(classic_crc(frame)), 15);
                let plain = width + 8 * frame.data().len() as u32 + 15;
                Length { head: plain + stuffer.count, fast: 0, tail: TAIL }
            }
            Format::Fd { bit_rate_switch } => {
                let to_switch = header_to_switch(frame.id().is_extended());
                stuffer.push_all(value >> (width - to_switch), to_switch);
                let head = to_switch + stuffer.count;
                let mut rest = width - to_switch + fd_crc_field(frame.data().len());
                stuffer.push_all(value, width - to_switch);
                frame.data().iter().for_each(|&byte| stuffer.push_all(u64::from(byte), 8));
                // After the very last bit comes a fixed stuff bit in place of a dynamic one.
                let stuffed = stuffer.count - u32::from(stuffer.stuffed);
                rest += 8 * frame.data().len() as u32 + to_switch + stuffed - head;
                Self::in_phases(bit_rate_switch, head, rest)
            }
        }
    }

    /// At most, whatever the identifier and the data.
    ///
    /// Classic, n bytes: `g + 8n + 10 + floor((g + 8n - 1) / 4)` bits with g = 34 (11-bit identifier) or 54 (29 bits);
    /// with the intermission of 3 bits these are 55 + 10n and 80 + 10n (Davis, Burns, Bril, Lukkien 2007).
    /// CAN FD: at most `floor((h - 1) / 4)` stuff bits in the h bits up to BRS, and `floor((d - 2) / 4)` in all d
    /// bits from SOF to the last data bit; as many as possible of them before the switch, where bits are longer.
    ///
    /// # Errors
    /// A payload the format cannot carry.
    pub fn worst(extended: bool, format: Format, bytes: usize) -> Result<Self, PayloadError> {
        format.dlc(bytes)?;
        let data = 8 * bytes as u32;
        Ok(match format {
            Format::Classic => {
                let exposed = if extended { 54 } else { 34 } + data;
                Length { head: exposed + (exposed - 1) / 4, fast: 0, tail: TAIL }
            }
            Format::Fd { bit_rate_switch } => {
                let before = header_to_switch(extended);
                // ESI and DLC follow the switch.
                let exposed = before + 5 + data;
                let stuffed = (exposed - 2) / 4;
                let stuffed_before = (before - 1) / 4;
                let head = before + stuffed_before;
                let rest = exposed - before + stuffed - stuffed_before + fd_crc_field(bytes);
                Self::in_phases(bit_rate_switch, head, rest)
            }
        })
    }

    fn in_phases(switch: bool, head: u32, rest: u32) -> Self {
        let (head, fast) = if switch { (head, rest) } else { (head + rest, 0) };
        Length { head, fast, tail: TAIL }
    }

    /// All bits, SOF to the end of EOF.
    pub fn bits(self) -> u32 {
        self.head + self.fast + self.tail
    }

    /// SOF to the end of EOF, without the intermission.
    pub fn duration(self, rates: Rates) -> Time {
        self.offset(self.bits(), rates)
    }

    /// Time from SOF to the end of the first `bits` bits.
    pub fn offset(self, bits: u32, rates: Rates) -> Time {
        let fast = bits.saturating_sub(self.head).min(self.fast);
        rates.bits(bits - fast) + Time::from(fast) * rates.data_bit
    }

    /// How many bits have begun before `time` has passed since SOF.
    pub(super) fn begun_before(self, time: Time, rates: Rates) -> u32 {
        let head = rates.bits(self.head);
        let fast = Time::from(self.fast) * rates.data_bit;
        let bits = if time <= head {
            time.div_ceil(rates.bit)
        } else if time <= head + fast {
            Time::from(self.head) + (time - head).div_ceil(rates.data_bit)
        } else {
            Time::from(self.head + self.fast) + (time - head - fast).div_ceil(rates.bit)
        };
        bits.min(Time::from(self.bits())) as u32
    }
}
