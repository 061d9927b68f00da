//! Gains as bytes are what `docs/blob-format.md` says, and nothing else passes for gains.

use proptest::prelude::*;
use slqg::blob::{self, BlobError, DesignId, EncodeError, Header, Shape, encoded_len, load, storage_len};
use slqg::checked::{Finite, Probabilities};
use slqg::gains::{Gains, InvalidGains, Tables};
use slqg::{DefaultInput, Scalar};

/// Two inputs a sequence, two states, one input.
const ZERO: Shape = Shape { length: 2, states: 2, inputs: 1, default_input: DefaultInput::Zero };
/// One input a sequence, one state, two inputs: no arrival probability.
const HOLD: Shape = Shape { length: 1, states: 1, inputs: 2, default_input: DefaultInput::Hold };
const ID: DesignId = DesignId(0x1122_3344);

const ZERO_TABLES: Tables<'static, f32> = Tables {
    lx: Finite::<f32>::new(&[-1.0, -2.0, 0.5, 0.1]),
    m: Finite::<f32>::new(&[0.25, -0.0]),
    arrival: Probabilities::<f32>::new(&[0.75]),
};
const HOLD_TABLES: Tables<'static, f64> = Tables {
    lx: Finite::<f64>::new(&[-1.0, 0.1]),
    m: Finite::<f64>::new(&[0.5, 0.0, 0.0, 0.5]),
    arrival: Probabilities::<f64>::new(&[]),
};

/// CRC-32/ISCSI bit by bit, as the page defines it.
fn checksum(content: &[u8]) -> u32 {
    !content.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ if crc & 1 == 1 { 0x82F6_3B78 } else { 0 })
    })
}

/// `content` with the checksum that fits.
fn sealed(content: &[u8]) -> Vec<u8> {
    [content, &checksum(content).to_le_bytes()].concat()
}

fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).expect("two digits a byte")).collect()
}

/// The first example of the page.
fn zero_blob() -> Vec<u8> {
    bytes(
        "73 6c 71 67 01 04 00 02 02 00 01 00 44 33 22 11 \
         00 00 80 bf 00 00 00 c0 00 00 00 3f cd cc cc 3d \
         00 00 80 3e 00 00 00 80 00 00 40 3f 4a ca a3 44",
    )
}

/// The second one.
fn hold_blob() -> Vec<u8> {
    bytes(
        "73 6c 71 67 01 08 01 01 01 00 02 00 44 33 22 11 \
         00 00 00 00 00 00 f0 bf 9a 99 99 99 99 99 b9 3f \
         00 00 00 00 00 00 e0 3f 00 00 00 00 00 00 00 00 \
         00 00 00 00 00 00 00 00 00 00 00 00 00 00 e0 3f 1a 60 28 b9",
    )
}

/// What becomes of `ZERO`'s blob when `change` is made to what the checksum covers.
fn altered(change: impl FnOnce(&mut Vec<u8>)) -> Result<(), BlobError> {
    let blob = zero_blob();
    let mut content = blob[..blob.len() - 4].to_vec();
    change(&mut content);
    load::<f32, 2, 1>(&sealed(&content), &mut [0.0; 16], Some(ID)).map(|_| ())
}

#[test]
fn laws_are_written_as_the_golden_bytes() {
    let mut buffer = [0xAA; 128];
    let zero = blob::encode(ID, &ZERO, &ZERO_TABLES, &mut buffer).unwrap();
    assert_eq!(zero, zero_blob());
    assert_eq!(zero.len(), encoded_len(&ZERO, f32::BYTES));
    let hold = blob::encode(ID, &HOLD, &HOLD_TABLES, &mut buffer).unwrap();
    assert_eq!(hold, hold_blob());
    assert_eq!(hold.len(), encoded_len(&HOLD, f64::BYTES));
}

#[test]
fn golden_bytes_are_read_as_the_laws() {
    assert_eq!(storage_len(&ZERO), 7);
    let mut storage = [9.0; 8];
    let law: Gains<'_, f32, 2, 1> = load(&zero_blob(), &mut storage, Some(ID)).unwrap();
    assert_eq!(law, Gains::<f32, 2, 1>::new(2, DefaultInput::Zero, ZERO_TABLES));
    assert_eq!(storage[5].to_bits(), (-0.0_f32).to_bits(), "a sign was lost");
    assert_eq!(storage[7], 9.0, "storage beyond the tables is not touched");

    assert_eq!(storage_len(&HOLD), 6);
    let mut storage = [9.0; 6];
    let law: Gains<'_, f64, 1, 2> = load(&hold_blob(), &mut storage, None).unwrap();
    assert_eq!(law, Gains::<f64, 1, 2>::new(1, DefaultInput::Hold, HOLD_TABLES));
    assert_eq!(blob::header(&hold_blob()), Ok(Header { design: ID, scalar_bytes: 8, shape: HOLD }));
}

#[test]
fn every_truncation_is_refused() {
    let blob = zero_blob();
    for length in 0..blob.len() {
        let outcome = load::<f32, 2, 1>(&blob[..length], &mut [0.0; 16], None).map(|_| ());
        let expected = if length < blob::OVERHEAD { BlobError::TooShort } else { BlobError::Checksum };
        assert_eq!(outcome, Err(expected), "{length} bytes");
    }
    assert_eq!(altered(|content| content.truncate(content.len() - 1)), Err(BlobError::Length));
    assert_eq!(altered(|content| content.push(0)), Err(BlobError::Length));
}

#[test]
fn every_single_bit_flip_is_refused() {
    for (blob, hold) in [(zero_blob(), false), (hold_blob(), true)] {
        for bit in 0..8 * blob.len() {
            let mut damaged = blob.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            let outcome = if hold {
                load::<f64, 1, 2>(&damaged, &mut [0.0; 16], None).map(|_| ())
            } else {
                load::<f32, 2, 1>(&damaged, &mut [0.0; 16], None).map(|_| ())
            };
            assert_eq!(outcome, Err(BlobError::Checksum), "bit {bit}");
        }
    }
}

#[test]
fn a_blob_for_something_else_is_refused_by_what_it_is_for() {
    assert_eq!(altered(|_| ()), Ok(()));
    assert_eq!(altered(|content| content[0] = b'S'), Err(BlobError::Magic));
    assert_eq!(altered(|content| content[4] = 2), Err(BlobError::Version(2)));
    assert_eq!(altered(|content| content[5] = 2), Err(BlobError::Scalar(2)));
    assert_eq!(altered(|content| content[6] = 2), Err(BlobError::DefaultInput(2)));
    assert_eq!(altered(|content| content[7] = 3), Err(BlobError::Length));
    assert_eq!(altered(|content| content[12] = 0x45), Err(BlobError::Design(DesignId(0x1122_3345))));

    let blob = zero_blob();
    let storage = &mut [0.0_f32; 16];
    assert_eq!(load::<f32, 3, 1>(&blob, storage, None).unwrap_err(), BlobError::States(2));
    assert_eq!(load::<f32, 2, 2>(&blob, storage, None).unwrap_err(), BlobError::Inputs(1));
    assert_eq!(load::<f64, 2, 1>(&blob, &mut [0.0; 16], None).unwrap_err(), BlobError::Scalar(4));
    let short = &mut storage[..6];
    assert_eq!(load::<f32, 2, 1>(&blob, short, None).unwrap_err(), BlobError::StorageTooSmall { needed: 7 });
    assert_eq!(*storage, [0.0; 16], "refused gains left something in the storage");
    assert!(load::<f32, 2, 1>(&blob, storage, None).is_ok(), "without an expected design any is taken");
}

#[test]
fn numbers_that_are_no_gains_or_no_probabilities_are_refused() {
    let number = |at: usize, value: f32| {
        altered(|content| content[16 + 4 * at..][..4].copy_from_slice(&value.to_le_bytes()))
    };
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for at in 0..6 {
            assert_eq!(number(at, value), Err(BlobError::Gains(InvalidGains::NotFinite)), "{at}: {value}");
        }
    }
    for value in [f32::NAN, -0.1, 1.1] {
        assert_eq!(number(6, value), Err(BlobError::Gains(InvalidGains::NotAProbability)), "{value}");
    }
    // A law without inputs has no tables, and dimensions beyond all memory have no bytes to match them.
    let header = |dimensions: [u8; 5]| {
        altered(|content| {
            content[7..12].copy_from_slice(&dimensions);
            content.truncate(16);
        })
    };
    assert_eq!(header([0, 2, 0, 1, 0]), Err(BlobError::Gains(InvalidGains::NoInputs)));
    assert_eq!(header([255; 5]), Err(BlobError::Length));
}

#[test]
fn what_could_not_be_loaded_is_not_written() {
    let buffer = &mut [0xAA; 128];
    let long = Shape { length: 256, ..ZERO };
    let wide = Shape { states: 65_536, ..ZERO };
    let many = Shape { inputs: 65_536, ..ZERO };
    for shape in [long, wide, many] {
        assert_eq!(blob::encode(ID, &shape, &ZERO_TABLES, buffer), Err(EncodeError::TooLarge));
    }
    let absurd = Shape { length: 255, states: 65_535, inputs: 65_535, ..ZERO };
    let three = Finite::<f32>::new(&[0.0; 3]);
    for (shape, tables, reason) in [
        (Shape { length: 0, ..ZERO }, ZERO_TABLES, InvalidGains::NoInputs),
        (absurd, ZERO_TABLES, InvalidGains::StateGainLength),
        (ZERO, Tables { lx: three, ..ZERO_TABLES }, InvalidGains::StateGainLength),
        (ZERO, Tables { m: three, ..ZERO_TABLES }, InvalidGains::InFlightGainLength),
        (
            ZERO,
            Tables { arrival: Probabilities::<f32>::new(&[]), ..ZERO_TABLES },
            InvalidGains::ArrivalLength,
        ),
    ] {
        assert_eq!(blob::encode(ID, &shape, &tables, buffer), Err(EncodeError::Gains(reason)));
    }
    assert_eq!(blob::encode(ID, &ZERO, &ZERO_TABLES, &mut buffer[..47]), Err(EncodeError::BufferTooSmall));
    assert_eq!(*buffer, [0xAA; 128], "nothing is written of what is refused");
    // Numbers that are no gains or no probabilities are in no tables that could be written.
    assert_eq!(Tables::check(&[0.0], &[0.0, f32::NAN], &[]), Err(InvalidGains::NotFinite));
    assert_eq!(Tables::check(&[0.0], &[], &[1.5_f32]), Err(InvalidGains::NotAProbability));
}

#[test]
fn an_id_is_a_checksum_and_reads_as_hexadecimal() {
    assert_eq!(DesignId::of(b"123456789"), DesignId(0xe306_9283));
    assert_eq!(DesignId(0x0a0b).to_string(), "0x00000a0b");
}

/// Whether any of a few loaders takes `blob`; none of them may panic.
fn anyone_takes(blob: &[u8]) -> bool {
    let _ = blob::header(blob);
    load::<f32, 2, 1>(blob, &mut [0.0; 64], None).is_ok()
        || load::<f64, 1, 2>(blob, &mut [0.0; 64], None).is_ok()
        || load::<f32, 0, 1>(blob, &mut [0.0; 64], None).is_ok()
        || load::<f64, 1, 0>(blob, &mut [], None).is_ok()
}

proptest! {
    #[test]
    fn no_bytes_make_a_loader_panic(content in proptest::collection::vec(any::<u8>(), 0..200)) {
        anyone_takes(&content);
        anyone_takes(&sealed(&content));
    }

    #[test]
    fn no_blob_with_a_proper_beginning_makes_a_loader_panic(
        scalar in prop_oneof![Just(4_u8), Just(8)],
        code in 0_u8..2,
        length in 0_u8..5,
        dimensions in (0_u8..4, 0_u8..4),
        tables in proptest::collection::vec(any::<u8>(), 0..400),
    ) {
        let (states, inputs) = dimensions;
        let header = [[1, scalar, code, length], [states, 0, inputs, 0], [0; 4]].concat();
        anyone_takes(&sealed(&[b"slqg", &header[..], &tables].concat()));
        // Once more with as many bytes as the dimensions ask for.
        let default_input = if code == 0 { DefaultInput::Zero } else { DefaultInput::Hold };
        let shape = Shape {
            length: length.into(), states: states.into(), inputs: inputs.into(), default_input,
        };
        let mut tables = tables;
        tables.resize(encoded_len(&shape, scalar) - blob::OVERHEAD, 0);
        let blob = sealed(&[b"slqg", &header[..], &tables].concat());
        prop_assert_eq!(blob::header(&blob).map(|header| header.shape), Ok(shape));
        anyone_takes(&blob);
    }

    #[test]
    fn gains_survive_the_bytes_to_the_bit(
        numbers in proptest::collection::vec(-1e30..1e30_f64, 6),
        arrival in 0.0..=1.0_f64,
        id in any::<u32>(),
    ) {
        let (lx, m) = numbers.split_at(4);
        let arrival = [arrival];
        let tables = Tables::check(lx, m, &arrival).unwrap();
        let mut buffer = [0; 128];
        let blob = blob::encode(DesignId(id), &ZERO, &tables, &mut buffer).unwrap();
        let mut storage = [0.0; 7];
        let law = load::<f64, 2, 1>(blob, &mut storage, Some(DesignId(id)));
        prop_assert_eq!(law, Ok(Gains::<f64, 2, 1>::check(2, DefaultInput::Zero, tables).unwrap()));
    }
}
