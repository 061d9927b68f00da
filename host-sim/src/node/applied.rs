//! The applied input as a datagram: the wire between the actuator node and the plant node.
//!
//! On a machine this wire is copper. It is laid out like a frame of docs/wire-format.md, with a kind that is none of its
//! three, so that no receiver of frames takes it for one; docs/real-time.md has the table.

use crc::{CRC_32_ISCSI, Crc};
use slqg::{Age, Tick};

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);
const VERSION: u8 = 1;
const KIND: u8 = 128;
const SCALAR: u8 = 8;
const HEADER: usize = 9;
/// Stands for the default input, as in acknowledgements.
const DEFAULT_INPUT: u8 = u8::MAX;

/// What the actuator applies in a cycle.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedInput {
    /// The cycle.
    pub tick: Tick,
    /// Where the input came from. Copper does not tell; here it lets the plant know that it is controlled.
    pub age: Age,
    /// The inputs after saturation, in input units; at most 255 count.
    pub input: Vec<f64>,
}

impl AppliedInput {
    /// As bytes.
    pub fn encode(&self) -> Vec<u8> {
        let count = u8::try_from(self.input.len()).unwrap_or(u8::MAX);
        let mut bytes = vec![VERSION, KIND, SCALAR];
        bytes.extend(self.tick.0.to_le_bytes());
        bytes.push(match self.age {
            Age::Steps(steps) => steps,
            Age::Empty => DEFAULT_INPUT,
        });
        bytes.push(count);
        bytes.extend(self.input.iter().take(usize::from(count)).flat_map(|value| value.to_le_bytes()));
        bytes.extend(CHECKSUM.checksum(&bytes).to_le_bytes());
        bytes
    }

    /// From bytes; `None` unless they are an undamaged datagram of this version with finite inputs.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let (content, checksum) = bytes.split_last_chunk::<4>()?;
        if CHECKSUM.checksum(content) != u32::from_le_bytes(*checksum) {
            return None;
        }
        let (header, values) = content.split_at_checked(HEADER)?;
        let [VERSION, KIND, SCALAR, t0, t1, t2, t3, age, count] = *header else { return None };
        if values.len() != 8 * usize::from(count) {
            return None;
        }
        let value = |bytes: &[u8]| bytes.try_into().ok().map(f64::from_le_bytes);
        let input: Vec<f64> = values.chunks_exact(8).filter_map(value).collect();
        let tick = Tick(u32::from_le_bytes([t0, t1, t2, t3]));
        let age = if age == DEFAULT_INPUT { Age::Empty } else { Age::Steps(age) };
        input.iter().all(|value| value.is_finite()).then_some(Self { tick, age, input })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> AppliedInput {
        AppliedInput { tick: Tick(0x0102_0304), age: Age::Steps(2), input: vec![1.0, -2.5] }
    }

    #[test]
    fn the_bytes_are_those_of_the_page() {
        let bytes = example().encode();
        assert_eq!(bytes[..9], [1, 128, 8, 4, 3, 2, 1, 2, 2]);
        assert_eq!(bytes[9..25], [0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0, 0, 0, 0, 0, 0x04, 0xc0]);
        assert_eq!(bytes.len(), 29);
        assert_eq!(AppliedInput::decode(&bytes), Some(example()));
    }

    #[test]
    fn damaged_and_shortened_datagrams_are_refused() {
        let bytes = example().encode();
        for place in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 0x10;
            assert_eq!(AppliedInput::decode(&damaged), None, "byte {place}");
            assert_eq!(AppliedInput::decode(&bytes[..place]), None, "{place} bytes");
        }
    }

    #[test]
    fn inputs_that_are_not_finite_are_refused() {
        let wrong = AppliedInput { input: vec![f64::NAN], ..example() };
        assert_eq!(AppliedInput::decode(&wrong.encode()), None);
    }
}
