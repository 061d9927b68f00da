//! What values are counted in on classic CAN, as Rust source: two [`slqg::wire::can::Grid`]s.

use super::storage;
use crate::emit::literal::Table;
use crate::emit::{Emission, EmitError};
use nalgebra::DMatrix;

/// The grids; `None` if the design does not count its values.
pub(super) fn grids(emission: &Emission<'_>) -> Result<Option<String>, EmitError> {
    let Some(steps) = emission.design.wire.steps() else { return Ok(None) };
    let scalar = emission.design.controller.scalar;
    let column = |name, steps: &[f64]| {
        storage(Table { name, scalar }, &DMatrix::from_column_slice(steps.len(), 1, steps), 4)
    };
    Ok(Some(format!(
        "\
/// What inputs are counted in on classic CAN, in input units: [`DESIGN`] rounds them to it.
///
/// With it and [`OUTPUT_GRID`] both ends make the same `slqg::wire::can::Compact`.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const INPUT_GRID: slqg::wire::can::Grid<Scalar, INPUTS> = slqg::wire::can::Grid {{
    step: {inputs},
    largest_count: slqg::wire::can::LARGEST_COUNT,
}};

/// What outputs are counted in on classic CAN, in output units.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const OUTPUT_GRID: slqg::wire::can::Grid<Scalar, OUTPUTS> = slqg::wire::can::Grid {{
    step: {outputs},
    largest_count: slqg::wire::can::LARGEST_COUNT,
}};
",
        inputs = column("controller.input_limits", &steps.inputs)?,
        outputs = column("wire.output_limits", &steps.outputs)?,
    )))
}
