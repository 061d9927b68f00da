//! A full frame in a CAN FD frame: padded to a length that CAN FD has, and cut to what it was.

use nalgebra::SVector;
use proptest::prelude::*;
use slqg::wire::can::{FD_CAPACITY, fd_len, pad, unpad};
use slqg::wire::{
    Acknowledgement, MOST_AGES, Measurement, encode_acknowledgement, encode_control, encode_measurement,
    frame_len,
};
use slqg::{Age, Scalar, Tick, nalgebra, sequence::ControlSequence};

/// As in the wire page: a control frame of three inputs, 25 bytes, and zeros.
const PADDED: [u8; 32] = [
    0x01, 0x02, 0x04, 0xff, 0xff, 0xff, 0xff, 0x01, 0x03, 0x00, 0x00, 0x00, 0x3f, 0x00, 0x00, 0x80, 0xbf,
    0xcd, 0xcc, 0xcc, 0x3d, 0xb6, 0xa0, 0x1e, 0x01, 0, 0, 0, 0, 0, 0, 0,
];
/// As in the wire page: an acknowledgement of one cycle.
const ACKNOWLEDGEMENT: [u8; 12] = [0x01, 0x03, 0x04, 0x00, 0x00, 0x01, 0x00, 0x02, 0x0b, 0x6f, 0x9e, 0x8b];

fn control<T: Scalar>(tick: Tick, length: usize) -> Vec<u8> {
    let inputs: Vec<_> = (0..length).map(|at| SVector::from([T::nearest(at as f64 / 3.0)])).collect();
    encode_control(&ControlSequence { tick, inputs: &inputs }, &mut [0; 512]).expect("room").to_vec()
}

fn measurement<T: Scalar, const NY: usize>(tick: Tick) -> Vec<u8> {
    let output = SVector::<T, NY>::from_fn(|at, _| T::nearest(at as f64));
    encode_measurement(&Measurement { tick, output }, &mut [0; 512]).expect("room").to_vec()
}

fn acknowledgement(tick: Tick, ages: &[u8]) -> Vec<u8> {
    let ages = ages.iter().map(|&age| if age == 255 { Age::Empty } else { Age::Steps(age) }).collect();
    encode_acknowledgement::<f32>(&Acknowledgement { tick, ages }, &mut [0; 64]).expect("room").to_vec()
}

#[test]
fn frames_are_padded_to_the_lengths_of_can_fd() {
    let lengths: Vec<_> = (0..=64).map(|len| fd_len(len).unwrap()).collect();
    let mut distinct = lengths.clone();
    distinct.dedup();
    assert_eq!(distinct, [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64]);
    assert!((0..=64).zip(&lengths).all(|(len, &padded)| len <= padded));
    assert_eq!(fd_len(65), None);
    assert_eq!(pad(&[0; 65], &mut [0; FD_CAPACITY]), None);
}

#[test]
fn a_padded_frame_is_the_bytes_of_the_wire_page() {
    let mut buffer = [0xaa; FD_CAPACITY];
    assert_eq!(pad(&PADDED[..25], &mut buffer), Some(&PADDED[..]));
    assert_eq!(unpad(&PADDED), Some(&PADDED[..25]));
    assert_eq!(pad(&ACKNOWLEDGEMENT, &mut buffer), Some(&ACKNOWLEDGEMENT[..]));
    assert_eq!(unpad(&ACKNOWLEDGEMENT), Some(&ACKNOWLEDGEMENT[..]));
}

fn survives(frame: &[u8]) {
    let mut buffer = [0xaa; FD_CAPACITY];
    let data = pad(frame, &mut buffer).unwrap();
    assert_eq!(unpad(data), Some(frame), "{frame:x?}");
}

#[test]
fn every_frame_that_fits_comes_out_as_it_went_in() {
    for tick in [0, 1, 0x0102_0304, u32::MAX].map(Tick) {
        (1..=12).for_each(|length| survives(&control::<f32>(tick, length)));
        (1..=6).for_each(|length| survives(&control::<f64>(tick, length)));
        survives(&measurement::<f32, 1>(tick));
        survives(&measurement::<f32, 13>(tick));
        survives(&measurement::<f64, 6>(tick));
    }
    assert_eq!(pad(&control::<f32>(Tick(0), 13), &mut [0; FD_CAPACITY]), None);
}

#[test]
fn the_end_of_an_acknowledgement_is_found_though_it_has_no_count() {
    for tick in (0..20_000).map(|cycle| Tick(cycle * 214_748)) {
        for ages in 1..=MOST_AGES {
            // Zeros before the checksum look most like padding.
            survives(&acknowledgement(tick, &[0; MOST_AGES][..ages]));
            survives(&acknowledgement(tick, &[255; MOST_AGES][..ages]));
        }
    }
}

#[test]
fn zeros_behind_an_acknowledgement_never_look_like_a_part_of_it() {
    // Whether a checksum fits after zeros does not depend on the frame before them: CRCs are linear.
    for ages in 1..=MOST_AGES {
        let frame = acknowledgement(Tick(77), &[3; MOST_AGES][..ages]);
        for zeros in 0..=MOST_AGES {
            let padded = [&frame[..], &[0; MOST_AGES][..zeros]].concat();
            assert_eq!(frame_len(&padded), Some(frame.len()), "{zeros} zeros");
        }
    }
}

#[test]
fn an_acknowledgement_that_begins_with_another_is_not_cut_short() {
    // Four of its ages are the checksum that ends the other one.
    let other = acknowledgement(Tick(77), &[3]);
    let frame = acknowledgement(Tick(77), &other[7..]);
    assert_eq!((frame.len(), &frame[..12]), (16, &other[..]));
    survives(&frame);
}

#[test]
fn what_is_not_padded_with_zeros_to_the_next_length_is_no_frame() {
    let mut buffer = [0; FD_CAPACITY];
    let data = pad(&control::<f32>(Tick(7), 1), &mut buffer).unwrap().to_vec();
    assert!(unpad(&data).is_some());
    let mut dirty = data.clone();
    dirty[18] = 1;
    assert_eq!(unpad(&dirty), None);
    assert_eq!(unpad(&data[..17]), None, "17 bytes are no CAN FD frame");
    assert_eq!(unpad(&[&data[..], &[0; 4]].concat()), None, "24 bytes where 20 do");
    for at in 0..3 {
        let mut other = data.clone();
        other[at] ^= 0x10;
        assert_eq!(unpad(&other), None, "another header");
    }
    assert_eq!(frame_len(&data[..16]), None, "less than announced");
    assert_eq!((frame_len(&data), frame_len(&[])), (Some(17), None));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn garbage_never_panics(
        header in proptest::collection::vec(0_u8..10, 0..9),
        rest in proptest::collection::vec(any::<u8>(), 0..80),
    ) {
        let data = [&header[..], &rest[..]].concat();
        if let Some(frame) = unpad(&data) {
            prop_assert!(frame.len() <= data.len() && data.len() <= FD_CAPACITY);
        }
        prop_assert!(frame_len(&rest).is_none_or(|len| len <= rest.len()));
    }

    #[test]
    fn any_acknowledgement_comes_out_as_it_went_in(
        tick in any::<u32>(),
        ages in proptest::collection::vec(prop_oneof![Just(0_u8), any::<u8>()], 1..=MOST_AGES),
    ) {
        survives(&acknowledgement(Tick(tick), &ages));
    }
}
