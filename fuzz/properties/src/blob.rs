//! Gains as bytes: what is loaded is finite and is written again as the same bytes; what is not leaves the storage alone.

use crate::script::{any_bytes, byte, number, up_to, whole, with_checksum};
use arbitrary::{Result, Unstructured};
use slqg::Scalar;
use slqg::blob::{self, BlobError, DesignId, Header, encoded_len, header, load, storage_len};
use slqg::gains::Tables;

/// Numbers that the loader has room for.
const ROOM: usize = 96;

/// Takes the bytes for a blob, then with their last four replaced by the checksum that they should have, then as a script that
/// makes one.
pub fn check(bytes: &[u8]) {
    every_loader(bytes);
    every_loader(&whole(bytes));
    if let Ok(blob) = made(&mut Unstructured::new(bytes)) {
        every_loader(&blob);
    }
}

/// A blob whose dimensions are small and whose tables are mostly as long as these say.
pub(crate) fn made(script: &mut Unstructured<'_>) -> Result<Vec<u8>> {
    let scalar_bytes = if byte(script)? & 1 == 0 { 4 } else { 8 };
    let (hold, length) = (up_to(script, 2)?, up_to(script, 4)?);
    let (states, inputs) = (up_to(script, 3)?, up_to(script, 2)?);
    let mut bytes = [&b"slqg"[..], &[1, scalar_bytes, hold, length, states, 0, inputs, 0]].concat();
    bytes.extend(script.arbitrary::<[u8; 4]>()?);
    let (length, states, inputs) = (usize::from(length), usize::from(states), usize::from(inputs));
    let expected = if hold == 1 { length } else { length.saturating_sub(1) };
    let numbers = length * inputs * (states + expected * inputs);
    for _ in 0..numbers {
        push(&mut bytes, script, scalar_bytes, 1.0)?;
    }
    for _ in 0..length * length.saturating_sub(1) / 2 {
        push(&mut bytes, script, scalar_bytes, 0.1)?;
    }
    bytes.extend(any_bytes(script)?.get(..usize::from(up_to(script, 1)?)).unwrap_or_default());
    Ok(with_checksum(&bytes))
}

fn push(bytes: &mut Vec<u8>, script: &mut Unstructured<'_>, scalar_bytes: u8, factor: f64) -> Result<()> {
    let value = number::<f64>(script)? * factor;
    match scalar_bytes {
        4 => bytes.extend((value as f32).to_le_bytes()),
        _ => bytes.extend(value.to_le_bytes()),
    }
    Ok(())
}

fn every_loader(bytes: &[u8]) {
    loader::<f32, 1, 1>(bytes);
    loader::<f32, 2, 1>(bytes);
    loader::<f64, 2, 1>(bytes);
    loader::<f64, 3, 2>(bytes);
}

fn loader<T: Scalar, const NX: usize, const NU: usize>(bytes: &[u8]) {
    const UNTOUCHED: f64 = 7.25;
    let found = header(bytes);
    let mut storage = [T::nearest(UNTOUCHED); ROOM];
    let loaded = load::<T, NX, NU>(bytes, &mut storage, None);
    let (gains, Header { design, scalar_bytes, shape }) = match (loaded, found) {
        (Ok(gains), Ok(found)) => (gains, found),
        (Ok(_), Err(error)) => panic!("loaded without a header: {error}"),
        (Err(error), found) => {
            assert!(!error.to_string().is_empty());
            assert!(found.is_ok() || found.err() == Some(error), "the header is refused for the same reason");
            let is_untouched = storage.iter().all(|value| *value == T::nearest(UNTOUCHED));
            return assert!(is_untouched || matches!(error, BlobError::Gains(_)));
        }
    };
    assert_eq!((scalar_bytes, shape.states, shape.inputs), (T::BYTES, NX, NU));
    assert_eq!((gains.length(), gains.default_input()), (shape.length, shape.default_input));
    assert_eq!(bytes.len(), encoded_len(&shape, scalar_bytes));
    assert!(shape.length > 0 && storage_len(&shape) <= ROOM);
    let numbers = &storage[..storage_len(&shape)];
    assert!(numbers.iter().all(|value| value.is_finite()));
    let (gains, chances) = numbers.split_at(numbers.len() - shape.length * (shape.length - 1) / 2);
    let (lx, m) = gains.split_at(shape.length * NU * NX);
    assert!(chances.iter().all(|chance| (0.0..=1.0).contains(&chance.widen())));
    let tables = Tables::check(lx, m, chances).expect("they were loaded");
    let mut again = vec![0xa5; bytes.len()];
    assert_eq!(blob::encode(design, &shape, &tables, &mut again).as_deref(), Ok(bytes), "the same bytes");
    let other = DesignId(!design.0);
    assert_eq!(load::<T, NX, NU>(bytes, &mut storage, Some(other)).err(), Some(BlobError::Design(design)));
}
