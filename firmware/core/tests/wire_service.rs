//! Frames between a node and its host are the bytes that `docs/wire-format.md` says, and read back as what was written.

use proptest::prelude::*;
use slqg::actuator::Applied;
use slqg::nalgebra::SVector;
use slqg::wire::{
    Clock, DecodeError, GainsAnswer, GainsPart, Kind, LONGEST_SERVICE, Question, Ran, Reference, Role,
    Service, Status, Tuned, TuningStep, Verdict, applied_len, decode_applied, decode_gains_part,
    decode_reference, decode_service, encode_applied, encode_gains_part, encode_reference, encode_service,
    gains_part_len, reference_len,
};
use slqg::{Age, Tick};
use std::fmt::Debug;

/// Checks the bytes before the checksum, and that they are read back.
fn golden<S: Service + PartialEq + Debug + Copy>(tick: Tick, service: S, expected: &[u8]) {
    let mut buffer = [0; LONGEST_SERVICE];
    let frame = encode_service::<f32, S>(tick, &service, &mut buffer).expect("there is room");
    assert_eq!(&frame[..frame.len() - 4], expected, "{service:?}");
    assert_eq!(Kind::of(frame), Some(S::KIND));
    assert_eq!(decode_service::<f32, S>(frame), Ok((tick, service)));
    assert_eq!(decode_service::<f64, S>(frame), Err(DecodeError::Scalar(4)), "of another loop");
    for len in 0..frame.len() {
        assert!(decode_service::<f32, S>(&frame[..len]).is_err(), "{len} bytes of {service:?}");
    }
}

#[test]
fn frames_of_fixed_length_are_the_golden_bytes() {
    let tick = Tick(0x0403_0201);
    golden(tick, Clock { begins: true, period_us: 20_000 }, &[1, 4, 4, 1, 2, 3, 4, 1, 0x20, 0x4e, 0, 0]);
    golden(tick, Ran { sent: true, duration: 0x0102_0304 }, &[1, 6, 4, 1, 2, 3, 4, 1, 4, 3, 2, 1]);
    let answer = GainsAnswer { received: 0x0102, verdict: Verdict::Design };
    golden(tick, answer, &[1, 8, 4, 1, 2, 3, 4, 2, 1, 5]);
    golden(tick, Question {}, &[1, 10, 4, 1, 2, 3, 4]);
    let tuned = Tuned { step: TuningStep::Switched, steps: 0x0102, value: 0.5 };
    golden(tick, tuned, &[1, 12, 4, 1, 2, 3, 4, 1, 2, 1, 0, 0, 0, 0, 0, 0x3f]);
    let status = Status {
        role: Role::Actuator,
        cycles: 1,
        realigned: 2,
        rejected: 3,
        overruns: 4,
        stack: 0x0102_0304,
        variables: 6,
    };
    let counts = [1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 0, 4, 3, 2, 1, 6, 0, 0, 0];
    golden(tick, status, &[&[1, 11, 4, 1, 2, 3, 4, 1], &counts[..]].concat());
}

/// The frame of these bytes before the checksum.
fn sealed(content: &[u8]) -> Vec<u8> {
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI).checksum(content);
    [content, &checksum.to_le_bytes()].concat()
}

/// The values of one byte of a payload with which the frame is read; all others are refused, and each is written as it was read.
fn values<S: Service>(service: S, at: usize) -> Vec<u8> {
    let mut buffer = [0; LONGEST_SERVICE];
    let frame = encode_service::<f32, S>(Tick(1), &service, &mut buffer).expect("there is room").to_vec();
    let read = |value: u8| {
        let mut content = frame[..frame.len() - 4].to_vec();
        content[7 + at] = value;
        let altered = sealed(&content);
        match decode_service::<f32, S>(&altered) {
            Ok((tick, service)) => {
                let mut buffer = [0; LONGEST_SERVICE];
                assert_eq!(encode_service::<f32, S>(tick, &service, &mut buffer), Ok(&altered[..]));
                true
            }
            Err(error) => {
                assert_eq!(error, DecodeError::Value, "{value}");
                false
            }
        }
    };
    (0..=u8::MAX).filter(|value| read(*value)).collect()
}

#[test]
fn a_value_that_a_field_cannot_have_is_an_error_and_never_another_value() {
    assert_eq!(values(Clock { begins: true, period_us: 1 }, 0), [0, 1]);
    assert_eq!(values(Ran { sent: true, duration: 1 }, 0), [0, 1]);
    let answer = GainsAnswer { received: 1, verdict: Verdict::InForce };
    assert_eq!(values(answer, 2), [0, 1, 2, 3, 4, 5, 6, 7]);
    let tuned = Tuned { step: TuningStep::Kept, steps: 1, value: 0.0 };
    assert_eq!(values(tuned, 0), [0, 1, 2]);
    let status = Status {
        role: Role::Actuator,
        cycles: 1,
        realigned: 0,
        rejected: 0,
        overruns: 0,
        stack: 0,
        variables: 0,
    };
    assert_eq!(values(status, 0), [0, 1]);
    // A byte more that would make a longer spelling of the same number.
    let longer = sealed(&[1, 8, 4, 1, 0, 0, 0, 1, 0, 0x81, 0]);
    assert_eq!(decode_service::<f32, GainsAnswer>(&longer).map(|_| ()), Err(DecodeError::Value));
}

#[test]
fn what_was_applied_is_read_back_with_its_age() {
    let applied = |age| Applied { tick: Tick(7), input: SVector::from([1.5_f32, -2.0]), age };
    let mut buffer = [0; applied_len(2, 4)];
    let frame = encode_applied(&applied(Age::Steps(3)), &mut buffer).expect("there is room");
    assert_eq!(frame[..frame.len() - 4], [1, 5, 4, 7, 0, 0, 0, 3, 2, 0, 0, 0xc0, 0x3f, 0, 0, 0, 0xc0]);
    assert_eq!(decode_applied::<f32, 2>(frame), Ok(applied(Age::Steps(3))));
    assert_eq!(decode_applied::<f32, 1>(frame), Err(DecodeError::Dimension(2)));
    let frame = encode_applied(&applied(Age::Empty), &mut buffer).expect("there is room");
    assert_eq!(decode_applied::<f32, 2>(frame), Ok(applied(Age::Empty)));
}

#[test]
fn a_part_of_a_blob_is_its_place_and_its_bytes() {
    let part = GainsPart { transfer: 9, offset: 0x0102, total: 0x0304, bytes: b"slqg" };
    let mut buffer = [0; gains_part_len(4)];
    let frame = encode_gains_part::<f32>(&part, &mut buffer).expect("it is as long as it says");
    assert_eq!(frame[..frame.len() - 4], [1, 7, 4, 9, 0, 0, 0, 2, 1, 4, 3, b's', b'l', b'q', b'g']);
    assert_eq!(decode_gains_part::<f32>(frame), Ok(part));
}

#[test]
fn samples_are_read_back_up_to_what_the_receiver_holds() {
    let samples = [[1.0_f32], [2.0], [3.0]].into_iter().map(SVector::from).collect();
    let reference = Reference::<f32, 1, 4> { tick: Tick(5), samples };
    let mut buffer = [0; reference_len(1, 3, 4)];
    let frame = encode_reference(&reference, &mut buffer).expect("it is as long as it says");
    assert_eq!(frame[..9], [1, 9, 4, 5, 0, 0, 0, 1, 3]);
    assert_eq!(decode_reference::<f32, 1, 4>(frame), Ok(reference));
    assert_eq!(decode_reference::<f32, 1, 2>(frame), Err(DecodeError::Capacity(3)));
    assert_eq!(decode_reference::<f32, 2, 4>(frame), Err(DecodeError::Dimension(1)));
}

proptest! {
    /// No bytes make a decoder panic, and none but the encoder's pass: a frame of random bytes has no fitting checksum.
    #[test]
    fn random_bytes_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..80)) {
        prop_assert!(decode_service::<f32, Clock>(&bytes).is_err());
        prop_assert!(decode_service::<f32, Status>(&bytes).is_err());
        prop_assert!(decode_applied::<f32, 2>(&bytes).is_err());
        prop_assert!(decode_gains_part::<f32>(&bytes).is_err());
        prop_assert!(decode_reference::<f32, 1, 4>(&bytes).is_err());
        let _ = Kind::of(&bytes);
    }
}
