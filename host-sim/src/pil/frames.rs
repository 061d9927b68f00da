//! Frames of a size class to frames of the design's own dimensions and back: nodes on boards are not padded.
//!
//! Padded outputs and inputs are zero, so that nothing is lost. What is inside of a frame is [`slqg::wire`]'s.

use crc::{CRC_32_ISCSI, Crc};
use slqg::wire::{Kind, VERSION};

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);
const HEADER: usize = 7;
const CHECKSUM_BYTES: usize = 4;

/// A design's own dimensions, and the padded ones.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dimensions {
    /// Bytes of a number.
    pub(super) scalar: usize,
    /// Inputs: the design's own, and padded.
    pub(super) inputs: [usize; 2],
    /// Outputs likewise.
    pub(super) outputs: [usize; 2],
}

/// Why a frame that came from a node is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a frame from the node is damaged, or has other dimensions than the design")]
pub(super) struct Damaged;

impl Dimensions {
    /// A frame that the controller takes, in its own dimensions.
    pub(super) fn for_controller(self, frame: &[u8]) -> Vec<u8> {
        match Kind::of(frame) {
            Some(Kind::Measurement) => {
                let [own, _] = self.outputs;
                let values = &frame[HEADER + 1..][..own * self.scalar];
                sealed(&[&frame[..HEADER], &[own as u8], values])
            }
            // An acknowledgement has no dimension.
            _ => frame.to_vec(),
        }
    }

    /// A control frame from the controller, padded.
    pub(super) fn of_controller(self, frame: &[u8]) -> Result<Vec<u8>, Damaged> {
        let [own, padded] = self.inputs;
        let (head, values) = opened(frame)?.split_at_checked(HEADER + 2).ok_or(Damaged)?;
        let length = usize::from(head[HEADER + 1]);
        if usize::from(head[HEADER]) != own || values.len() != own * length * self.scalar {
            return Err(Damaged);
        }
        let zeros = vec![0; (padded - own) * self.scalar];
        let mut parts = vec![&head[..HEADER], &[][..]];
        let dimensions = [padded as u8, length as u8];
        parts[1] = &dimensions;
        for input in values.chunks_exact(own * self.scalar) {
            parts.extend([input, &zeros]);
        }
        Ok(sealed(&parts))
    }

    /// A control frame, padded, as the actuator takes it.
    pub(super) fn for_actuator(self, frame: &[u8]) -> Vec<u8> {
        let [own, padded] = self.inputs;
        let length = frame[HEADER + 1];
        let mut content = frame[..HEADER].to_vec();
        content.extend([own as u8, length]);
        let values = &frame[HEADER + 2..frame.len() - CHECKSUM_BYTES];
        for input in values.chunks_exact(padded * self.scalar) {
            content.extend(&input[..own * self.scalar]);
        }
        sealed(&[&content])
    }

    /// What a frame says was applied, padded.
    pub(super) fn of_actuator(self, frame: &[u8]) -> Result<Vec<u8>, Damaged> {
        let [own, padded] = self.inputs;
        let (head, values) = opened(frame)?.split_at_checked(HEADER + 2).ok_or(Damaged)?;
        if usize::from(head[HEADER + 1]) != own || values.len() != own * self.scalar {
            return Err(Damaged);
        }
        let zeros = vec![0; (padded - own) * self.scalar];
        Ok(sealed(&[&head[..=HEADER], &[padded as u8], values, &zeros]))
    }

    /// Samples of the reference for the cycles from `tick` on, each of `outputs` numbers, as their bytes.
    pub(super) fn reference(self, tick: u32, outputs: usize, samples: &[Vec<u8>]) -> Vec<u8> {
        let head = [VERSION, Kind::Reference as u8, self.scalar as u8];
        let mut content = [&head[..], &tick.to_le_bytes(), &[outputs as u8, samples.len() as u8]].concat();
        content.extend(samples.concat());
        sealed(&[&content])
    }
}

/// The parts with the checksum that fits them.
fn sealed(parts: &[&[u8]]) -> Vec<u8> {
    let mut frame = parts.concat();
    frame.extend(CHECKSUM.checksum(&frame).to_le_bytes());
    frame
}

/// What the checksum covers, if it fits.
fn opened(frame: &[u8]) -> Result<&[u8], Damaged> {
    let (content, checksum) = frame.split_last_chunk::<CHECKSUM_BYTES>().ok_or(Damaged)?;
    (CHECKSUM.checksum(content) == u32::from_le_bytes(*checksum)).then_some(content).ok_or(Damaged)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SVector;
    use slqg::{Age, actuator::Applied};
    use slqg::{Tick, sequence::ControlSequence, wire, wire::Measurement};

    const DIMENSIONS: Dimensions = Dimensions { scalar: 4, inputs: [1, 2], outputs: [1, 2] };

    #[test]
    fn a_measurement_loses_its_padding() {
        let (mut padded, mut own) = ([0; 64], [0; 64]);
        let output = SVector::from([1.5_f32, 0.0]);
        let padded = wire::encode_measurement(&Measurement { tick: Tick(7), output }, &mut padded).unwrap();
        let output = SVector::from([1.5_f32]);
        let own = wire::encode_measurement(&Measurement { tick: Tick(7), output }, &mut own).unwrap();
        assert_eq!(DIMENSIONS.for_controller(padded), own);
    }

    #[test]
    fn a_control_frame_is_padded_and_loses_its_padding_again() {
        let inputs = [[1.0_f32], [2.0], [3.0]].map(SVector::from);
        let mut own = [0; 64];
        let sequence = ControlSequence { tick: Tick(9), inputs: &inputs };
        let own = wire::encode_control(&sequence, &mut own).unwrap();
        let padded = DIMENSIONS.of_controller(own).unwrap();
        let mut room = [SVector::<f32, 2>::zeros(); 4];
        let sequence = wire::decode_control(&padded, &mut room).unwrap();
        assert_eq!(sequence.inputs[2], SVector::from([3.0, 0.0]));
        assert_eq!(DIMENSIONS.for_actuator(&padded), own);
        let mut damaged = own.to_vec();
        damaged[10] ^= 1;
        assert_eq!(DIMENSIONS.of_controller(&damaged), Err(Damaged));
    }

    #[test]
    fn what_was_applied_is_padded() {
        let applied = Applied { tick: Tick(3), input: SVector::from([-1.0_f32]), age: Age::Steps(2) };
        let mut own = [0; 64];
        let own = wire::encode_applied(&applied, &mut own).unwrap();
        let padded = wire::decode_applied::<f32, 2>(&DIMENSIONS.of_actuator(own).unwrap()).unwrap();
        assert_eq!(padded.input, SVector::from([-1.0, 0.0]));
        assert_eq!(padded.age, Age::Steps(2));
    }

    #[test]
    fn samples_of_the_reference_are_as_the_core_reads_them() {
        let samples = [1.0_f32, 2.0].map(|value| value.to_le_bytes().to_vec());
        let frame = DIMENSIONS.reference(5, 1, &samples);
        let reference = wire::decode_reference::<f32, 1, 4>(&frame).unwrap();
        assert_eq!(reference.tick, Tick(5));
        assert_eq!(reference.samples.as_slice(), [SVector::from([1.0]), SVector::from([2.0])]);
    }
}
