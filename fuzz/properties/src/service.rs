//! Frames between a node and its host: what is decoded is written again as the same bytes, and numbers of the loop are finite.

use crate::script::whole;
use crate::wire::{read, written};
use slqg::Scalar;
use slqg::wire::{
    Clock, DecodeError, GainsAnswer, Kind, Question, Ran, Service, Status, Tuned, decode_applied,
    decode_gains_part, decode_reference, decode_service, encode_applied, encode_gains_part, encode_reference,
    encode_service,
};

/// Samples of a reference that there is room for.
const SAMPLES: usize = 4;

/// Reads the bytes as each kind of frame; then with their last four replaced by the checksum that they should have.
pub fn check(bytes: &[u8]) {
    for bytes in [bytes, &whole(bytes)] {
        of_scalar::<f32>(bytes);
        of_scalar::<f64>(bytes);
    }
}

fn of_scalar<T: Scalar>(bytes: &[u8]) {
    let kinds = [
        fixed::<T, Clock>(bytes),
        fixed::<T, Ran>(bytes),
        fixed::<T, GainsAnswer>(bytes),
        fixed::<T, Question>(bytes),
        fixed::<T, Status>(bytes),
        fixed::<T, Tuned>(bytes),
        applied::<T, 1>(bytes),
        applied::<T, 3>(bytes),
        gains_part::<T>(bytes),
        reference::<T, 1>(bytes),
        reference::<T, 2>(bytes),
    ];
    let mut read = kinds.into_iter().flatten();
    let Some(kind) = read.next() else { return };
    assert_eq!(Kind::of(bytes), Some(kind), "it says what it is");
    assert_eq!(read.next(), None, "it is of one kind and dimension");
}

/// A payload of fixed length.
fn fixed<T: Scalar, S: Service>(bytes: &[u8]) -> Option<Kind> {
    let (tick, service) = read(decode_service::<T, S>(bytes))?;
    written(bytes, |buffer| encode_service::<T, S>(tick, &service, buffer).map(<[u8]>::len));
    Some(S::KIND)
}

fn applied<T: Scalar, const NU: usize>(bytes: &[u8]) -> Option<Kind> {
    let applied = read(decode_applied::<T, NU>(bytes))?;
    assert!(applied.input.iter().all(|value| value.is_finite()));
    written(bytes, |buffer| encode_applied(&applied, buffer).map(<[u8]>::len));
    Some(Kind::Applied)
}

fn gains_part<T: Scalar>(bytes: &[u8]) -> Option<Kind> {
    let part = read(decode_gains_part::<T>(bytes))?;
    written(bytes, |buffer| encode_gains_part::<T>(&part, buffer).map(<[u8]>::len));
    Some(Kind::GainsPart)
}

fn reference<T: Scalar, const NZ: usize>(bytes: &[u8]) -> Option<Kind> {
    let decoded = decode_reference::<T, NZ, SAMPLES>(bytes);
    if let Err(DecodeError::Capacity(found)) = decoded {
        assert!(usize::from(found) > SAMPLES, "there is room for so many");
    }
    let reference = read(decoded)?;
    assert!(reference.samples.iter().flatten().all(|value| value.is_finite()));
    written(bytes, |buffer| encode_reference(&reference, buffer).map(<[u8]>::len));
    Some(Kind::Reference)
}
