//! What frames on classic CAN are told by, as Rust source: the id of the design, and the [`slqg::wire::can::Grid`]s on which
//! values are counted.

use super::storage;
use crate::emit::literal::Table;
use crate::emit::{Emission, EmitError, design_id};
use nalgebra::DMatrix;

/// The grids; `None` if the design does not count its values.
pub(super) fn grids(emission: &Emission<'_>) -> Result<Option<String>, EmitError> {
    let Some(steps) = emission.design.steps() else { return Ok(None) };
    let scalar = emission.design.controller.scalar;
    let column = |name, steps: &[f64]| {
        storage(Table { name, scalar }, &DMatrix::from_column_slice(steps.len(), 1, steps), 4)
    };
    Ok(Some(format!(
        "\
/// Which plant frames on classic CAN belong to: their check fails where another one is expected.
pub const DESIGN_ID: slqg::blob::DesignId = slqg::blob::DesignId({id:#010x});

/// What inputs are counted in on classic CAN, in input units: [`DESIGN`] rounds them to it.
///
/// With it, [`DESIGN_ID`] and [`OUTPUT_GRID`] both ends make the same `slqg::wire::can::Compact`.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const INPUT_GRID: slqg::wire::can::Grid<Scalar, INPUTS> = slqg::wire::can::Grid {{
    step: {inputs},
    largest_count: {largest_input},
}};

/// What outputs are counted in on classic CAN, in output units.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const OUTPUT_GRID: slqg::wire::can::Grid<Scalar, OUTPUTS> = slqg::wire::can::Grid {{
    step: {outputs},
    largest_count: {largest_output},
}};
",
        id = design_id(emission.design).0,
        inputs = column("controller.input_limits", &steps.inputs.steps)?,
        largest_input = steps.inputs.largest_count,
        outputs = column("wire.output_limits", &steps.outputs.steps)?,
        largest_output = steps.outputs.largest_count,
    )))
}
