//! What is believed of the measurements, and what the plant gets where packets fail to come.

use super::{Emission, EmitError, storage};
use crate::emit::literal::Table;
use nalgebra::DMatrix;

/// The constant of `[safety]` for the controller.
pub(super) fn plausibility(emission: &Emission<'_>) -> Result<String, EmitError> {
    let safety = &emission.design.safety;
    let table = Table { name: "safety", scalar: emission.design.controller.scalar };
    let (acknowledgement, merging) = (&emission.design.network.acknowledgement, emission.merging());
    let gate = safety.threshold(acknowledgement, merging).map(|gate| table.number(gate)).transpose()?;
    let range = match &safety.range {
        None => "None".to_string(),
        Some(pairs) => {
            let pair = |(least, most): &(f64, f64)| {
                Ok::<_, EmitError>(format!("[{}, {}]", table.number(*least)?, table.number(*most)?))
            };
            let pairs: Vec<_> = pairs.iter().map(pair).collect::<Result<_, _>>()?;
            format!("Some([{}])", pairs.join(", "))
        }
    };
    Ok(format!(
        "\
/// What is believed of the measurements, and how many cycles without one are too many.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub static PLAUSIBILITY: slqg::estimator::Plausibility<Scalar, OUTPUTS> = slqg::estimator::Plausibility {{
    gate: {gate},
    doubt_after: {doubt_after},
    range: {range},
    stuck_after: {stuck_after:?},
    rejects_stuck: {rejects_stuck},
    stale_after: {stale_after},
    lost_after: {lost_after},
}};
",
        gate = gate.map_or("None".into(), |gate| format!("Some({gate})")),
        doubt_after = safety.doubt_after,
        stuck_after = safety.stuck_after,
        rejects_stuck = safety.rejects_stuck,
        stale_after = safety.stale_after,
        lost_after = safety.lost_after,
    ))
}

/// The safe input, if the actuator has one beside the default input.
pub(super) fn safe(emission: &Emission<'_>) -> Result<String, EmitError> {
    let table = Table { name: "safety.safe_input", scalar: emission.design.controller.scalar };
    let Some((after, input)) = &emission.design.safety.safe else { return Ok("None".into()) };
    let input = storage(table, &DMatrix::from_column_slice(input.len(), 1, input), 8)?;
    Ok(format!("Some(slqg::actuator::Safe {{\n        after: {after},\n        input: {input},\n    }})"))
}
