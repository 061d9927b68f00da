//! What a device needs that solves its own gains, as Rust source: a [`slqg::tuning::Basis`].

use super::{PER_LINE, default_input};
use crate::emit::literal::Table;
use crate::emit::{Emission, EmitError};
use crate::solve::LoopProblem;

/// Cost and link; `None` if the design has tables that would not follow the link, and no tuner takes it.
pub(super) fn basis(emission: &Emission<'_>) -> Result<Option<String>, EmitError> {
    let design = emission.design;
    if emission.task.is_some() || design.tracking.is_some() || design.event.is_some() {
        return Ok(None);
    }
    let table = |name| Table { name, scalar: design.controller.scalar };
    Ok(Some(format!(
        "\
/// What the law was computed from beside [`MODEL`]: hand it to [`Tuner`], which computes it again when the link has changed.
///
/// `Q` and `R` by rows, and `P(delay > d)` of the link from controller to actuator, `d` in cycles.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const TUNING: slqg::tuning::Basis<'static, Scalar> = slqg::tuning::Basis {{
    state_cost: &[
{q}    ],
    input_cost: &[
{r}    ],
    survival: &[
{survival}    ],
    default_input: {default},
}};

/// Numbers of memory that a [`Tuner`] is lent.
pub const TUNING_MEMORY: usize = slqg::tuning::tuner_len(&TUNING, STATES, INPUTS);

/// Numbers of memory that a [`slqg::bank::Bank`] for laws of this design is lent.
#[rustfmt::skip]
pub const BANK_MEMORY: usize = slqg::bank::memory_len(&slqg::blob::Shape {{
    length: SEQUENCE_LENGTH,
    states: STATES,
    inputs: INPUTS,
    default_input: {default},
}});

/// A tuner for this design.
#[rustfmt::skip]
pub type Tuner<'memory> = slqg::tuning::Tuner<'memory, Scalar, STATES, INPUTS>;
",
        q = table("cost.q").rows(&design.cost.q, 8)?,
        r = table("cost.r").rows(&design.cost.r, 8)?,
        survival = table("network.controller_to_actuator").lines(
            &LoopProblem::of(design).survival(),
            PER_LINE,
            8
        )?,
        default = default_input(emission),
    )))
}
