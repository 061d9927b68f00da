//! Time-varying gains of a task as Rust source: one checked [`slqg::gains::Gains`] a cycle.

use super::{PER_LINE, default_input};
use crate::emit::literal::Table;
use crate::emit::{Emission, EmitError, TaskGains};
use crate::figure::figure;

/// What stands where a steady-state design has its one law.
pub(super) fn gains(emission: &Emission<'_>, task: &TaskGains<'_>) -> Result<String, EmitError> {
    let horizon = task.gains;
    let scalar = emission.design.controller.scalar;
    let arrival = &horizon.laws[0].arrival;
    let mut laws = String::new();
    for law in &horizon.laws {
        laws.push_str(&format!(
            "    slqg::gains::Gains::<Scalar, STATES, INPUTS>::new(
        SEQUENCE_LENGTH,
        {default},
        slqg::gains::Tables {{
            lx: slqg::checked::Finite::<Scalar>::new(&[
{lx}            ]),
            m: slqg::checked::Finite::<Scalar>::new(&[
{m}            ]),
            arrival: slqg::checked::Probabilities::<Scalar>::new(&ARRIVAL),
        }},
    ),
",
            default = default_input(emission),
            lx = Table { name: "Lx", scalar }.rows(&law.lx, 16)?,
            m = Table { name: "M", scalar }.rows(&law.m, 16)?,
        ));
    }
    let (rows, states, expected) =
        (horizon.laws[0].lx.nrows(), horizon.laws[0].lx.ncols(), horizon.laws[0].m.ncols());
    Ok(format!(
        "\
/// Cycles of the task.
pub const CYCLES: usize = {cycles};

/// Conditional arrival probabilities `r(b, m)` of the link from controller to actuator, the same in every cycle.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
static ARRIVAL: [Scalar; {arrivals}] = [
{arrival}];

/// The control law of each cycle of the task, `U = Lx xhat + M vbar`: before cycle `k` hand `HORIZON[k]` to the
/// controller's `set_gains`.
///
/// `Lx` is {rows} x {states}, `M` {rows} x {expected}, both by rows. With the state known{ahead} the whole task is expected to
/// cost {cost}, its terminal cost included.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub static HORIZON: [slqg::gains::Gains<'static, Scalar, STATES, INPUTS>; CYCLES] = [
{laws}];
",
        cycles = horizon.laws.len(),
        arrivals = arrival.len(),
        arrival = Table { name: "r", scalar }.lines(arrival, PER_LINE, 4)?,
        ahead = if horizon.tracked.is_some() { " and the reference ahead," } else { "" },
        cost = figure(task.cost),
    ))
}
