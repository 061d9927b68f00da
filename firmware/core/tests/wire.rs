//! Frames are the bytes that `docs/wire-format.md` says, and nothing else passes for a frame.

mod lent;

use nalgebra::SVector;
use proptest::prelude::*;
use slqg::wire::{
    self, Acknowledgement, DecodeError, EncodeError, MOST_AGES, Measurement, decode_acknowledgement,
    decode_measurement, encode_acknowledgement, encode_control, encode_measurement,
};
use slqg::{Age, Scalar, Tick, nalgebra, sequence::ControlSequence};

type Sequence<T, const NU: usize> = ControlSequence<'static, T, NU>;

/// CRC-32/ISCSI bit by bit, as the wire page defines it.
fn checksum(content: &[u8]) -> u32 {
    !content.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0x82F6_3B78 } else { 0 })
    })
}

/// `content` with the checksum that fits.
fn sealed(content: &[u8]) -> Vec<u8> {
    [content, &checksum(content).to_le_bytes()].concat()
}

/// The bytes that a line of hexadecimal digits stands for.
fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).expect("two digits a byte")).collect()
}

fn measurement<T: Scalar>() -> Measurement<T, 2> {
    Measurement { tick: Tick(0x0102_0304), output: SVector::from([1.0, -2.5].map(T::nearest)) }
}

fn sequence<T: Scalar>() -> Sequence<T, 1> {
    let inputs = [0.5, -1.0, 0.1].map(|input| SVector::from([T::nearest(input)]));
    Sequence { tick: Tick(u32::MAX), inputs: inputs.to_vec().leak() }
}

/// What acknowledgements say of cycle 0x00010000 and those before it.
fn acknowledgement(ages: &[Age]) -> Acknowledgement {
    Acknowledgement { tick: Tick(0x0001_0000), ages: ages.iter().copied().collect() }
}

fn played() -> Acknowledgement {
    acknowledgement(&[Age::Steps(2)])
}

fn defaulted() -> Acknowledgement {
    acknowledgement(&[Age::Empty])
}

/// A sequence that has just come, the default input before it, and the last input of an older one before that.
fn repeated() -> Acknowledgement {
    acknowledgement(&[Age::Steps(0), Age::Empty, Age::Steps(3)])
}

/// Measurement, control, and the three acknowledgements above.
fn golden<T: Scalar>() -> [Vec<u8>; 5] {
    let frames = if T::BYTES == 4 {
        [
            "01 01 04 04 03 02 01 02 00 00 80 3f 00 00 20 c0 ce 4f 84 46",
            "01 02 04 ff ff ff ff 01 03 00 00 00 3f 00 00 80 bf cd cc cc 3d b6 a0 1e 01",
            "01 03 04 00 00 01 00 02 0b 6f 9e 8b",
            "01 03 04 00 00 01 00 ff ad 4c d8 c7",
            "01 03 04 00 00 01 00 00 ff 03 51 bd 9b 98",
        ]
    } else {
        [
            "01 01 08 04 03 02 01 02 00 00 00 00 00 00 f0 3f 00 00 00 00 00 00 04 c0 54 e1 ed b3",
            "01 02 08 ff ff ff ff 01 03 00 00 00 00 00 00 e0 3f 00 00 00 00 00 00 f0 bf \
             9a 99 99 99 99 99 b9 3f f7 eb dc a8",
            "01 03 08 00 00 01 00 02 63 40 6d 59",
            "01 03 08 00 00 01 00 ff c5 63 2b 15",
            "01 03 08 00 00 01 00 00 ff 03 e6 3b bd fb",
        ]
    };
    frames.map(bytes)
}

/// The content of an acknowledgement frame of `count` different ages, however many they are.
fn acknowledgement_content(count: usize) -> Vec<u8> {
    let ages = (0..count).map(|age| age as u8);
    bytes("01 03 04 00 00 01 00").into_iter().chain(ages).collect()
}

/// Whether any receiver in this file takes `frame`.
fn anyone_takes<T: Scalar>(frame: &[u8]) -> bool {
    decode_measurement::<T, 2>(frame).is_ok()
        || lent::decoded::<T, 1>(frame, 4).is_ok()
        || decode_acknowledgement::<T>(frame).is_ok()
}

fn meets_golden_bytes_both_ways<T: Scalar>() {
    let [measured, controlled, acknowledged @ ..] = golden::<T>();
    let mut buffer = [0xAA; 64];
    assert_eq!(encode_measurement(&measurement::<T>(), &mut buffer), Ok(&measured[..]));
    assert_eq!(encode_control(&sequence::<T>(), &mut buffer), Ok(&controlled[..]));
    assert_eq!(decode_measurement(&measured), Ok(measurement::<T>()));
    assert_eq!(lent::decoded(&controlled, 4), Ok(sequence::<T>()));
    for (acknowledgement, frame) in [played(), defaulted(), repeated()].into_iter().zip(&acknowledged) {
        assert_eq!(encode_acknowledgement::<T>(&acknowledgement, &mut buffer), Ok(&frame[..]));
        assert_eq!(decode_acknowledgement::<T>(frame), Ok(acknowledgement));
    }
}

#[test]
fn golden_bytes_are_written_and_read() {
    meets_golden_bytes_both_ways::<f32>();
    meets_golden_bytes_both_ways::<f64>();
}

#[test]
fn inputs_stand_cycle_by_cycle() {
    let inputs = [SVector::from([1.0f32, 2.0]), SVector::from([3.0, 4.0])];
    let sequence = ControlSequence { tick: Tick(5), inputs: &inputs };
    let mut buffer = [0; 64];
    let frame = encode_control(&sequence, &mut buffer).expect("there is room");
    let content = "01 02 04 05 00 00 00 02 02 00 00 80 3f 00 00 00 40 00 00 40 40 00 00 80 40";
    assert_eq!(frame, sealed(&bytes(content)));
    assert_eq!(lent::decoded(frame, 2), Ok(sequence));
}

#[test]
fn checksum_is_crc_32_iscsi() {
    assert_eq!(checksum(b"123456789"), 0xE306_9283);
    for frame in golden::<f32>().iter().chain(&golden::<f64>()) {
        assert_eq!(*frame, sealed(&frame[..frame.len() - 4]));
    }
}

fn frames_are_as_long_as_announced<T: Scalar, const D: usize>() {
    let mut buffer = [0; 600];
    let output = SVector::<T, D>::repeat(T::one());
    let frame =
        encode_measurement(&Measurement { tick: Tick(7), output }, &mut buffer).expect("there is room");
    assert_eq!(frame.len(), wire::measurement_len(D, T::BYTES));
    for length in 0..=8 {
        let sequence = ControlSequence { tick: Tick(7), inputs: &vec![output; length] };
        let frame = encode_control(&sequence, &mut buffer).expect("there is room");
        assert_eq!(frame.len(), wire::control_len(D, length, T::BYTES));
    }
    for count in 1..=MOST_AGES {
        let acknowledgement = acknowledgement(&[Age::Empty; MOST_AGES][..count]);
        let frame = encode_acknowledgement::<T>(&acknowledgement, &mut buffer).expect("there is room");
        assert_eq!(frame.len(), wire::acknowledgement_len(count));
        assert!(frame.len() <= wire::LONGEST_ACKNOWLEDGEMENT);
    }
    assert_eq!(wire::LONGEST_ACKNOWLEDGEMENT, wire::acknowledgement_len(MOST_AGES));
}

#[test]
fn the_length_functions_tell_the_length_of_every_frame() {
    frames_are_as_long_as_announced::<f32, 1>();
    frames_are_as_long_as_announced::<f32, 3>();
    frames_are_as_long_as_announced::<f64, 2>();
    frames_are_as_long_as_announced::<f64, 8>();
}

#[test]
fn no_truncated_extended_or_bit_flipped_frame_is_taken() {
    fn check<T: Scalar>() {
        let mut longest = acknowledgement_content(MOST_AGES);
        longest[2] = T::BYTES;
        for frame in golden::<T>().into_iter().chain([sealed(&longest)]) {
            assert!(anyone_takes::<T>(&frame));
            for length in 0..frame.len() {
                assert!(!anyone_takes::<T>(&frame[..length]), "{length} bytes of {frame:02x?}");
            }
            for extra in [0x00, 0xFF] {
                assert!(!anyone_takes::<T>(&[&frame[..], &[extra]].concat()));
            }
            for bit in 0..frame.len() * 8 {
                let mut damaged = frame.clone();
                damaged[bit / 8] ^= 1 << (bit % 8);
                assert!(!anyone_takes::<T>(&damaged), "bit {bit} of {frame:02x?}");
            }
        }
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn every_reason_to_reject_a_frame_has_its_name() {
    let content = |edit: &dyn Fn(&mut Vec<u8>)| {
        let mut content = golden::<f32>()[1][..21].to_vec();
        edit(&mut content);
        sealed(&content)
    };
    let control = |edit: &dyn Fn(&mut Vec<u8>)| lent::decoded::<f32, 1>(&content(edit), 4);
    let put = |content: &mut Vec<u8>, at: usize, value: f32| {
        content[at..at + 4].copy_from_slice(&value.to_le_bytes());
    };
    assert_eq!(control(&|_| ()), Ok(sequence()));
    assert_eq!(lent::decoded::<f32, 1>(&[0; 10], 4), Err(DecodeError::TooShort));
    assert_eq!(lent::decoded::<f32, 1>(&[0; 25], 4), Err(DecodeError::Checksum));
    assert_eq!(control(&|content| content[0] = 2), Err(DecodeError::Version(2)));
    assert_eq!(control(&|content| content[1] = 3), Err(DecodeError::Kind(3)));
    assert_eq!(control(&|content| content[1] = 0), Err(DecodeError::Kind(0)));
    assert_eq!(control(&|content| content[2] = 8), Err(DecodeError::Scalar(8)));
    assert_eq!(control(&|content| content[7] = 2), Err(DecodeError::Dimension(2)));
    assert_eq!(control(&|content| content[8] = 5), Err(DecodeError::Capacity(5)), "whatever follows");
    assert_eq!(control(&|content| content[8] = 255), Err(DecodeError::Capacity(255)), "whatever follows");
    assert_eq!(control(&|content| content[8] = 4), Err(DecodeError::Length));
    assert_eq!(control(&|content| content[8] = 2), Err(DecodeError::Length));
    assert_eq!(control(&|content| content.push(0)), Err(DecodeError::Length));
    assert_eq!(control(&|content| content.truncate(8)), Err(DecodeError::Length));
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(control(&|content| put(content, 17, value)), Err(DecodeError::NotFinite));
    }
    let [measured, _, played, ..] = golden::<f32>();
    assert_eq!(decode_measurement::<f32, 3>(&measured), Err(DecodeError::Dimension(2)));
    assert_eq!(decode_measurement::<f64, 2>(&measured), Err(DecodeError::Scalar(4)));
    assert_eq!(decode_measurement::<f32, 2>(&played), Err(DecodeError::Kind(3)));
    assert_eq!(decode_acknowledgement::<f32>(&measured), Err(DecodeError::Kind(1)));
    let mut not_finite = measured[..16].to_vec();
    put(&mut not_finite, 8, f32::NAN);
    assert_eq!(decode_measurement::<f32, 2>(&sealed(&not_finite)), Err(DecodeError::NotFinite));
    for content in [&measured[..12], &[&measured[..16], &[0][..]].concat()] {
        assert_eq!(decode_measurement::<f32, 2>(&sealed(content)), Err(DecodeError::Length));
    }
    let acknowledgement =
        |count| decode_acknowledgement::<f32>(&sealed(&acknowledgement_content(count))).unwrap_err();
    assert_eq!(acknowledgement(0), DecodeError::Ages(0));
    assert_eq!(acknowledgement(MOST_AGES + 1), DecodeError::Ages(9));
    assert_eq!(acknowledgement(255), DecodeError::Ages(255));
    assert_eq!(acknowledgement(256), DecodeError::Ages(255), "as many as a byte holds");
}

#[test]
fn the_length_of_an_acknowledgement_tells_how_many_cycles_it_is_about() {
    let ages = [0, 1, 2, 3, 4, 5, 6, 7].map(Age::Steps);
    let mut buffer = [0; wire::LONGEST_ACKNOWLEDGEMENT];
    for count in 1..=MOST_AGES {
        let told = acknowledgement(&ages[..count]);
        let frame = sealed(&acknowledgement_content(count));
        assert_eq!(encode_acknowledgement::<f32>(&told, &mut buffer), Ok(&frame[..]));
        assert_eq!(decode_acknowledgement::<f32>(&frame), Ok(told));
    }
}

#[test]
fn an_acknowledgement_of_one_cycle_says_nothing_of_others() {
    assert_eq!(Acknowledgement::of(Tick(0x0001_0000), Age::Steps(2)), played());
}

#[test]
fn a_buffer_that_is_too_small_is_an_error() {
    let [measured, controlled, .., told] = golden::<f64>();
    let mut buffer = [0; 64];
    for room in 0..measured.len() {
        let outcome = encode_measurement(&measurement::<f64>(), &mut buffer[..room]);
        assert_eq!(outcome, Err(EncodeError::BufferTooSmall));
    }
    for room in 0..controlled.len() {
        let outcome = encode_control(&sequence::<f64>(), &mut buffer[..room]);
        assert_eq!(outcome, Err(EncodeError::BufferTooSmall));
    }
    for room in 0..told.len() {
        let outcome = encode_acknowledgement::<f64>(&repeated(), &mut buffer[..room]);
        assert_eq!(outcome, Err(EncodeError::BufferTooSmall));
    }
}

#[test]
fn what_one_byte_cannot_count_is_an_error() {
    let mut buffer = [0; 4096];
    let outputs = Measurement { tick: Tick(0), output: SVector::<f32, 256>::zeros() };
    assert_eq!(encode_measurement(&outputs, &mut buffer), Err(EncodeError::TooMany));
    let sequence = ControlSequence { tick: Tick(0), inputs: &[SVector::<f32, 1>::zeros(); 256] };
    assert_eq!(encode_control(&sequence, &mut buffer), Err(EncodeError::TooMany));
    for ages in [&[Age::Steps(255)][..], &[Age::Steps(254), Age::Steps(255)]] {
        let outcome = encode_acknowledgement::<f32>(&acknowledgement(ages), &mut buffer);
        assert_eq!(outcome, Err(EncodeError::TooMany));
    }
}

#[test]
fn an_acknowledgement_of_no_cycle_is_not_written() {
    let mut buffer = [0; 64];
    let outcome = encode_acknowledgement::<f32>(&acknowledgement(&[]), &mut buffer);
    assert_eq!(outcome, Err(EncodeError::NoAges));
}

/// Contents that get past the checksum, often past the header, and often with as many numbers as they say.
fn almost_valid_content() -> impl Strategy<Value = Vec<u8>> {
    let scalar = prop_oneof![4 => Just(4u8), 4 => Just(8), 1 => any::<u8>()];
    let header = (prop_oneof![9 => Just(1u8), 1 => any::<u8>()], 0u8..5, scalar, any::<[u8; 4]>());
    let noise = proptest::collection::vec(any::<u8>(), 300);
    let missing = prop_oneof![3 => Just(0usize), 1 => 0usize..4];
    let counts = (0u8..4, 0u8..6, 0..MOST_AGES + 4);
    (header, counts, missing, noise).prop_map(|(header, (dimension, length, ages), missing, noise)| {
        let (version, kind, scalar, tick) = header;
        let numbers = |count: u8| usize::from(count) * usize::from(scalar.min(8));
        let (counts, rest) = match kind {
            1 => (vec![dimension], numbers(dimension)),
            2 => (vec![dimension, length], numbers(dimension * length)),
            _ => (vec![], ages),
        };
        let payload = &noise[..rest.saturating_sub(missing)];
        [&[version, kind, scalar][..], &tick, &counts, payload].concat()
    })
}

/// What is taken must be written back as the very bytes that came: no two frames mean the same.
fn taken_frames_are_canonical<T: Scalar, const D: usize, const N: usize>(frame: &[u8]) {
    let mut buffer = [0; 512];
    if let Ok(measurement) = decode_measurement::<T, D>(frame) {
        assert!(measurement.output.iter().all(|value| value.is_finite()));
        assert_eq!(encode_measurement(&measurement, &mut buffer), Ok(frame));
    }
    if let Ok(sequence) = lent::decoded::<T, D>(frame, N) {
        assert!(sequence.is_finite());
        assert_eq!(encode_control(&sequence, &mut buffer), Ok(frame));
    }
    if let Ok(acknowledgement) = decode_acknowledgement::<T>(frame) {
        assert!((1..=MOST_AGES).contains(&acknowledgement.ages.len()));
        assert_eq!(encode_acknowledgement::<T>(&acknowledgement, &mut buffer), Ok(frame));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_are_no_frame(noise in proptest::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(!anyone_takes::<f32>(&noise) && !anyone_takes::<f64>(&noise));
    }

    #[test]
    fn whatever_passes_the_checksum_is_rejected_or_canonical(content in almost_valid_content()) {
        let frame = sealed(&content);
        taken_frames_are_canonical::<f32, 1, 4>(&frame);
        taken_frames_are_canonical::<f32, 2, 2>(&frame);
        taken_frames_are_canonical::<f64, 1, 5>(&frame);
        taken_frames_are_canonical::<f64, 3, 1>(&frame);
    }
}
