//! Compact CAN frames are the bytes that `docs/wire-format.md` says, and come out as the full frames that went in.

mod lent;

use embedded_can::Frame;
use nalgebra::SVector;
use proptest::prelude::*;
use slqg::wire::Kind;
use slqg::wire::can::{
    Check, Compact, Grid, Identifiers, InvalidCompact, LARGEST_OF_FULL_FRAME, PackError, UnpackError,
    compact_acknowledgement_len, compact_len, nearest_tick,
};
use slqg::wire::{
    Acknowledgement, DecodeError, EncodeError, Measurement, decode_acknowledgement, decode_measurement,
    encode_acknowledgement, encode_control, encode_measurement,
};
use slqg::{Age, Scalar, Tick, nalgebra, sequence::ControlSequence};

mod can_bus;

use can_bus::{BusFrame, DESIGN, compact, grid, identifiers, standard};

fn control<T: Scalar, const NU: usize>(tick: Tick, inputs: &[SVector<T, NU>]) -> Vec<u8> {
    encode_control(&ControlSequence { tick, inputs }, &mut [0; 256]).expect("room").to_vec()
}

fn measurement<T: Scalar, const NY: usize>(tick: Tick, output: [f64; NY]) -> Vec<u8> {
    let output = SVector::from(output.map(T::nearest));
    encode_measurement(&Measurement { tick, output }, &mut [0; 256]).expect("room").to_vec()
}

fn acknowledgement<T: Scalar>(tick: Tick, ages: &[Age]) -> Vec<u8> {
    let acknowledgement = Acknowledgement { tick, ages: ages.iter().copied().collect() };
    encode_acknowledgement::<T>(&acknowledgement, &mut [0; 64]).expect("room").to_vec()
}

fn packed<T: Scalar>(frame: &[u8]) -> Result<BusFrame, PackError> {
    compact::<T>().pack(frame)
}

/// A frame whose check is right for a receiver at `now`, whatever else is in it. `data`: all but the check.
fn checked(id: u16, data: &[u8], now: Tick) -> BusFrame {
    let kind = match id {
        0x120 => Kind::Measurement,
        0x121 => Kind::Control,
        _ => Kind::Acknowledgement,
    };
    let low = [0, 1].map(|place| data.get(place).copied().unwrap_or(0));
    let tick = nearest_tick(u16::from_le_bytes(low), now);
    let check = Check::new(DESIGN).of(kind, tick, data);
    BusFrame { id: standard(id), is_remote: false, data: [data, &[check]].concat() }
}

fn unpacked<T: Scalar>(frame: &BusFrame, now: Tick) -> Result<Vec<u8>, UnpackError> {
    compact::<T>().unpack(frame, now, &mut [0; 64]).map(<[u8]>::to_vec)
}

/// The input that `count` stands for.
fn input<T: Scalar>(count: i16) -> SVector<T, 1> {
    SVector::from([T::nearest(f64::from(count)) * (T::nearest(12.0) / T::nearest(4095.0))])
}

fn golden<T: Scalar>() {
    let ages = [Age::Steps(0), Age::Empty, Age::Steps(3)];
    for (full, id, data) in [
        (
            control::<T, 1>(Tick(0x0102_FFFF), &[input(1), input(-1), input(4095)]),
            0x121,
            vec![0xff, 0xff, 0x01, 0xe0, 0xff, 0xff, 0x3f, 0x29],
        ),
        (control::<T, 1>(Tick(0x0102_0304), &[input(-4095)]), 0x121, vec![0x04, 0x03, 0x01, 0xf0, 0xe3]),
        (
            control::<T, 1>(Tick(0x0102_0304), &[input(4095), input(-2)]),
            0x121,
            vec![0x04, 0x03, 0xff, 0x0f, 0xfe, 0xff, 0xc0],
        ),
        (
            measurement::<T, 2>(Tick(0x0102_0304), [1.0, -2.5]),
            0x120,
            vec![0x04, 0x03, 0x04, 0x00, 0x00, 0xf6, 0xf9],
        ),
        (acknowledgement::<T>(Tick(0x0001_0000), &ages), 0x122, vec![0x00, 0x00, 0x00, 0xff, 0x03, 0x62]),
    ] {
        let frame = BusFrame { id: standard(id), is_remote: false, data };
        assert_eq!(packed::<T>(&full), Ok(frame.clone()));
        let tick = Tick(u32::from_le_bytes([full[3], full[4], full[5], full[6]]));
        assert_eq!(unpacked::<T>(&frame, tick + 100).as_ref(), Ok(&full));
        assert_eq!(unpacked::<T>(&frame, tick - 100), Ok(full));
    }
}

#[test]
fn compact_frames_are_the_bytes_of_the_wire_page() {
    golden::<f32>();
    golden::<f64>();
}

fn every_count_survives<T: Scalar>() {
    for count in -4095_i16..=4095 {
        let frame = control::<T, 1>(Tick(70_000), &[input(count)]);
        let bus = packed::<T>(&frame).expect("one value");
        assert_eq!(bus.data[2..4], count.to_le_bytes());
        assert_eq!(unpacked::<T>(&bus, Tick(70_001)), Ok(frame), "{count}");
        let frame = control::<T, 1>(Tick(70_000), &[input(4095), input(count), input(-count)]);
        let bus = packed::<T>(&frame).expect("three values");
        assert_eq!(unpacked::<T>(&bus, Tick(70_001)), Ok(frame), "{count}");
    }
    for count in -32767_i16..=32767 {
        let frame = measurement::<T, 2>(Tick(70_000), [0.0, f64::from(count) / 1024.0]);
        let bus = packed::<T>(&frame).expect("two values");
        assert_eq!(bus.data[4..6], count.to_le_bytes());
        assert_eq!(unpacked::<T>(&bus, Tick(70_001)), Ok(frame), "{count}");
    }
}

#[test]
fn a_frame_is_as_long_as_its_values_and_ages_take() {
    assert_eq!([1, 2, 3].map(compact_len), [5, 7, 8]);
    assert_eq!([1, 5].map(compact_acknowledgement_len), [4, 8]);
}

#[test]
fn values_on_the_grid_come_out_to_the_bit() {
    every_count_survives::<f32>();
    every_count_survives::<f64>();
}

fn grids_find_their_own_counts<T: Scalar>(mantissa: f64, exponent: i32, count: i16) {
    let step = T::nearest(mantissa * 2f64.powi(exponent));
    let grid = Grid::<T, 1> { step: SVector::from([step]), largest_count: 32767 };
    if grid.is_valid() {
        let value = SVector::from([T::nearest(f64::from(count.max(-32767))) * step]);
        assert_eq!(grid.round(&value), value);
        assert!(value[0].is_finite());
    }
}

#[test]
fn rounding_goes_to_the_nearest_count_ties_away_from_zero_and_saturates() {
    let grid = Grid::<f32, 1> { step: SVector::from([0.5]), largest_count: 100 };
    for (value, rounded) in [
        (0.2, 0.0),
        (0.25, 0.5),
        (-0.25, -0.5),
        (0.74, 0.5),
        (49.8, 50.0),
        (51.0, 50.0),
        (-1e30, -50.0),
        (1e-40, 0.0),
    ] {
        assert_eq!(grid.round(&SVector::from([value])), SVector::from([rounded]), "{value}");
    }
    assert_eq!(grid.round(&SVector::from([-0.0]))[0].to_bits(), 0);
    assert!(grid.round(&SVector::from([f32::NAN]))[0].is_nan());
    assert_eq!(grid.round(&SVector::from([f32::INFINITY]))[0], f32::INFINITY);
}

#[test]
fn an_output_beyond_its_limit_saturates() {
    let frame = measurement::<f32, 2>(Tick(5), [1e9, -1e9]);
    let bus = packed::<f32>(&frame).unwrap();
    assert_eq!(bus.data[..6], [5, 0, 0xff, 0x7f, 0x01, 0x80]);
    let full = unpacked::<f32>(&bus, Tick(5)).unwrap();
    let read = decode_measurement::<f32, 2>(&full).unwrap();
    assert_eq!(read.output, SVector::from([0.25 * 32767.0, -32767.0 / 1024.0]));
}

#[test]
fn what_does_not_fit_or_is_damaged_is_not_packed() {
    let four = control::<f32, 1>(Tick(0), &[input(1); 4]);
    assert_eq!(packed::<f32>(&four), Err(PackError::Decode(DecodeError::Capacity(4))));
    assert_eq!(packed::<f32>(&control::<f32, 1>(Tick(0), &[])), Err(PackError::Values(0)));
    let six = acknowledgement::<f32>(Tick(9), &[Age::Empty; 6]);
    assert_eq!(packed::<f32>(&six), Err(PackError::Cycles(6)));
    let mut damaged = measurement::<f32, 2>(Tick(0), [0.0; 2]);
    damaged[9] ^= 1;
    assert_eq!(packed::<f32>(&damaged), Err(PackError::Decode(DecodeError::Checksum)));
    let other = measurement::<f64, 2>(Tick(0), [0.0; 2]);
    assert_eq!(packed::<f32>(&other), Err(PackError::Decode(DecodeError::Scalar(8))));
    assert_eq!(packed::<f32>(&[]), Err(PackError::Decode(DecodeError::TooShort)));
    let coarse = Grid { largest_count: LARGEST_OF_FULL_FRAME, ..grid([1.0; 4]) };
    let wide = Compact::<f32, 2, 4>::new(DESIGN, identifiers(), grid([1.0; 2]), coarse).unwrap();
    let two = control(Tick(0), &[SVector::from([1.0_f32, 2.0]); 2]);
    assert_eq!(wide.pack::<BusFrame>(&two), Err(PackError::Values(4)));
    let many = measurement::<f32, 4>(Tick(0), [0.0; 4]);
    assert_eq!(wide.pack::<BusFrame>(&many), Err(PackError::Values(4)));
}

#[test]
fn three_values_whose_grid_has_counts_of_sixteen_bits_are_refused_both_ways() {
    let fine = Compact::<f32, 1, 2>::new(DESIGN, identifiers(), grid([1.0]), grid([1.0; 2])).unwrap();
    let ones = |length| control(Tick(0), &vec![SVector::from([1.0_f32]); length]);
    assert!(fine.pack::<BusFrame>(&ones(2)).is_ok());
    assert_eq!(fine.pack::<BusFrame>(&ones(3)), Err(PackError::Counts(3)));
    let three = packed::<f32>(&control(Tick(0), &[input::<f32>(1); 3])).unwrap();
    assert_eq!(fine.unpack(&three, Tick(0), &mut [0; 64]), Err(UnpackError::Length(8)));
    // Where every frame has three values, the form itself is refused.
    let built = |largest_count| {
        let outputs = Grid { largest_count, ..grid([1.0; 3]) };
        Compact::<f32, 1, 3>::new(DESIGN, identifiers(), grid([1.0]), outputs).err()
    };
    assert_eq!((built(4095), built(4096)), (None, Some(InvalidCompact::Grid)));
}

#[test]
fn a_tick_is_restored_up_to_32767_cycles_off_across_any_wrap() {
    for now in [0, 1, 0x7fff, 0x8000, 0xffff, 0x0001_0000, 0x7fff_ffff, 0x8000_0000, u32::MAX - 5, u32::MAX] {
        for off in [-32768_i32, -32767, -32766, -1, 0, 1, 2, 32766, 32767] {
            let sent = Tick(now.wrapping_add_signed(off));
            assert_eq!(nearest_tick(sent.0 as u16, Tick(now)), sent, "{off} from {now:#x}");
        }
        // One cycle more, and it passes for another.
        let sent = Tick(now.wrapping_sub(32769));
        assert_eq!(nearest_tick(sent.0 as u16, Tick(now)), sent + 65536);
    }
}

#[test]
fn identifiers_that_are_not_distinct_and_steps_that_are_not_positive_are_refused() {
    let build =
        |identifiers, step| Compact::<f32, 1, 1>::new(DESIGN, identifiers, grid([step]), grid([1.0])).err();
    assert_eq!(build(identifiers(), 1.0), None);
    let shared = Identifiers { control: standard(0x120), ..identifiers() };
    assert_eq!(build(shared, 1.0), Some(InvalidCompact::Identifiers));
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY, 2e34] {
        assert_eq!(build(identifiers(), step), Some(InvalidCompact::Grid), "{step}");
    }
}

#[test]
fn foreign_and_remote_frames_and_small_buffers_are_refused() {
    let frame = checked(0x121, &[1, 0, 2, 0], Tick(0));
    let at = |frame: &BusFrame| unpacked::<f32>(frame, Tick(0));
    assert!(at(&frame).is_ok());
    assert_eq!(at(&BusFrame { id: standard(0x7ff), ..frame.clone() }), Err(UnpackError::Identifier));
    let extended = embedded_can::ExtendedId::new(0x121).unwrap();
    assert_eq!(at(&BusFrame { id: extended.into(), ..frame.clone() }), Err(UnpackError::Identifier));
    let remote = BusFrame::new_remote(standard(0x121), 4).unwrap();
    assert_eq!(at(&remote), Err(UnpackError::Remote));
    let small = compact::<f32>().unpack(&frame, Tick(0), &mut [0; 16]).map(<[u8]>::len);
    assert_eq!(small, Err(UnpackError::Encode(EncodeError::BufferTooSmall)));
}

#[test]
fn each_kind_comes_in_its_own_lengths_only() {
    for len in 0..=64 {
        for (id, fits) in
            [(0x120, len == 7), (0x121, [5, 7, 8].contains(&len)), (0x122, (4..=8).contains(&len))]
        {
            let frame = match len {
                0 => BusFrame { id: standard(id), is_remote: false, data: vec![] },
                _ => checked(id, &vec![0; len - 1], Tick(0)),
            };
            let expected = if fits { None } else { Some(UnpackError::Length(len)) };
            assert_eq!(unpacked::<f32>(&frame, Tick(0)).err(), expected, "{len} bytes as {id:#x}");
        }
    }
}

#[test]
fn the_reserved_count_and_those_beyond_the_grid_are_refused() {
    let sent = |count: i16| checked(0x121, &[&[1, 0][..], &count.to_le_bytes()].concat(), Tick(0));
    assert_eq!(unpacked::<f32>(&sent(i16::MIN), Tick(0)), Err(UnpackError::Count));
    // Three of 13 bits: -4096 in any place, and the bit that is left over.
    for (bits, is_read) in
        [(0, true), (0x1000, false), (0x1000 << 13, false), (0x1000 << 26, false), (1 << 39, false)]
    {
        let counts: [u8; 8] = u64::to_le_bytes(bits);
        let frame = checked(0x121, &[&[1, 0][..], &counts[..5]].concat(), Tick(0));
        let expected = if is_read { None } else { Some(UnpackError::Count) };
        assert_eq!(unpacked::<f32>(&frame, Tick(0)).err(), expected, "{bits:#x}");
    }
    let coarse = Grid { largest_count: 100, ..grid([1.0]) };
    let coarse = Compact::<f32, 1, 1>::new(DESIGN, identifiers(), coarse, grid([1.0])).unwrap();
    let read = |count| coarse.unpack(&sent(count), Tick(0), &mut [0; 64]).map(<[u8]>::len);
    assert_eq!([-101, -100, 100, 101].map(|count| read(count).is_ok()), [false, true, true, false]);
}

/// Whatever comes out is a frame that its receiver can read, with finite values.
fn never_misread<T: Scalar>(frame: &BusFrame, now: Tick) {
    let Ok(full) = unpacked::<T>(frame, now) else { return };
    let takers = [
        decode_measurement::<T, 2>(&full).is_ok_and(|read| read.output.iter().all(|value| value.is_finite())),
        lent::decoded::<T, 1>(&full, 3).is_ok_and(|read| read.is_finite() && !read.inputs.is_empty()),
        decode_acknowledgement::<T>(&full).is_ok(),
    ];
    assert_eq!(takers.iter().filter(|&&taken| taken).count(), 1);
    assert_eq!(packed::<T>(&full).as_ref(), Ok(frame));
}

#[test]
fn any_two_bytes_in_any_place_are_refused_or_read_as_what_they_pack_to() {
    for pair in 0..=u16::MAX {
        for (id, len) in [(0x120, 6), (0x121, 4), (0x121, 7), (0x122, 3), (0x122, 7), (0x123, 4)] {
            for at in [0, len - 2] {
                let mut data = vec![0; len];
                data[at..at + 2].copy_from_slice(&pair.to_le_bytes());
                never_misread::<f32>(&checked(id, &data, Tick(0x8000)), Tick(0x8000));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn garbage_is_refused_or_read_as_what_it_packs_to(
        id in 0x11f_u16..0x124,
        is_remote in proptest::bool::weighted(0.1),
        data in proptest::collection::vec(prop_oneof![any::<u8>(), Just(0x80), Just(0xff), Just(0)], 0..12),
        now in any::<u32>(),
    ) {
        let frame = BusFrame { is_remote, ..checked(id, &data, Tick(now)) };
        never_misread::<f32>(&frame, Tick(now));
        never_misread::<f64>(&frame, Tick(now));
        // Without a check that fits, too.
        let frame = BusFrame { id: standard(id), is_remote, data };
        never_misread::<f32>(&frame, Tick(now));
    }

    #[test]
    fn a_value_on_any_grid_is_its_own_nearest(mantissa in 1.0..2.0, exponent in -149..112, count in any::<i16>()) {
        grids_find_their_own_counts::<f32>(mantissa, exponent, count);
        grids_find_their_own_counts::<f64>(mantissa, 8 * exponent, count);
    }
}
