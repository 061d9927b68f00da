//! Frames of the loop: what is decoded is finite, is written again as the same bytes, and is one kind of frame only.

use crate::script::whole;
use slqg::Scalar;
use slqg::nalgebra::SVector;
use slqg::wire::{
    self, DecodeError, EncodeError, Kind, RawFrame, decode_acknowledgement, decode_control,
    decode_measurement, encode_acknowledgement, encode_control, encode_measurement, frame_len,
};

/// Inputs that a receiver of control frames has room for.
const ROOM: usize = 6;
/// Zeros that a carrier may put behind a frame.
const PADDING: usize = 3;

/// Reads the bytes as each kind of frame; then with their last four replaced by the checksum that they should have.
pub fn check(bytes: &[u8]) {
    for bytes in [bytes, &whole(bytes)] {
        of_scalar::<f32>(bytes);
        of_scalar::<f64>(bytes);
        in_parts(bytes);
    }
}

fn of_scalar<T: Scalar>(bytes: &[u8]) {
    let kinds = [
        measurement::<T, 1>(bytes),
        measurement::<T, 2>(bytes),
        measurement::<T, 5>(bytes),
        control::<T, 1>(bytes),
        control::<T, 2>(bytes),
        acknowledgement::<T>(bytes),
    ];
    let mut read = kinds.into_iter().flatten();
    let Some(kind) = read.next() else { return };
    assert_eq!(Kind::of(bytes), Some(kind), "it says what it is");
    // Of a control frame without inputs nothing tells the dimension but its byte.
    assert_eq!(read.next(), None, "it is of one kind and dimension");
    assert_eq!(frame_len(bytes), Some(bytes.len()), "its end is found");
    let padded = [bytes, &[0; PADDING]].concat();
    assert_eq!(frame_len(&padded), Some(bytes.len()), "its end is found behind padding");
}

fn measurement<T: Scalar, const NY: usize>(bytes: &[u8]) -> Option<Kind> {
    let measurement = read(decode_measurement::<T, NY>(bytes))?;
    assert!(measurement.output.iter().all(|value| value.is_finite()));
    written(bytes, |buffer| encode_measurement(&measurement, buffer).map(<[u8]>::len));
    Some(Kind::Measurement)
}

fn control<T: Scalar, const NU: usize>(bytes: &[u8]) -> Option<Kind> {
    let mut room = [SVector::<T, NU>::zeros(); ROOM];
    let sequence = read(decode_control(bytes, &mut room))?;
    assert!(sequence.is_finite() && sequence.inputs.iter().flatten().all(|value| value.is_finite()));
    written(bytes, |buffer| encode_control(&sequence, buffer).map(<[u8]>::len));
    Some(Kind::Control)
}

fn acknowledgement<T: Scalar>(bytes: &[u8]) -> Option<Kind> {
    let told = read(decode_acknowledgement::<T>(bytes))?;
    assert!((1..=wire::MOST_AGES).contains(&told.ages.len()));
    written(bytes, |buffer| encode_acknowledgement::<T>(&told, buffer).map(<[u8]>::len));
    Some(Kind::Acknowledgement)
}

/// What was decoded; of an error, that it says something.
pub(crate) fn read<V>(decoded: Result<V, DecodeError>) -> Option<V> {
    decoded.inspect_err(|error| assert!(!error.to_string().is_empty())).ok()
}

/// Writes what was read from `bytes`: the same come out, in a buffer that is just long enough and in no shorter one.
pub(crate) fn written(bytes: &[u8], encode: impl Fn(&mut [u8]) -> Result<usize, EncodeError>) {
    let len = bytes.len();
    let mut buffer = vec![0xa5; len];
    assert_eq!(encode(&mut buffer), Ok(len), "there is room");
    assert_eq!(buffer, bytes, "the same bytes");
    assert_eq!(encode(&mut buffer[..len - 1]), Err(EncodeError::BufferTooSmall));
}

/// What a frame is cut into is all of it, and its end lies within.
fn in_parts(bytes: &[u8]) {
    assert!(frame_len(bytes).is_none_or(|len| (1..=bytes.len()).contains(&len)));
    let Some(raw) = RawFrame::of(bytes) else {
        assert!(bytes.len() < wire::OVERHEAD && Kind::of(bytes).is_none());
        return;
    };
    let head = [raw.version(), raw.kind_number(), raw.scalar_bytes()];
    let end = &bytes[bytes.len() - (wire::OVERHEAD - 7)..];
    assert_eq!([&head, &raw.tick().0.to_le_bytes()[..], raw.payload(), end].concat(), bytes);
    assert_eq!(raw.is_whole(), whole(bytes) == bytes, "the checksum is the one of the wire format");
}
