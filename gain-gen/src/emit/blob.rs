//! The gains as bytes that a device loads at run time; the layout is [`slqg::blob`]'s.

use super::literal::Table;
use super::{Emission, EmitError, design_id};
use crate::design::DeviceScalar;
use slqg::Scalar;
use slqg::blob::{self, Shape};
use slqg::gains::Tables;

/// The blob of `emission`'s law in the device's scalar.
pub(super) fn bytes(emission: &Emission<'_>) -> Result<Vec<u8>, EmitError> {
    match emission.design.controller.scalar {
        DeviceScalar::F32 => encoded::<f32>(emission),
        DeviceScalar::F64 => encoded::<f64>(emission),
    }
}

fn encoded<T: Scalar>(emission: &Emission<'_>) -> Result<Vec<u8>, EmitError> {
    let (law, scalar) = (emission.law, emission.design.controller.scalar);
    let rounded = |name, values: &[f64]| -> Result<Vec<T>, EmitError> {
        let table = Table { name, scalar };
        values.iter().map(|&value| table.fits(value).map(|()| T::nearest(value))).collect()
    };
    let lx = rounded("Lx", law.lx.transpose().as_slice())?;
    let m = rounded("M", law.m.transpose().as_slice())?;
    let arrival = rounded("r", &law.arrival)?;
    let shape = Shape {
        length: law.length,
        states: law.lx.ncols(),
        inputs: law.inputs(),
        default_input: law.default_input,
    };
    let mut buffer = vec![0; blob::encoded_len(&shape, T::BYTES)];
    let tables = Tables::check(&lx, &m, &arrival).map_err(|error| EmitError::Blob(error.into()))?;
    blob::encode(design_id(emission.design), &shape, &tables, &mut buffer).map_err(EmitError::Blob)?;
    Ok(buffer)
}
